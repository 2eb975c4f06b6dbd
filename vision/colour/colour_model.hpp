#pragma once

#include <Eigen/Core>
#include <vector>

#include "vision/colour/colour_class.hpp"

namespace multireach::vision {

/// A normal distribution of the chroma (U, V) = ((R - G)/Y, (B - G)/Y), Y = (R + 2G + B)/4. Chroma does not change with
/// exposure. U and V lie between -2 and 4.
struct ChromaComponent {
  Eigen::Vector2d mean{0, 0};
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();
  double weight = 1;  ///< proportional to its share of all pixels
  friend bool operator==(const ChromaComponent&, const ChromaComponent&) = default;
};

/// White balance of one camera relative to the light in which a model was learned: factors that map its current red and
/// blue to the values at that time; green stays. Automatic white balance changes only these.
struct WhiteBalanceGains {
  double red = 1, blue = 1;  ///< kMinGain to kMaxGain
  friend bool operator==(const WhiteBalanceGains&, const WhiteBalanceGains&) = default;
};
/// Bounds of the gains; beyond them it is another scene.
inline constexpr double kMinGain = 0.5, kMaxGain = 2;

/// The colours of one object as one camera sees them. A pixel belongs to the object when
/// - its Y is between `min_luma` and `max_luma` and at least one channel is not clipped (below kClipped); for Y = 0,
/// where `min_luma` allows it, the other conditions do not apply,
/// - its Mahalanobis distance from a component of `object` is at most `tolerance`, where the chroma's covariance from
/// pixel noise (`noise_grey_levels` in each channel) is added to the component's,
/// - no component of `background` is more likely.
/// A clipped channel may have been brighter than its value: it is replaced by the best-fitting value at or above it,
/// and the pixel's Y with that value is at most 360: otherwise near-white pixels would belong to any colour.
struct ColourModel {
  std::vector<ChromaComponent> object, background;
  double tolerance = 3;
  double min_luma = 12, max_luma = 250;  ///< Y, grey levels
  double noise_grey_levels = 2;          ///< standard deviation
  friend bool operator==(const ColourModel&, const ColourModel&) = default;
};
inline constexpr int kClipped = 248;

/// The chroma of a colour whose Y is positive.
Eigen::Vector2d chroma_of(const Rgb& colour);
/// The colour with this chroma and Y = 1.
Rgb colour_of(const Eigen::Vector2d& chroma);
/// Brightness Y, grey levels.
double luma_of(const Rgb& colour);

/// Converts a colour class to a model. Without pixel noise both contain the same pixels. Throws std::invalid_argument
/// for a class without references, with a black reference, or with a tolerance that is not positive.
ColourModel model_of(const ColourClass& colours);

/// The model with wider components of the object: the standard deviation `share` of a component's distance from grey is
/// added to it in each direction, that is, along the saturation and across it, along the hue.
ColourModel widened(ColourModel model, double share);

/// Throws std::invalid_argument, with the reason, for an invalid model: no component of the object, a covariance that
/// is not positive definite, a tolerance or weight that is not positive, negative or reversed limits, negative noise.
void check(const ColourModel& model);

/// Whether a pixel belongs to the object, as ColourModel defines. Slow: for many pixels use ChromaClassifier or
/// ColourTable.
bool is_member(const ColourModel& model, const WhiteBalanceGains& gains, const Rgb& pixel);

}  // namespace multireach::vision
