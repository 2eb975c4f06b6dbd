#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "vision/colour/colour_model.hpp"

namespace multireach::vision {

class ChromaTest;

/// A coarse class that holds at least the members of a fine one: eight boxes in the upper four bits of the channels.
/// Bit k of a channel's entry says whether box k holds that value; a pixel is a candidate when a bit is set in all
/// three.
struct ColourBoxes {
  alignas(16) std::array<uint8_t, 16> red{}, green{}, blue{};
};

/// The members of a colour model under one light, for all 8-bit pixels. Each channel is divided into 32 intervals that
/// widen as the square root of the value, as the noise of sensors does; the last is that of clipped values. All pixels
/// of a cell are members when the one in its middle is.
class PixelClass {
 public:
  /// Nothing is a member.
  PixelClass();
  /// Throws std::invalid_argument for a model that check() refuses.
  explicit PixelClass(const ColourModel& model, const ColourShift& shift = {});
  explicit PixelClass(const ChromaTest& test);

  bool contains(uint8_t b, uint8_t g, uint8_t r) const {
    return rows_[static_cast<size_t>(code_[r]) << 5 | code_[g]] >> code_[b] & 1;
  }
  const ColourBoxes& boxes() const { return boxes_; }

 private:
  void find_boxes();

  std::array<uint8_t, 256> code_;
  std::array<uint32_t, 32 * 32> rows_{};  // by the codes of red and green; one bit for each code of blue
  ColourBoxes boxes_;
};

}  // namespace multireach::vision
