#include "vision/colour/colour_model.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <stdexcept>

#include "vision/colour/chroma_classifier.hpp"

namespace multireach::vision {

double luma_of(const Rgb& colour) {
  return 0.25 * (colour.r + 2 * colour.g + colour.b);
}

Eigen::Vector2d chroma_of(const Rgb& colour) {
  const double luma = luma_of(colour);
  return {(colour.r - colour.g) / luma, (colour.b - colour.g) / luma};
}

Rgb colour_of(const Eigen::Vector2d& chroma) {
  const double u = chroma.x(), v = chroma.y();
  return {1 + (3 * u - v) / 4, 1 - (u + v) / 4, 1 + (3 * v - u) / 4};
}

ColourModel model_of(const ColourClass& colours) {
  if (colours.references.empty()) throw std::invalid_argument("the colour class needs at least one reference colour");
  if (!(colours.tolerance > 0)) throw std::invalid_argument("the colour class's tolerance must be positive");
  ColourModel model;
  model.min_luma = colours.min_luma;
  model.max_luma = colours.max_luma;
  const double sigma = colours.tolerance / model.tolerance;
  for (const Rgb& reference : colours.references) {
    if (!(luma_of(reference) > 0)) throw std::invalid_argument("a reference colour must not be black");
    model.object.push_back({chroma_of(reference), sigma * sigma * Eigen::Matrix2d::Identity()});
  }
  check(model);
  return model;
}

ColourModel widened(ColourModel model, double share) {
  for (ChromaComponent& component : model.object)
    component.covariance += share * share * component.mean.squaredNorm() * Eigen::Matrix2d::Identity();
  model.background.clear();
  return model;
}

void check(const ColourModel& model) {
  const auto require = [](bool sensible, const char* sentence) {
    if (!sensible) throw std::invalid_argument(sentence);
  };
  require(!model.object.empty(), "a colour model needs at least one component of the object");
  require(model.tolerance > 0, "a colour model's tolerance must be positive");
  require(model.min_luma >= 0 && model.max_luma > model.min_luma,
          "a colour model's max_luma must be above its min_luma, which must not be negative");
  require(model.noise_grey_levels >= 0, "a colour model's noise must not be negative");
  for (const auto* components : {&model.object, &model.background}) {
    for (const ChromaComponent& component : *components) {
      const Eigen::Matrix2d& C = component.covariance;
      require(component.mean.allFinite() && C.allFinite() && C(0, 1) == C(1, 0) && C(0, 0) > 0 && C.determinant() > 0,
              "a component's covariance must be symmetric and positive definite");
      require(component.weight > 0, "a component's weight must be positive");
    }
  }
}

bool is_member(const ColourModel& model, const WhiteBalanceGains& gains, const Rgb& pixel) {
  return ChromaClassifier(model, gains).contains(pixel);
}

}  // namespace multireach::vision
