#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <multireach/bridge_request_t.hpp>
#include <multireach/images_t.hpp>
#include <multireach/node_status_t.hpp>
#include <multireach/obstacles_t.hpp>
#include <multireach/target_t.hpp>
#include <nlohmann/json.hpp>

#include "runtime/channels.hpp"
#include "tools/page/page_node.hpp"

namespace multireach {
namespace {

using Kind = Outgoing::Kind;
using json = nlohmann::json;

struct FakeBrowsers : Browsers {
  int count() const override { return number; }
  bool take_needs_all() override { return std::exchange(needs_all, false); }
  void send(Kind kind, std::string bytes) override { sent.emplace_back(kind, std::move(bytes)); }
  std::vector<std::string> take_requests() override { return std::exchange(requests, {}); }

  int number = 1;
  bool needs_all = false;
  std::vector<std::pair<Kind, std::string>> sent;
  std::vector<std::string> requests;
};

class Page : public ::testing::Test {
 protected:
  template <class Message>
  void receive(std::string_view channel, const Message& message) {
    node_.receive(channel, *encode(message), out_);
  }
  void tick(int ticks) {
    for (int i = 0; i < ticks; ++i) node_.tick(out_);
  }
  std::vector<json> sent(Kind kind) const {
    std::vector<json> found;
    for (const auto& [each, bytes] : browsers_.sent) {
      if (each == kind) found.push_back(json::parse(bytes));
    }
    return found;
  }
  /// The requests to the bridge that are no STATUS.
  std::vector<bridge_request_t> asked() const {
    std::vector<bridge_request_t> found;
    for (const OutMessage& message : out_) {
      if (message.channel != channel::kBridgeRequest) continue;
      const auto request = decode<bridge_request_t>(message.bytes);
      if (request && request->kind != bridge_request_t::STATUS) found.push_back(*request);
    }
    return found;
  }
  void hear_bridge() {
    bridge_state_t state{};
    state.run = 7;
    receive(channel::kBridgeState, state);
  }
  static target_t target(const std::string& name, double x) {
    target_t target{};
    target.name = name;
    target.position_m[0] = x;
    return target;
  }
  static images_t images(std::vector<int16_t> types) {
    images_t images{};
    images.image_types = std::move(types);
    for (size_t i = 0; i < images.image_types.size(); ++i) {
      image_t image{};
      image.width = image.height = 1;
      image.pixelformat = image_t::PIXEL_FORMAT_MJPEG;
      image.data = {0xff, 0xd8, 1, static_cast<uint8_t>(i)};
      image.size = 4;
      images.images.push_back(image);
    }
    images.n_images = static_cast<int32_t>(images.images.size());
    return images;
  }

