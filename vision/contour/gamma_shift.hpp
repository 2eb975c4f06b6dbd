#pragma once

#include <array>
#include <optional>

#include "vision/contour/contour_edgel.hpp"
#include "vision/contour/edge_profile.hpp"

namespace multireach::vision {

/// How far a camera's gamma curve moves edges. The lens and the pixels mix the light of both sides of an edge, then the
/// curve makes grey levels of it (light to the power of 1 / gamma): the edge seems to be nearer to its darker side.
class GammaShift {
 public:
  static constexpr double kUsual = 2.2;  ///< of cameras for pictures (IEC 61966-2-1)

  /// `gamma`: from 1 to 5; nothing: not known, and up to kUsual.
  explicit GammaShift(std::optional<double> gamma);

  /// How much too far outwards an edge between two grey levels is measured, pixels, if its image is `width_px` wide.
  double of_edge(double inside, double outside, double width_px) const;
  /// Corrects a measured edge where the curve is known, and sets how far it may have moved the edge apart from that.
  /// `blur2`: variance of the blur across the edge beyond the pixels' own width, px^2. `hues_blurred`: the image has
  /// subsampled chroma; the hues of both sides were then not mixed by the lens alone, and nothing is corrected.
  void correct(double blur2, bool hues_blurred, ContourEdgel& edgel) const;

 private:
  static constexpr int kSteps = 64;
  std::optional<double> gamma_;
  std::array<double, kSteps + 1> shifts_{};  ///< by the ratio of the darker grey level to the brighter one
};

}  // namespace multireach::vision
