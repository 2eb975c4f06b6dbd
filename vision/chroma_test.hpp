#pragma once

#include <vector>

#include "vision/colour_model.hpp"

namespace multireach::vision {

/// A colour model under one light, made ready to be asked about many pixels.
class ChromaTest {
 public:
  /// Throws std::invalid_argument for a model that check() refuses.
  ChromaTest(const ColourModel& model, const ColourShift& shift);

  bool contains(const Rgb& pixel) const;
  /// The index of the component of the object that is nearest to an unclipped pixel whose Y is positive.
  size_t nearest(const Rgb& pixel) const;

 private:
  struct Component {
    double u, v;        // mean
    double uu, uv, vv;  // covariance
    double handicap;    // log det - 2 log weight: what it adds to twice the negative logarithm of its likelihood
    Rgb colour;         // of unit Y in the camera's light, for clipped channels
  };
  /// Squared Mahalanobis distance of a chroma with the given covariance of its own.
  struct Chroma {
    double u, v, uu, uv, vv;
  };
  static double distance2(const Component& component, const Chroma& chroma);
  Component component_of(const ChromaComponent& component) const;
  Chroma chroma_of_pixel(double r, double g, double b) const;
  bool fits(const Component& component, const Rgb& pixel) const;

  ColourModel model_;
  ColourShift shift_;
  std::vector<Component> object_, background_;
  double tolerance2_, variance_;
};

}  // namespace multireach::vision
