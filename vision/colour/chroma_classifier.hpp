#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "vision/colour/colour_model.hpp"

namespace multireach::vision {

/// What a pixel is compared with: a colour model for given white-balance gains.
struct ChromaCriterion {
  struct Component {
    double u, v;        // mean
    double uu, uv, vv;  // covariance
    double handicap;  // log det - 2 log weight, added to the squared distance gives -2 log likelihood up to a constant
    Rgb colour;       // mean colour at Y = 1
  };
  std::vector<Component> object, background;
  WhiteBalanceGains gains;
  double min_luma, max_luma;
  double tolerance2;        // square of the largest Mahalanobis distance
  double variance;          // of a pixel's noise, grey levels^2
  double largest_variance;  // bound of the variance that this noise gives to Y times U and to Y times V
};

/// A colour model for given white-balance gains, prepared for classifying many pixels.
class ChromaClassifier {
 public:
  /// Throws std::invalid_argument for a model that check() rejects.
  ChromaClassifier(const ColourModel& model, const WhiteBalanceGains& gains);

  void set_gains(const WhiteBalanceGains& gains);
  bool contains(const Rgb& pixel) const;
  /// The same, with the values of clipped channels as they are.
  bool contains_as_read(const Rgb& pixel) const;
  /// The same for the pixels of 32 blues, in SIMD lanes: bit k tells it for blues[k]. Does not depend on the
  /// instruction set.
  uint32_t contains(double red, double green, const std::array<double, 32>& blues) const;
  /// The colour that an object pixel (neither clipped nor black) would have in the light in which the model was
  /// learned: the mean of the nearest component at the pixel's brightness.
  Rgb expected(const Rgb& pixel) const;
  /// Mahalanobis distance of an object's mean colour from the learned one, pixel noise not counted. 0 where several
  /// colours were learned: their mixture tells nothing.
  double deviation(const Rgb& colour) const;

 private:
  ChromaCriterion criterion_;
};

}  // namespace multireach::vision
