#include "tools/page/page_node.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <multireach/debug_request_t.hpp>
#include <multireach/images_t.hpp>
#include <multireach/node_status_t.hpp>
#include <multireach/target_candidates_t.hpp>
#include <multireach/target_t.hpp>
#include <nlohmann/json.hpp>

#include "runtime/channels.hpp"
#include "runtime/json_text.hpp"
#include "runtime/message_schema.hpp"
#include "tools/page/jpeg_image.hpp"
#include "tools/robot/bridge_words.hpp"

namespace multireach {
namespace {

using json = nlohmann::ordered_json;

constexpr int kLargestWidth = 640;  // pixels; a raw image is sent no wider than this

std::string as_string(const std::vector<uint8_t>& bytes) {
  return {bytes.begin(), bytes.end()};
}

/// Time of an images_t, without its images; nothing where the message is none.
std::optional<int64_t> time_of_images(std::span<const uint8_t> bytes) {
  if (bytes.size() < 2 * sizeof(uint64_t)) return std::nullopt;
  const auto number = [&](size_t at) {
    uint64_t value = 0;
    for (size_t i = 0; i < sizeof value; ++i) value = value << 8 | bytes[at + i];
    return static_cast<int64_t>(value);
  };
  if (number(0) != images_t::getHash()) return std::nullopt;
  return number(sizeof(uint64_t));
}

}  // namespace

PageNode::PageNode(Browsers& browsers, const Start& start)
    : browsers_(browsers),
      next_tick_us_(start.utime),
      asker_(start.first_request),
      run_(start.run),
      touch_(start.run) {}

void PageNode::offer_course(const RobotConfig& robot, const std::string& folder, bool practice) {
  course_.emplace(robot, folder, practice, run_, touch_);
}

void PageNode::feed_foxglove(FoxgloveHub& hub, const RobotConfig& robot, const StereoRig* rig) {
  foxglove_.emplace(hub, robot, rig);
}

std::vector<std::string_view> PageNode::inputs() const {
  std::vector<std::string_view> names{channel::kTarget,          channel::kObstacles,    channel::kJointSetpoint,
                                      channel::kControllerState, channel::kJointCommand, channel::kBridgeState,
                                      channel::kRobotState,      channel::kNodeStatus,   channel::kStereoImages,
                                      channel::kVisionDebug,     channel::kTargetChoice, channel::kTargetCandidates};
  if (course_) std::ranges::copy(Course::inputs(), std::back_inserter(names));
  return names;
}

std::string PageNode::state() const {
  const int count = browsers_.count();
  return count == 0 ? "no browser" : fmt::format("{} {}", count, count == 1 ? "browser" : "browsers");
}

Receipt PageNode::receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) {
  const auto inputs = this->inputs();
  channel = *std::ranges::find(inputs, channel);  // the name with a lifetime of its own
  ++count_[channel];
  if (foxglove_) foxglove_->receive(channel, bytes, next_tick_us_);
  if (drake_) drake_->receive(channel, bytes);
  const size_t before = out.size();
  touch_.receive(channel, bytes, next_tick_us_, out);
  if (course_) course_->receive(channel, bytes, next_tick_us_, out);
  counters_.sent += static_cast<int64_t>(out.size() - before);
  if (channel == channel::kStereoImages) {
    receive_stereo(bytes);
  } else if (channel == channel::kVisionDebug) {
    receive_debug_picture(bytes);
  } else if (channel == channel::kTarget) {
    if (const auto target = decode_and_count<target_t>(bytes)) keep(channel, target->name, bytes);
  } else if (channel == channel::kTargetCandidates) {
    if (const auto several = decode_and_count<target_candidates_t>(bytes)) keep(channel, several->name, bytes);
  } else if (channel == channel::kNodeStatus) {
    if (const auto status = decode_and_count<node_status_t>(bytes)) keep(channel, status->node, bytes);
  } else if (channel == channel::kBridgeState) {
    if (const auto state = decode_and_count<bridge_state_t>(bytes)) {
      bridge_heard_us_ = next_tick_us_;
      asker_.receive(*state);
      keep(channel, "", bytes);
    }
  } else {
    if (channel == channel::kRobotState) asker_.receive_robot_state();
    ++counters_.received;
    keep(channel, "", bytes);
  }
  return {};
}

void PageNode::keep(std::string_view channel, const std::string& name, std::span<const uint8_t> bytes) {
  constexpr size_t kMostNames = 100;  // a sender that invents names must not fill the memory
  std::string key = std::string(channel) + '/' + name;
  if (newest_.size() >= kMostNames && !newest_.contains(key)) return;
  Newest& newest = newest_[key];
  newest.channel = channel;
  newest.bytes.assign(bytes.begin(), bytes.end());
  newest.sent = false;
}

void PageNode::receive_stereo(std::span<const uint8_t> bytes) {
  images_utime_ = time_of_images(bytes);
  const bool drawn = contours_ && debug_picture_us_ && next_tick_us_ - *debug_picture_us_ < kSecond;
  const bool recent = picture_us_ && next_tick_us_ - *picture_us_ < kPicturePeriodUs;
  if (!watched() || drawn || recent) return;
  const auto images = decode_and_count<images_t>(bytes);
  if (!images) return;
  picture_us_ = next_tick_us_;
  for (size_t i = 0; i < images->images.size(); ++i) {
    const bool right = images->image_types[i] == images_t::RIGHT;
    std::string jpeg = jpeg_of(images->images[i], codec_, kLargestWidth, false);
    if (!jpeg.empty())
      browsers_.send(right ? Outgoing::Kind::kRightPicture : Outgoing::Kind::kLeftPicture, std::move(jpeg));
  }
}