  FakeBrowsers browsers_;
  PageNode node_{browsers_, {.utime = 5000000, .first_request = 100}};
  Outbox out_;
};

TEST_F(Page, SendsTheNewestOfEachTargetOnceWithAllItsFields) {
  receive(channel::kTarget, target("ball", 0.1));
  receive(channel::kTarget, target("card", 0.2));
  receive(channel::kTarget, target("ball", 0.3));
  tick(4);
  const auto frames = sent(Kind::kFrame);
  ASSERT_EQ(frames.size(), 2U);
  ASSERT_EQ(frames[0]["messages"].size(), 2U);
  const json& ball = frames[0]["messages"][0];
  EXPECT_EQ(ball["channel"], "TARGET");
  EXPECT_EQ(ball["message"]["name"], "ball");
  EXPECT_EQ(ball["message"]["position_m"], (json{0.3, 0.0, 0.0}));
  EXPECT_EQ(ball["message"]["covariance_m2"].size(), 3U);
  EXPECT_EQ(frames[0]["messages"][1]["message"]["name"], "card");
  EXPECT_TRUE(frames[1]["messages"].empty());
}

TEST_F(Page, ABrowserThatComesLaterGetsEverything) {
  receive(channel::kObstacles, obstacles_t{});
  tick(2);
  browsers_.needs_all = true;
  tick(2);
  EXPECT_EQ(sent(Kind::kFrame).at(1)["messages"].at(0)["channel"], "OBSTACLES");
}

TEST_F(Page, DoesNothingWhileNobodyLooks) {
  browsers_.number = 0;
  receive(channel::kTarget, target("ball", 0.1));
  receive(channel::kStereoImages, images({images_t::LEFT, images_t::RIGHT}));
  tick(200);
  EXPECT_TRUE(browsers_.sent.empty());
  EXPECT_TRUE(out_.empty());
  EXPECT_EQ(node_.state(), "no browser");
}

TEST_F(Page, CountsMessagesPerSecond) {
  tick(1);
  for (int i = 0; i < 30; ++i) receive(channel::kTarget, target("ball", 0.1));
  tick(52);
  EXPECT_EQ(sent(Kind::kFrame).back()["rates"]["TARGET"], 30);
}

TEST_F(Page, RefusesDamagedMessages) {
  node_.receive(channel::kTarget, std::vector<uint8_t>{1, 2, 3}, out_);
  node_.receive(channel::kRobotState, std::vector<uint8_t>(20, 0), out_);
  tick(2);
  EXPECT_EQ(node_.counters().refused, 2);
  EXPECT_TRUE(sent(Kind::kFrame).at(0)["messages"].empty());
}

TEST_F(Page, ASenderThatInventsNamesDoesNotFillTheMemory) {
  for (int i = 0; i < 1000; ++i) receive(channel::kTarget, target(fmt::format("t{}", i), 0));
  tick(2);
  EXPECT_EQ(sent(Kind::kFrame).at(0)["messages"].size(), 100U);
}

TEST_F(Page, AsksTheBridgeWhatTheUserAsks) {
  hear_bridge();
  browsers_.requests = {R"({"request": "pause"})"};
  tick(1);
  ASSERT_EQ(asked().size(), 1U);
  EXPECT_EQ(asked()[0].kind, bridge_request_t::PAUSE);
  EXPECT_EQ(asked()[0].run, bridge_request_t::ALL);
  bridge_state_t state{};
  state.run = 7;
  state.request = asked()[0].request;
  state.request_accepted = true;
  receive(channel::kBridgeState, state);
  tick(BridgeAsker::kOthersAnswer / BridgeAsker::kTickUs + 2);  // other bridges may answer, too
  ASSERT_EQ(sent(Kind::kAnswer).size(), 1U);
  EXPECT_EQ(sent(Kind::kAnswer)[0]["answer"], "pause");
  EXPECT_EQ(sent(Kind::kAnswer)[0]["accepted"], true);
}

TEST_F(Page, StopIsSentWithinATickAlsoWhileAnotherRequestWaits) {
  hear_bridge();
  browsers_.requests = {R"({"request": "speed", "speed": 0.25})"};
  tick(1);
  browsers_.requests = {R"({"request": "stop"})"};
  tick(1);
  ASSERT_EQ(asked().size(), 1U) << "the speed waits for the bridge's run, and is dropped by the stop";
  EXPECT_EQ(asked()[0].kind, bridge_request_t::DISABLE);
}

TEST_F(Page, RefusesWhatIsNoRequestWithASentence) {
  hear_bridge();
  const std::vector<std::string> bad{"",
                                     "[",
                                     "[1]",
                                     "7",
                                     "{}",
                                     R"({"request": 1})",
                                     R"({"request": "explode"})",
                                     R"({"request": "speed"})",
                                     R"({"request": "speed", "speed": "1"})",
                                     R"({"request": "speed", "speed": 1.01})",
                                     R"({"request": "speed", "speed": -0.1})",
                                     "{\"request\": \"\xff\"}"};
  browsers_.requests = bad;
  tick(1);
  EXPECT_EQ(sent(Kind::kAnswer).size(), bad.size());
  for (const json& answer : sent(Kind::kAnswer)) {
    EXPECT_EQ(answer["accepted"], false);
    EXPECT_FALSE(answer["text"].get<std::string>().empty());
  }
  EXPECT_TRUE(asked().empty());
}

TEST_F(Page, AsksASilentBridgeForItsStateOnceASecond) {
  tick(101);
  const auto requests = std::ranges::count(out_, channel::kBridgeRequest, &OutMessage::channel);
  EXPECT_EQ(requests, 3);
}

TEST_F(Page, AsksVisionToDrawOnlyForABrowserThatWantsItAndWhileVisionKeepsUp) {
  const auto asked_to_draw = [&] {
    out_.clear();
    tick(50);  // a second
    return std::ranges::count(out_, channel::kVisionDebugRequest, &OutMessage::channel);
  };
  tick(1);
  EXPECT_EQ(asked_to_draw(), 0) << "a browser that says nothing, and perhaps reads nothing";
  browsers_.requests = {R"({"contours": true})"};
  EXPECT_EQ(asked_to_draw(), 1);
  const auto draws = [&](int64_t late_us) {
    images_t seen = images({images_t::LEFT, images_t::RIGHT}), drawn = images({images_t::LEFT});
    seen.utime = 1000000 + late_us;
    drawn.utime = 1000000;
    receive(channel::kStereoImages, seen);
    receive(channel::kVisionDebug, drawn);
  };
  draws(PageNode::kVisionLate);
  EXPECT_EQ(asked_to_draw(), 1);
  draws(PageNode::kVisionLate + 1);
  for (int second = 0; second < 4; ++second) EXPECT_EQ(asked_to_draw(), 0) << second;
  EXPECT_EQ(sent(Kind::kFrame).back()["vision_late"], true);
  tick(50);
  EXPECT_EQ(asked_to_draw(), 1) << "it may keep up again";
  EXPECT_FALSE(sent(Kind::kFrame).back().contains("vision_late"));
  browsers_.number = 0;
  EXPECT_EQ(asked_to_draw(), 0);
  browsers_.number = 1;
  EXPECT_EQ(asked_to_draw(), 0) << "another browser, which said nothing";
}

TEST_F(Page, ShowsVisionsPicturesOrThoseOfTheCameras) {
  browsers_.requests = {R"({"contours": true})"};
  tick(1);
  browsers_.sent.clear();
  receive(channel::kStereoImages, images({images_t::RIGHT, images_t::LEFT}));
  ASSERT_EQ(browsers_.sent.size(), 2U);
  EXPECT_EQ(browsers_.sent[0].first, Kind::kRightPicture);
  EXPECT_EQ(browsers_.sent[1].first, Kind::kLeftPicture);
  EXPECT_EQ(browsers_.sent[1].second, std::string("\xff\xd8\x01\x01"));
  receive(channel::kStereoImages, images({images_t::LEFT, images_t::RIGHT}));
  EXPECT_EQ(browsers_.sent.size(), 2U) << "ten a second at most";
  receive(channel::kVisionDebug, images({images_t::LEFT}));
  ASSERT_EQ(browsers_.sent.size(), 3U);
  EXPECT_EQ(browsers_.sent[2].first, Kind::kPairPicture);
  tick(6);
  browsers_.sent.clear();
  receive(channel::kStereoImages, images({images_t::LEFT, images_t::RIGHT}));
  EXPECT_TRUE(browsers_.sent.empty()) << "vision's picture shows both";
  browsers_.requests = {R"({"contours": false})"};
  tick(1);
  receive(channel::kStereoImages, images({images_t::LEFT, images_t::RIGHT}));
  EXPECT_EQ(browsers_.sent.back().first, Kind::kRightPicture);
}

}  // namespace
}  // namespace multireach
