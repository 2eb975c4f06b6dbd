#pragma once

#include <vector>

#include "vision/colour/colour_model.hpp"

namespace multireach::vision {

/// A colour model under one light, made ready to be asked about many pixels.
class ChromaTest {
 public:
  /// Throws std::invalid_argument for a model that check() refuses.
  ChromaTest(const ColourModel& model, const ColourShift& shift);

  void set_shift(const ColourShift& shift);
  bool contains(const Rgb& pixel) const;
  /// What a pixel of the object, which is not clipped and not black, would be in the light in which the model was
  /// learned, by the component that it is nearest to and its brightness.
  Rgb expected(const Rgb& pixel) const;

 private:
  struct Component {
    double u, v;        // mean
    double uu, uv, vv;  // covariance
    double handicap;    // log det - 2 log weight: what it adds to twice the negative logarithm of its likelihood
    Rgb colour;         // of unit Y
  };
  /// Squared Mahalanobis distance of a chroma with the given covariance of its own.
  struct Chroma {
    double u, v, uu, uv, vv;
  };
  static double distance2(const Component& component, const Chroma& chroma);
  static Component component_of(const ChromaComponent& component);
  Chroma chroma_of_pixel(double r, double g, double b) const;
  bool may_fit(const Component& component, const Rgb& pixel) const;
  bool fits(const Component& component, Rgb pixel) const;
  Rgb unclipped(const Component& component, const Rgb& pixel) const;

  ColourModel model_;
  ColourShift shift_;
  std::vector<Component> object_, background_;
  double tolerance2_, variance_, largest_variance_;
};

}  // namespace multireach::vision
