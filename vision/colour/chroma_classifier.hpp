#pragma once

#include <vector>

#include "vision/colour/colour_model.hpp"

namespace multireach::vision {

/// A colour model for given white-balance gains, prepared for classifying many pixels.
class ChromaClassifier {
 public:
  /// Throws std::invalid_argument for a model that check() rejects.
  ChromaClassifier(const ColourModel& model, const WhiteBalanceGains& gains);

  void set_gains(const WhiteBalanceGains& gains);
  bool contains(const Rgb& pixel) const;
  /// The colour that an object pixel (neither clipped nor black) would have in the light in which the model was
  /// learned: the mean of the nearest component at the pixel's brightness.
  Rgb expected(const Rgb& pixel) const;
  /// Mahalanobis distance of an object's mean colour from the learned one, pixel noise not counted. 0 where several
  /// colours were learned: their mixture tells nothing.
  double deviation(const Rgb& colour) const;

 private:
  struct Component {
    double u, v;        // mean
    double uu, uv, vv;  // covariance
    double handicap;    // log det - 2 log weight, added to distance2 gives -2 log likelihood up to a constant
    Rgb colour;         // mean colour at Y = 1
  };
  /// Chroma of a pixel with its covariance.
  struct Chroma {
    double u, v, uu, uv, vv;
  };
  /// Squared Mahalanobis distance; the covariances of the component and of the chroma add up.
  static double distance2(const Component& component, const Chroma& chroma);
  static Component component_of(const ChromaComponent& component);
  Chroma chroma_of_pixel(double r, double g, double b) const;
  bool may_fit(const Component& component, const Rgb& pixel) const;
  bool fits(const Component& component, Rgb pixel) const;
  Rgb unclipped(const Component& component, const Rgb& pixel) const;

  ColourModel model_;
  WhiteBalanceGains gains_;
  std::vector<Component> object_, background_;
  double tolerance2_, variance_, largest_variance_;
};

}  // namespace multireach::vision