void PageNode::receive_debug_picture(std::span<const uint8_t> bytes) {
  const bool recent = debug_picture_us_ && next_tick_us_ - *debug_picture_us_ < kPicturePeriodUs;
  if (!watched() || !contours_ || recent) return;
  const auto images = decode_and_count<images_t>(bytes);
  if (!images || images->images.size() != 1 || !is_jpeg(images->images[0])) return;
  debug_picture_us_ = next_tick_us_;
  // Drawing must not be what makes vision late.
  if (images_utime_ && *images_utime_ - images->utime > kVisionLate) contours_from_us_ = next_tick_us_ + kVisionPause;
  browsers_.send(Outgoing::Kind::kPairPicture, as_string(images->images[0].data));
}

void PageNode::refuse(const std::string& why) {
  ++counters_.refused;
  answer("page", false, why);
}

void PageNode::answer(const std::string& word, bool accepted, const std::string& text, const std::string& client) {
  browsers_.send(Outgoing::Kind::kAnswer,
                 json_text({{"answer", word}, {"accepted", accepted}, {"text", text}, {"client", client}}));
}

void PageNode::handle_requests(Outbox& out) {
  for (const std::string& text : browsers_.take_requests()) {
    const auto request = nlohmann::json::parse(text, nullptr, false);
    if (!request.is_object()) {
      refuse("a request of the page is no JSON object");
    } else {
      handle_request(request, out);
    }
  }
}

void PageNode::handle_request(const nlohmann::json& request, Outbox& out) {
  if (const auto contours = request.find("contours"); contours != request.end() && contours->is_boolean()) {
    contours_ = contours->get<bool>();
    return;
  }
  const auto found = request.find("request");
  const std::string word = found != request.end() && found->is_string() ? found->get<std::string>() : "";
  if (Touch::knows(word)) {
    const auto client = request.find("client");
    if (const auto done = touch_.handle(request, next_tick_us_, out))
      answer(word, done->accepted, done->text,
             client != request.end() && client->is_string() ? client->get<std::string>() : "");
    return;
  }
  if (word == "course" && course_) {
    const auto [accepted, text] = course_->handle(request, next_tick_us_, out);
    return answer(word, accepted, text);
  }
  if (word == "speed") {
    const auto speed = request.find("speed");
    if (speed == request.end() || !speed->is_number() || !(*speed >= 0.0 && *speed <= 1.0))
      return refuse("speed: expected a number from 0 to 1");
    return asker_.ask(word, bridge_request_t::SPEED, speed->get<double>());
  }
  const auto known = std::ranges::find(bridge_words(), word, [](const BridgeWord& each) { return each.word; });
  if (known == bridge_words().end())
    return refuse("'" + word +
                  "' is no request; expected enable, disable, stop, pause, resume, reset, status, speed, target, "
                  "release, obstacles or push");
  asker_.ask(word, known->kind);
}

void PageNode::ask_bridge(bool each_second, Outbox& out) {
  if (const auto request = asker_.tick(next_tick_us_)) send(out, channel::kBridgeRequest, *request);
  while (const auto answer = asker_.take_answer()) {
    this->answer(answer->word, answer->accepted, answer->text());
  }
  // A bridge that sends no commands says its state only when asked.
  if (!watched() || !each_second) return;
  if (bridge_heard_us_ && next_tick_us_ - *bridge_heard_us_ < kSecond) return;
  bridge_request_t status{};
  status.kind = bridge_request_t::STATUS;
  status.utime = status.request = next_tick_us_;
  send(out, channel::kBridgeRequest, status);
}

void PageNode::send_frame() {
  if (browsers_.take_needs_all()) {
    for (auto& [key, newest] : newest_) newest.sent = false;
    course_sent_.clear();
  }
  json messages = json::array();
  for (auto& [key, newest] : newest_) {
    if (std::exchange(newest.sent, true)) continue;
    const MessageSchema* schema = MessageSchemas::project().of(newest.bytes);
    const auto message = schema ? json_of(*schema, newest.bytes) : std::nullopt;
    if (!message) {
      ++counters_.refused;
      continue;
    }
    messages.push_back({{"channel", newest.channel}, {"message", *message}});
  }
  json rates = json::object();
  for (const auto& [channel, count] : last_count_) rates[std::string(channel)] = count;
  json frame{{"utime", next_tick_us_}, {"messages", messages}, {"rates", rates}};
  if (contours_ && next_tick_us_ < contours_from_us_) frame["vision_late"] = true;
  if (course_ && ticks_ % kTicksPerCourse == 0) {
    json course = course_->status();
    if (const std::string text = json_text(course); text != course_sent_) {
      course_sent_ = text;
      frame["course"] = std::move(course);
    }
  }
  browsers_.send(Outgoing::Kind::kFrame, json_text(frame));
}

void PageNode::tick(Outbox& out) {
  const size_t before = out.size();
  handle_requests(out);
  touch_.tick(next_tick_us_, out);
  if (course_) course_->tick(next_tick_us_, watched(), out);
  if (drake_) drake_->tick(next_tick_us_, out);
  counters_.sent += static_cast<int64_t>(out.size() - before);
  const bool each_second = next_tick_us_ - kSecond >= second_us_;
  ask_bridge(each_second, out);
  if (each_second) {
    second_us_ = next_tick_us_;
    last_count_ = std::exchange(count_, {});
    if (!watched()) contours_ = false;  // the next browser says what it wants
    if (contours_ && next_tick_us_ >= contours_from_us_) {
      debug_request_t request;
      request.utime = next_tick_us_;
      send(out, channel::kVisionDebugRequest, request);
    }
  }
  if (watched() && ticks_ % kTicksPerFrame == 0) send_frame();
  ++ticks_;
  next_tick_us_ += kTickUs;
}

}  // namespace multireach
