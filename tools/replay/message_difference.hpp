#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace multireach {

/// The first place where two messages of one channel differ.
struct MessageDifference {
  std::string field;  ///< as "angle_rad[2]"; "byte 17" where the fields cannot be told
  std::string first, second;
};

/// Needs messages that are not equal.
MessageDifference difference_of(std::span<const uint8_t> first, std::span<const uint8_t> second);

}  // namespace multireach
