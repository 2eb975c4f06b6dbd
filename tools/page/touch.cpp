#include "tools/page/touch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <multireach/bridge_state_t.hpp>
#include <multireach/obstacles_t.hpp>
#include <multireach/perturbation_t.hpp>
#include <multireach/robot_state_t.hpp>
#include <nlohmann/json.hpp>

#include "runtime/channels.hpp"
#include "runtime/files.hpp"
#include "tools/publish/messages.hpp"

namespace multireach {
namespace {

using nlohmann::json;

constexpr std::array kWords{"target", "release", "obstacles", "push"};
constexpr double kFarthest = 100;     // m
constexpr double kStrongest = 500;    // N
constexpr double kLongestPush = 2;    // s
constexpr int64_t kSilence = 200000;  // us: without other targets for this long, the page counts the time itself
constexpr int64_t kForeignSilence = 3000000;  // us
constexpr int64_t kTargetPeriod = 33333;      // us
constexpr int64_t kEndRepeated = 3000000;     // us

std::vector<double> numbers(const json& object, const char* key) {
  std::vector<double> values;
  const auto found = object.find(key);
  if (found == object.end() || !found->is_array()) return values;
  for (const json& each : *found) {
    if (!each.is_number()) return {};
    values.push_back(each.get<double>());
  }
  return values;
}

/// Three finite numbers no larger than `largest`; nothing for anything else.
std::optional<Eigen::Vector3d> vector_of(const json& object, const char* key, double largest) {
  const std::vector<double> values = numbers(object, key);
  if (values.size() != 3) return std::nullopt;
  const Eigen::Vector3d vector(values[0], values[1], values[2]);
  if (!vector.allFinite() || vector.cwiseAbs().maxCoeff() > largest) return std::nullopt;
  return vector;
}

std::string text(const json& object, const char* key) {
  constexpr size_t kLongest = 64;
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>().substr(0, kLongest) : "";
}

}  // namespace

bool Touch::knows(std::string_view request) {
  return std::ranges::find(kWords, request) != kWords.end();
}

template <class Message>
void Touch::send(Outbox& out, std::string_view channel, const Message& message) {
  if (auto bytes = encode(message)) out.push_back({channel, std::move(*bytes)});
}

std::optional<Touch::Answer> Touch::handle(const json& request, int64_t now_us, Outbox& out) {
  const std::string word = text(request, "request");
  if (word == "target") return handle_target(request, now_us, out);
  if (word == "release") return handle_release(request, now_us, out);
  return word == "push" ? handle_push(request, now_us, out) : handle_obstacles(request, now_us, out);
}

std::string Touch::refusal(const std::string& client, int64_t now_us) const {
  if (client.empty()) return "the request names no client";
  if (!client_.empty() && client != client_ && now_us - client_heard_us_ < kLease)
    return "another browser moves the target";
  if (foreign_choice_us_ && now_us - *foreign_choice_us_ < kForeignSilence)
    return foreign_name_ + ", which another process serves, has chosen the target";
  if (choice_.kind == target_choice_t::NONE) return choice_.chosen_by + " moves the arm";
  // Whoever enabled a real robot meant another target.
  if (client_.empty() && real_ && !bridge_idle_)
    return "the robot is real: disable it, take the target, then enable the robot";
  return "";
}

std::optional<Touch::Answer> Touch::handle_target(const json& request, int64_t now_us, Outbox& out) {
  const auto wished = vector_of(request, "position_m", kFarthest);
  const std::string client = text(request, "client");
  if (!wished) return Answer{false, "position_m: expected three numbers, in metres"};
  if (const std::string why = refusal(client, now_us); !why.empty()) return Answer{false, why};
  const bool taken = choice_.kind != target_choice_t::NAMED || client != client_;
  client_ = client;
  client_heard_us_ = now_us;
  wished_ = *wished;
  if (choice_.kind == target_choice_t::NAMED)
    return taken ? std::optional(Answer{true, "this browser moves it"}) : std::nullopt;
  position_ = *wished;
  target_sent_utime_ = 0;
  choice_.name = kTargetName;
  choose(target_choice_t::NAMED, "the page", now_us, out);
  return Answer{true, fmt::format("the controller follows '{}'", kTargetName)};
}

std::optional<Touch::Answer> Touch::handle_release(const json& request, int64_t now_us, Outbox& out) {
  const std::string client = text(request, "client");
  if (choice_.kind != target_choice_t::NAMED) return Answer{true, "no target was taken"};
  if (const std::string why = refusal(client, now_us); !why.empty()) return Answer{false, why};
  client_.clear();
  wished_.reset();
  position_.reset();
  choose(target_choice_t::CONFIGURED, "the page", now_us, out);
  return Answer{true, "the controller follows the target of its configuration"};
}

Touch::Answer Touch::handle_obstacles(const json& request, int64_t now_us, Outbox& out) {
  const auto list = request.find("obstacles");
  if (list == request.end() || !list->is_array() || list->size() > kMaxObstacles)
    return {false, fmt::format("obstacles: expected a list of up to {}", kMaxObstacles)};
  obstacles_t message{};
  message.utime = now_us;
  message.sequence = obstacles_sequence_++;
  for (const json& each : *list) {
    const auto position = each.is_object() ? vector_of(each, "position_m", kFarthest) : std::nullopt;
    if (!position) return {false, "obstacles: each needs position_m, three numbers in metres"};
    std::vector<double> orientation = numbers(each, "orientation_wxyz");
    if (orientation.size() != 4) orientation = {1, 0, 0, 0};
    try {
      message.obstacles.push_back(
          obstacle_message(text(each, "shape"), *position, numbers(each, "size_m"), orientation));
    } catch (const InputError& fault) {
      return {false, fault.what()};
    }
    message.obstacles.back().name = text(each, "name");
  }
  message.num_obstacles = static_cast<int32_t>(message.obstacles.size());
  send(out, channel::kObstacles, message);
  return {true, fmt::format("there {} now {} {}", message.num_obstacles == 1 ? "is" : "are", message.num_obstacles,
                            message.num_obstacles == 1 ? "obstacle" : "obstacles")};
}

Touch::Answer Touch::handle_push(const json& request, int64_t now_us, Outbox& out) {
  if (real_) return {false, "only a simulated robot can be pushed by the page"};
  const auto force = vector_of(request, "force_n", kStrongest);
  const auto duration = request.find("duration_s");
  const double seconds = duration != request.end() && duration->is_number() ? duration->get<double>() : 0.2;
  const std::string link = text(request, "link");
  if (!force || link.empty() || !(seconds > 0 && seconds <= kLongestPush))
    return {false, fmt::format("push: expected a link, force_n up to {} N and duration_s up to {} s", kStrongest,
                               kLongestPush)};
  send(out, channel::kPerturbation, perturbation_message(link, *force, seconds, now_us));
  return {true, fmt::format("{:.0f} N on {} for {:.1f} s", force->norm(), link, seconds)};
}

void Touch::choose(int8_t kind, const std::string& by, int64_t now_us, Outbox& out) {
  choice_.utime = now_us;
  choice_.sequence = choice_sequence_++;
  choice_.run = run_;
  choice_.kind = kind;
  choice_.chosen_by = by;
  if (kind != target_choice_t::NAMED) {
    choice_.name.clear();
    client_.clear();
    position_.reset();
  }
  choice_sent_us_ = now_us;
  choice_until_us_ = kind == target_choice_t::CONFIGURED ? now_us + kEndRepeated : INT64_MAX;
  send(out, channel::kTargetChoice, choice_);
}

void Touch::receive(std::string_view channel, std::span<const uint8_t> bytes, int64_t now_us, Outbox& out) {
  if (channel == channel::kTarget) {
    auto target = decode<target_t>(bytes);
    if (!target || target->run == run_ || !plausible_utime(target->utime)) return;
    other_ = std::move(target);
    other_heard_us_ = now_us;
    if (position_ && other_->utime != target_sent_utime_) send_target(other_->utime, out);
  } else if (channel == channel::kTargetChoice) {
    const auto choice = decode<target_choice_t>(bytes);
    if (!choice || choice->run == run_) return;
    foreign_choice_us_.reset();
    if (choice->kind != target_choice_t::CONFIGURED) foreign_choice_us_ = now_us;
    foreign_name_ = choice->chosen_by.empty() ? "somebody" : choice->chosen_by;
  } else if (channel == channel::kRobotState) {
    if (const auto state = decode<robot_state_t>(bytes)) real_ = !state->simulated;
  } else if (channel == channel::kBridgeState) {
    if (const auto state = decode<bridge_state_t>(bytes)) bridge_idle_ = state->state == bridge_state_t::IDLE;
  }
}

/// Sends the page's target for this time, on its way to where the user wants it.
void Touch::send_target(int64_t utime, Outbox& out) {
  target_t message = target_message(kTargetName, *position_, {}, utime, target_sequence_++, run_);
  const double elapsed = 1e-6 * static_cast<double>(utime - target_sent_utime_);
  if (wished_ && target_sent_utime_ > 0 && elapsed > 0 && elapsed < 1) {
    const Eigen::Vector3d way = *wished_ - *position_;
    const double step = std::min(kSpeed * elapsed, way.norm());
    const Eigen::Vector3d moved = way.norm() > 0 ? (way.normalized() * step).eval() : Eigen::Vector3d::Zero();
    *position_ += moved;
    Eigen::Map<Eigen::Vector3d>(message.position_m) = *position_;
    Eigen::Map<Eigen::Vector3d>(message.velocity_m_s) = moved / elapsed;
  }
  target_sent_utime_ = utime;
  send(out, channel::kTarget, message);
}

void Touch::tick(int64_t now_us, Outbox& out) {
  if (choice_sent_us_ > 0 && now_us < choice_until_us_ && now_us - choice_sent_us_ >= kChoicePeriod) {
    choice_.utime = choice_sent_us_ = now_us;
    choice_.sequence = choice_sequence_++;
    send(out, channel::kTargetChoice, choice_);
  }
  const bool others = other_ && now_us - other_heard_us_ < kSilence;
  if (!position_ || others || now_us - target_sent_us_ < kTargetPeriod) return;
  // Where no other targets tell the time of the images, the page goes on from the last, or by its own clock.
  target_sent_us_ = now_us;
  send_target(other_ ? other_->utime + now_us - other_heard_us_ : now_us, out);
}

}  // namespace multireach
