#pragma once

#include <optional>

#include "vision/stereo/stereo_match.hpp"

namespace multireach::vision {

/// Follows over many pairs whether what the two images show fits the calibration: one pair that is off says little, for
/// a match may be wrong, but all of them say that the cameras have moved, or that a known radius is wrong. It is for
/// people: it changes no position, and is no part of a tracker's state.
class CalibrationCheck {
 public:
  /// What is off in the mean of the last matches.
  struct Disagreement {
    std::optional<double> rows_px;     ///< the right ray passes below the left one, pixels of the left camera
    std::optional<double> size_share;  ///< by how much the object looks larger than its known radius at its distance
  };

  /// Takes the match of a pair that was tracked. Those by sphere contours in both images count.
  void update(const StereoMatch& match);
  /// Nothing is off until there were enough matches, and unless it exceeds three standard deviations of a single match:
  /// errors of many images of an object that stands still are the same.
  Disagreement disagreement() const;

 private:
  /// Mean of the last values, and mean of their variances.
  struct Mean {
    int count = 0;
    double value = 0, variance = 0;
    void take(double new_value, double new_variance);
    bool exceeds(double least) const;
  };

  Mean rows_, size_;
};

}  // namespace multireach::vision
