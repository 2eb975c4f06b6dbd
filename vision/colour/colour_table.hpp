#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "vision/colour/colour_model.hpp"

namespace multireach::vision {

class ChromaClassifier;

/// A superset of a colour table for fast rejection: eight boxes in the upper four bits of the channels. Bit k of a
/// channel's entry tells whether box k contains that value; a pixel is a candidate when some bit is set in all three
/// channels.
struct ColourBoxes {
  alignas(16) std::array<uint8_t, 16> red{}, green{}, blue{};
};

/// Lookup table of a colour model at given white-balance gains, for all 8-bit pixels. Each channel is divided into 32
/// intervals whose width grows with the square root of the value, like sensor noise; the last holds the clipped values.
/// A cell belongs to the object when its middle does.
class ColourTable {
 public:
  /// An empty table: contains() is false for every pixel.
  ColourTable();
  /// Throws std::invalid_argument for a model that check() rejects.
  explicit ColourTable(const ColourModel& model, const WhiteBalanceGains& gains = {});
  explicit ColourTable(const ChromaClassifier& test);

  bool contains(uint8_t b, uint8_t g, uint8_t r) const {
    return rows_[static_cast<size_t>(code_[r]) << 5 | code_[g]] >> code_[b] & 1;
  }
  const ColourBoxes& boxes() const { return boxes_; }

 private:
  void find_boxes();

  std::array<uint8_t, 256> code_;
  std::array<uint32_t, 32 * 32> rows_{};  // indexed by the codes of red and green; one bit per code of blue
  ColourBoxes boxes_;
};

}  // namespace multireach::vision
