#include "tools/robot/hand_status.hpp"

#include <fmt/format.h>

#include <array>

namespace multireach {

std::string text_of(const controller_state_t& state) {
  const auto mode = static_cast<size_t>(state.mode);
  static constexpr std::array kModes{"waiting for a target", "reaching", "holding", "resting"};
  std::string text = mode < kModes.size() ? kModes[mode] : "unknown";
  if (state.mode == controller_state_t::MODE_WAITING) return text;  // without a target, there is no distance
  text += fmt::format(", hand {:.1f} mm from the target", 1e3 * state.distance_m);
  if (state.target_lost) text += " as last seen";
  if (state.target_unreachable) text += ", which is unreachable";
  static constexpr std::array kBlocked{"", "the target is inside an obstacle or too near to it",
                                       "an obstacle or the arm itself is in the way", "no way found"};
  const auto blocked = static_cast<size_t>(state.blocked);
  if (state.blocked != controller_state_t::BLOCKED_NO)
    text += fmt::format("; blocked: {}", blocked < kBlocked.size() ? kBlocked[blocked] : kBlocked.back());
  return text;
}

std::optional<std::string> HandStatus::line(int64_t now_us) const {
  if (hand_ || node_) return "controller: " + (hand_ ? *hand_ : *node_);
  if (now_us - begun_us_ < kPatience) return std::nullopt;
  return fmt::format("controller: not heard in {:.1f} s", static_cast<double>(now_us - begun_us_) * 1e-6);
}

}  // namespace multireach
