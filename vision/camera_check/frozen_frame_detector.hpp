#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "imaging/side.hpp"

namespace multireach::vision {

/// Detects a camera that repeats the same image while the other camera's image changes. A working sensor never gives
/// the same bytes twice: with a new time, such an image is not of that time. With its old time it is usable, until the
/// camera counts as frozen. Where both images repeat, as in a recording of a still picture, the pair remains usable.
class FrozenFrameDetector {
 public:
  /// An image: a hash of its bytes, a whole number below 2^53, and when it was taken, us.
  struct Image {
    int64_t hash = 0, utime = 0;
  };

  /// Adds a pair.
  void update(const Image& left, const Image& right);
  /// The camera whose image makes the last pair unusable.
  std::optional<Side> repeats() const;
  /// Why that image does, as text; null when none does.
  const char* fault() const;
  /// Whether both cameras have repeated their images with new times, so often that one camera would count as frozen.
  /// Counted since the start or since deserialize(): it decides nothing.
  bool both_repeat() const;

  /// The complete state; times are relative to `utime`.
  std::vector<double> serialize(int64_t utime) const;
  /// Restores a state from serialize(utime). Returns false, and changes nothing, when `state` is not valid.
  [[nodiscard]] bool deserialize(int64_t utime, std::span<const double> state);

  static constexpr size_t kSerializedSize = 6;

 private:
  std::array<Image, 2> last_{};
  std::array<int64_t, 2> repeated_{};
  std::array<bool, 2> as_new_{};  // repeated with a new time; of the last pair, no state
  int64_t both_repeated_ = 0;     // as new ones; no state
};

}  // namespace multireach::vision
