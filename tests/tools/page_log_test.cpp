#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <multireach/controller_state_t.hpp>
#include <multireach/images_t.hpp>
#include <multireach/robot_state_t.hpp>
#include <multireach/target_t.hpp>
#include <nlohmann/json.hpp>
#include <thread>

#include "runtime/channels.hpp"
#include "runtime/message.hpp"
#include "tests/temporary_folder.hpp"
#include "tools/page/log_answers.hpp"
#include "tools/page/log_index.hpp"
#include "tools/page/log_page.hpp"
#include "tools/page/run_comparison.hpp"

namespace multireach {
namespace {

using json = nlohmann::json;

constexpr int64_t kBegin = 1'700'000'000'000'000;  // us, of the recorder
const std::string kSource = MULTIREACH_SOURCE_DIR;

class PageLog : public ::testing::Test {
 protected:
  static target_t target(const std::string& name, int64_t utime, double x) {
    target_t message{};
    message.name = name;
    message.utime = utime;
    message.sequence = utime / 100000;
    message.status = utime < 500000 ? target_t::STATUS_LOST : target_t::STATUS_TRACKED;
    message.position_m[0] = x;
    return message;
  }

  /// A second of targets "ball" at 10 Hz and states at 100 Hz, received `delay_us` after their time. From `changed_us`
  /// on, the ball is elsewhere. `run`: the sender's.
  std::string write(const std::string& name, int64_t changed_us, int64_t run = 1, int64_t delay_us = 0) const {
    LogWriter log(folder_ / name);
    for (int64_t utime = 0; utime <= 1000000; utime += 10000) {
      robot_state_t state{};
      state.utime = utime;
      state.run = run;
      log.write(kBegin + delay_us + utime, channel::kRobotState, *encode(state));
      if (utime % 100000 != 0) continue;
      target_t ball = target("ball", utime, utime < changed_us ? 0.1 : 0.2);
      ball.run = run;
      log.write(kBegin + delay_us + utime, channel::kTarget, *encode(ball));
      if (utime == 0) log.write(kBegin + delay_us, channel::kTarget, *encode(target("cup", utime, 0.3)));
    }
    log.close();
    return folder_ / name;
  }

