#pragma once

#include <Eigen/Core>
#include <multireach/target_choice_t.hpp>
#include <multireach/target_t.hpp>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "runtime/node.hpp"

namespace multireach {

/// What users move with their hands: the page's own target, which the controller then follows, obstacles, and pushes on
/// a simulated arm. Knows time only from its arguments, microseconds.
class Touch {
 public:
  static constexpr const char* kTargetName = "page";
  static constexpr int64_t kLease = 5000000;         ///< us: a browser that was not heard for this long lost the target
  static constexpr int64_t kChoicePeriod = 1000000;  ///< us
  static constexpr double kSpeed = 0.4;              ///< m/s at which the target follows the user's hand
  static constexpr size_t kMaxObstacles = 12;

  /// `run`: random number of the page's start.
  explicit Touch(int64_t run) : run_(run) {}

  static bool knows(std::string_view request);
  /// Handles a request of a browser that it knows, {"request": "target", "client": …, "position_m": […]} and the like.
  /// Returns what to tell the browser, if anything; `accepted` whether it was done.
  struct Answer {
    bool accepted = false;
    std::string text{};
  };
  std::optional<Answer> handle(const nlohmann::json& request, int64_t now_us, Outbox& out);
  /// Takes a message of the channels TARGET, TARGET_CHOICE, ROBOT_STATE, BRIDGE_STATE; ignores others.
  void receive(std::string_view channel, std::span<const uint8_t> bytes, int64_t now_us, Outbox& out);
  void tick(int64_t now_us, Outbox& out);

  /// Sends a choice, for the page itself (NONE while it moves the arm), and repeats it.
  void choose(int8_t kind, const std::string& by, int64_t now_us, Outbox& out);
  bool robot_is_real() const { return real_; }

 private:
  std::optional<Answer> handle_target(const nlohmann::json& request, int64_t now_us, Outbox& out);
  std::optional<Answer> handle_release(const nlohmann::json& request, int64_t now_us, Outbox& out);
  Answer handle_obstacles(const nlohmann::json& request, int64_t now_us, Outbox& out);
  Answer handle_push(const nlohmann::json& request, int64_t now_us, Outbox& out);
  /// Why this browser may not take the target; "" when it may.
  std::string refusal(const std::string& client, int64_t now_us) const;
  void send_target(int64_t utime, Outbox& out);
  template <class Message>
  void send(Outbox& out, std::string_view channel, const Message& message);

  int64_t run_;
  int64_t target_sequence_ = 0, choice_sequence_ = 0, obstacles_sequence_ = 0;
  target_choice_t choice_{};
  int64_t choice_sent_us_ = 0, choice_until_us_ = 0;  // a choice that was ended is still said for a while
  std::string client_;                                // the browser that moves the target
  int64_t client_heard_us_ = 0;
  std::optional<Eigen::Vector3d> wished_, position_;  // of the page's target, m, in W
  std::optional<target_t> other_;                     // newest target of another publisher: what time it is
  int64_t other_heard_us_ = 0, target_sent_utime_ = 0, target_sent_us_ = 0;
  std::optional<int64_t> foreign_choice_us_;  // when another page's choice was heard
  std::string foreign_name_;
  bool real_ = false, bridge_idle_ = true;
};

}  // namespace multireach
