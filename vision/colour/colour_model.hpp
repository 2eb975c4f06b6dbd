#pragma once

#include <Eigen/Core>
#include <vector>

#include "vision/colour/colour_class.hpp"

namespace multireach::vision {

/// A normal distribution of the chroma (U, V) = ((R - G)/Y, (B - G)/Y), Y = (R + 2G + B)/4, which does not change with
/// exposure. U and V lie between -2 and 4.
struct ChromaComponent {
  Eigen::Vector2d mean{0, 0};
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();
  double weight = 1;  ///< its share of all pixels of what it describes, or any multiple of that
};

/// The light of one camera, relative to that in which a model was learned: what red and blue are to be multiplied by to
/// look as they did then, green being left as it is. This is all that changes as a camera adapts to its light.
struct ColourShift {
  double red = 1, blue = 1;  ///< kSmallestGain to kLargestGain
  friend bool operator==(const ColourShift&, const ColourShift&) = default;
};
/// White balance that differs by more than this is another scene.
inline constexpr double kSmallestGain = 0.5, kLargestGain = 2;

/// The colours of one object as one camera sees them. A pixel belongs to the object when
/// - its Y is between `darkest` and `brightest`, and not all its channels are clipped (kClipped or more); Y = 0, where
/// that
///   is allowed, is enough,
/// - its Mahalanobis distance from one of `object` is at most `tolerance`, the uncertainty of its own chroma, from
/// noise of
///   `noise_grey_levels` in each channel, added to the component's covariance,
/// - none of `background` is a likelier source of it.
/// A clipped channel was at least as bright as it looks: it counts as whatever value above fits best.
struct ColourModel {
  std::vector<ChromaComponent> object, background;
  double tolerance = 3;
  double darkest = 12, brightest = 250;  ///< Y, grey levels
  double noise_grey_levels = 2;          ///< standard deviation
};
inline constexpr int kClipped = 248;

/// The chroma of a colour whose Y is positive.
Eigen::Vector2d chroma_of(const Rgb& colour);
/// The colour of unit Y that has this chroma.
Rgb colour_of(const Eigen::Vector2d& chroma);
/// Y, grey levels.
double luma_of(const Rgb& colour);

/// The model of a class that is given by reference colours: without noise, its members are exactly those of the class.
/// Throws std::invalid_argument for a class without references, with a black one, or a tolerance that is not positive.
ColourModel model_of(const ColourClass& colours);

/// Says what is wrong with a model, by std::invalid_argument: no component of the object, a covariance that is not
/// positive definite, a limit or a tolerance that is not positive.
void check(const ColourModel& model);

/// Whether a pixel belongs to the object, as ColourModel says: the definition, for one pixel at a time.
bool is_member(const ColourModel& model, const ColourShift& shift, const Rgb& pixel);

}  // namespace multireach::vision
