#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace multireach {

/// The first difference between two messages of one channel.
struct MessageDifference {
  std::string field;  ///< as "joint_position[2]"; "byte 17" where the fields cannot be told
  std::string first, second;
};

/// The messages must differ.
MessageDifference difference_of(std::span<const uint8_t> first, std::span<const uint8_t> second);

}  // namespace multireach
