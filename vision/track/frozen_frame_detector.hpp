#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "imaging/side.hpp"

namespace multireach::vision {

/// Detects a camera that repeats the same image while the other camera's image changes: the pair is not of one time. A
/// working sensor never gives the same bytes twice. When both sides repeat, as in a recording of a still picture, the
/// pair is of one time.
class FrozenFrameDetector {
 public:
  /// Adds a pair, given as hashes of its images' bytes: whole numbers below 2^53.
  void update(int64_t left, int64_t right);
  std::optional<Side> repeats() const;
  /// Why the last pair is unusable when a camera repeats its image, as text; null when none does.
  const char* fault() const;

  /// The complete state.
  std::vector<double> serialize() const;
  /// Restores a state from serialize(). Returns false, and changes nothing, when `state` is not valid.
  [[nodiscard]] bool deserialize(std::span<const double> state);

  static constexpr size_t kSerializedSize = 4;

 private:
  std::array<int64_t, 2> last_{};
  std::array<int64_t, 2> repeated_{};
};

}  // namespace multireach::vision