  const testing::TemporaryFolder folder_;
};

TEST_F(PageLog, FindsTheNewestMessageOfEachSender) {
  const LogIndex log(write("log", 1000000));
  EXPECT_EQ(log.size(), 101 + 11 + 1);
  EXPECT_EQ(log.duration_us(), 1000000);
  ASSERT_EQ(log.series().size(), 3U);  // states, ball, cup
  for (const LogIndex::Series& series : log.series()) {
    // Against a search from the beginning.
    for (int64_t i = 0; i < log.size(); ++i) {
      int64_t newest = -1;
      for (int64_t k = 0; k <= i; ++k) {
        const LogEvent event = log.event(k);
        const auto seen = decode<target_t>(event.data);
        if (event.channel == series.channel && (seen ? seen->name : "") == series.name) newest = k;
      }
      ASSERT_EQ(LogIndex::newest(series, i), newest) << series.channel << " " << series.name << " " << i;
    }
  }
  EXPECT_EQ(log.event_before(-5), 0);
  EXPECT_EQ(log.at_us(log.event_before(15000)), 10000);
  EXPECT_EQ(log.event_before(1 << 30), log.size() - 1);
}

TEST_F(PageLog, NeverGoesBackInTime) {
  const std::string path = folder_ / "jumps";
  LogWriter writer(path);
  for (const int64_t utime : std::vector<int64_t>{5, 9, 2, INT64_MIN, 7, 12})
    writer.write(utime, "ANY", std::vector<uint8_t>{1});
  writer.close();
  const LogIndex log(path);
  ASSERT_EQ(log.size(), 6);
  for (int64_t i = 1; i < log.size(); ++i) EXPECT_LE(log.at_us(i - 1), log.at_us(i));
}

TEST_F(PageLog, NamesTheFirstDifference) {
  const LogIndex one(write("one", 600000)), same(write("same", 600000, 7, 250000)), other(write("other", 300000));
  const auto none = [](double) {};
  const RunComparison equal = compare_runs(one, same, none);
  EXPECT_FALSE(equal.first) << "of another run, recorded later: " << equal.first->field;
  EXPECT_EQ(equal.compared, 101 + 12);
  EXPECT_EQ(equal.offset_us, 0) << "of times since the first event";
  const RunComparison different = compare_runs(one, other, none);
  ASSERT_TRUE(different.first);
  EXPECT_EQ(different.first->channel, "TARGET");
  EXPECT_EQ(different.first->name, "ball");
  EXPECT_EQ(different.first->field, "position_m[0]");
  EXPECT_EQ(different.first->utime, 300000);
  EXPECT_EQ(different.first->at_us, 300000);
  EXPECT_EQ(different.first->first, "0.1");
  EXPECT_EQ(different.first->second, "0.2");
}

TEST_F(PageLog, AlignsRunsByTheirMessages) {
  // The second recording begins three messages later.
  const std::string whole = write("whole", 1000000), part = folder_ / "part";
  LogWriter writer(part);
  LogReader reader(whole);
  while (const auto event = reader.next()) {
    if (event->utime >= kBegin + 300000) writer.write(event->utime + 77, event->channel, event->data);
  }
  writer.close();
  const LogIndex first(whole), second(part);
  EXPECT_EQ(offset_between(first, second), -300000);
  EXPECT_EQ(offset_between(second, first), 300000);
}

TEST_F(PageLog, AnswersQuestions) {
  ShownRuns runs({.log = write("log", 600000), .robot = kSource + "/robots/hoap2", .vision = ""});
  const LogAnswers answers(runs);
  const auto ask = [&](const std::string& path, const std::string& query) {
    const PageAnswer answer = answers.answer(path, query);
    EXPECT_EQ(answer.status, 200) << answer.body;
    return json::parse(answer.body);
  };
  const json overview = ask("/log/overview", "token=x");
  EXPECT_EQ(overview["events"], 113);
  EXPECT_EQ(overview["channels"]["TARGET"], 12);
  EXPECT_EQ(overview["targets"]["ball"], json::parse("[[0, 0], [500000, 1]]"));

  const json state = ask("/log/state", "run=0&at=655000");
  ASSERT_EQ(state["messages"].size(), 3U);
  for (const json& each : state["messages"]) {
    const json& message = each["message"];
    if (each["channel"] == "ROBOT_STATE") {
      EXPECT_EQ(message["utime"], 650000);
      EXPECT_EQ(each["at"], 650000);
    } else if (message["name"] == "ball") {
      EXPECT_EQ(message["utime"], 600000);
      EXPECT_EQ(message["position_m"][0], 0.2);
    }
  }
  EXPECT_EQ(state["rates"]["ROBOT_STATE"], 66) << "since the beginning, as that is less than a second before";

  // One of each sender in every 50 ms: the last.
  const json span = ask("/log/span", "after=99999&until=200000&step=50000");
  std::vector<int64_t> states;
  for (const json& each : span["messages"]) {
    if (each["channel"] == "ROBOT_STATE") states.push_back(each["at"]);
  }
  EXPECT_EQ(states, (std::vector<int64_t>{140000, 190000, 200000}));
  EXPECT_EQ(span["at"], 200000);

  const json step = ask("/log/step", "event=0&by=1&channel=TARGET");
  EXPECT_EQ(step["event"], 1);
  EXPECT_EQ(step["message"]["name"], "ball");
  EXPECT_EQ(ask("/log/step", "event=1&by=1&channel=TARGET")["message"]["name"], "cup");
  EXPECT_EQ(ask("/log/step", "event=2&by=-1&channel=TARGET")["event"], 1);
  EXPECT_EQ(ask("/log/step", "event=1&by=-1&channel=TARGET")["event"], 1) << "there is none before";
  EXPECT_EQ(ask("/log/step", "event=112&by=1")["event"], 112);

  EXPECT_EQ(answers.answer("/log/state", "run=5&at=0").status, 204) << "such a run was removed";
  EXPECT_EQ(answers.answer("/log/picture", "event=0&side=left").status, 204) << "no image";
  EXPECT_EQ(answers.answer("/log/state", "at=soon").status, 400);
  EXPECT_EQ(answers.answer("/log/state", "at=").status, 400);
  EXPECT_EQ(answers.answer("/log/anything", "").status, 400);
}

TEST_F(PageLog, GivesPictures) {
  ShownRuns runs({.log = kSource + "/logs/reach.lcm", .robot = kSource + "/robots/hoap2", .vision = ""});
  const LogAnswers answers(runs);
  LogReader reader(kSource + "/logs/reach.lcm");
  std::optional<images_t> pair;
  int64_t event = -1;
  while (!pair) {
    const auto next = reader.next();
    ASSERT_TRUE(next);
    ++event;
    if (next->channel == channel::kStereoImages) pair = decode<images_t>(next->data);
  }
  const PageAnswer right = answers.answer("/log/picture", fmt::format("event={}&side=right", event));
  EXPECT_EQ(right.type, "image/jpeg");
  EXPECT_EQ(right.body, std::string(pair->images[1].data.begin(), pair->images[1].data.end())) << "as it came";
  const PageAnswer small = answers.answer("/log/picture", "at=5000000&side=left&width=96");
  EXPECT_EQ(small.status, 200);
  EXPECT_LT(small.body.size(), right.body.size() / 3);
}

struct NoBrowsers : Browsers {
  int count() const override { return 1; }
  bool take_needs_all() override { return false; }
  void send(Outgoing::Kind, std::string bytes) override { sent.push_back(json::parse(bytes)); }
  std::vector<std::string> take_requests() override { return std::exchange(requests, {}); }

