#pragma once

#include <cstdint>
#include <multireach/controller_state_t.hpp>
#include <multireach/node_status_t.hpp>
#include <optional>
#include <string>

namespace multireach {

/// What the controller says about the hand, in words: where it is from its target, and whether something prevents it.
std::string text_of(const controller_state_t& state);

/// The second line of `multireach-robot status`: what the controller says about the hand; before its first target,
/// when it sends no CONTROLLER_STATE, its NODE_STATUS; or that neither came in time. Knows time only from its
/// arguments.
class HandStatus {
 public:
  /// How long a controller may take to be heard, microseconds: it sends NODE_STATUS once a second.
  static constexpr int64_t kPatience = 2000000;

  /// `now_us`: when listening began.
  explicit HandStatus(int64_t now_us) : begun_us_(now_us) {}
  void receive(const controller_state_t& state) { hand_ = text_of(state); }
  void receive(const node_status_t& status) {
    if (status.node == "controller") node_ = status.state;
  }
  /// Nothing while the controller was not heard and may still be.
  std::optional<std::string> line(int64_t now_us) const;

 private:
  int64_t begun_us_;
  std::optional<std::string> hand_, node_;
};

}  // namespace multireach