  std::vector<json> sent;
  std::vector<std::string> requests;
};

/// A run computed again with the same values is the same; with another gain it differs; wrong values are refused.
TEST_F(PageLog, ComputesASessionAgain) {
  // Two seconds of the recorded session, computed by a first replay.
  const std::string session = folder_ / "session.lcm";
  {
    LogReader reader(kSource + "/logs/reach.lcm");
    LogWriter writer(session);
    std::optional<int64_t> begin;
    while (const auto event = reader.next()) {
      if (!begin) begin = event->utime;
      if (event->utime > *begin + 2000000) break;
      writer.write(event->utime, event->channel, event->data);
    }
    writer.close();
  }
  ShownRuns runs({.log = session, .robot = kSource + "/robots/hoap2", .vision = ""});
  NoBrowsers browsers;
  LogPage page(browsers, runs);
  const auto answer_to = [&](const std::string& request) {
    browsers.sent.clear();
    browsers.requests.push_back(request);
    page.step();
    for (const json& each : browsers.sent) {
      if (each.contains("answer")) return each;
    }
    return json();
  };
  const auto await = [&](size_t index) {
    while (true) {
      const json run = json::parse(runs.json().dump())["runs"][index];
      if (run["state"] == "ready" || run["state"] == "failed") return run;
      std::this_thread::yield();
    }
  };
  EXPECT_TRUE(answer_to(R"({"recompute": {"set": [], "robot_model": "ideal"}})")["accepted"]);
  EXPECT_TRUE(
      answer_to(R"({"recompute": {"set": ["controller.gamma_rad2_m2=20"], "robot_model": "ideal"}})")["accepted"]);
  const json again = await(1), weaker = await(2);
  EXPECT_EQ(again["state"], "ready") << again["failure"];
  EXPECT_EQ(weaker["state"], "ready") << weaker["failure"];
  // The session itself holds images only; the runs are compared with one another.
  const RunComparison comparison = compare_runs(*runs.find(1)->log, *runs.find(2)->log, [](double) {});
  ASSERT_TRUE(comparison.first);
  EXPECT_EQ(comparison.first->channel, "JOINT_SETPOINT");
  EXPECT_GT(comparison.hand_distance_m, 1e-3);
  const RunComparison equal = compare_runs(*runs.find(1)->log, *runs.find(1)->log, [](double) {});
  EXPECT_FALSE(equal.first);
  EXPECT_GT(equal.compared, 1000);
  EXPECT_EQ(again["figures"]["reaches"], 1);

  const json misspelt = answer_to(R"({"recompute": {"set": ["controller.gama=20"], "robot_model": "ideal"}})");
  EXPECT_FALSE(misspelt["accepted"]);
  EXPECT_NE(misspelt["text"].get<std::string>().find("gama"), std::string::npos) << misspelt["text"];
  EXPECT_FALSE(answer_to(R"({"recompute": {"set": ["controller.law=none"], "robot_model": "ideal"}})")["accepted"]);
  EXPECT_FALSE(answer_to(R"({"recompute": {"set": [], "robot_model": "none"}})")["accepted"]);
  EXPECT_FALSE(answer_to(R"({"recompute": {"set": "x"}})")["accepted"]);
  EXPECT_FALSE(answer_to("[]")["accepted"]);
  EXPECT_FALSE(answer_to(R"({"request": "enable"})")["accepted"]);
  EXPECT_FALSE(answer_to(R"({"remove_run": 0})")["accepted"]) << "the log itself stays";
  answer_to(R"({"remove_run": 1})");
  EXPECT_FALSE(runs.find(1));
  EXPECT_TRUE(runs.find(2));
}

}  // namespace
}  // namespace multireach
