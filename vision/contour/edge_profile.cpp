#include "vision/contour/edge_profile.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

namespace multireach::vision {
namespace {

constexpr int kSide = EdgeModel::kSide;
constexpr double kMinContrast = 12;  // grey levels
// Error of the colours of both sides in any direction, apart from the noise, grey levels. Without it, noise-free images
// would not use the rim's brightness at all, which is most of the contrast in front of a dark background.
constexpr double kColourError = 1.5;

/// The direction of brightness in BGR (Rec. 601), of unit length.
Eigen::Vector3d luma_direction() {
  return Eigen::Vector3d(0.114, 0.587, 0.299) / 0.66856;
}

Eigen::Vector3d mean_inside(const EdgeProfile& profile, const EdgeModel& model) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int k = 1; k <= kSide; ++k) sum += profile.at(-model.half - k);
  return sum / kSide;
}

Eigen::Vector3d mean_outside(const EdgeProfile& profile, const EdgeModel& model) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int k = 1; k <= kSide; ++k) sum += profile.at(model.half + k);
  return sum / kSide;
}

}  // namespace

bool read_profile(const cv::Mat& image, const cv::Rect& readable, const Edgel& edgel, EdgeProfile& profile) {
  constexpr int kReach = EdgeProfile::kReach;
  const cv::Point begin = readable.tl(), end = readable.br();
  const int first_line = edgel.along_row ? begin.y : begin.x, lines = edgel.along_row ? end.y : end.x;
  if (edgel.line < first_line || edgel.line >= lines) return false;
  const int first = edgel.along_row ? begin.x : begin.y, limit = edgel.along_row ? end.x : end.y;
  const double position = std::floor(edgel.at + 0.5);
  if (!(position >= first + kReach && position < limit - kReach)) return false;
  profile.middle = static_cast<int>(position);
  const ptrdiff_t step = (edgel.along_row ? ptrdiff_t{3} : static_cast<ptrdiff_t>(image.step[0])) * edgel.outward;
  const uint8_t* pixel = (edgel.along_row ? image.ptr<uint8_t>(edgel.line) + ptrdiff_t{3} * profile.middle
                                          : image.ptr<uint8_t>(profile.middle) + ptrdiff_t{3} * edgel.line) -
                         step * kReach;
  for (Eigen::Vector3d& colour : profile.bgr) {
    colour = Eigen::Vector3d(pixel[0], pixel[1], pixel[2]);
    pixel += step;
  }
  return true;
}

Eigen::Vector3d surface_normal(const EdgeProfile& profile, const Edgel& edgel, double radius_px, int outwards) {
  const double edge = (edgel.at - profile.middle) * edgel.outward;
  const double begin = outwards - 0.5, end = std::clamp(edge, begin, outwards + 0.5);
  const double position = std::min(edge, 0.5 * (begin + end));
  Eigen::Vector2d from_centre = edgel.normal;
  from_centre[edgel.along_row ? 0 : 1] += edgel.outward * (position - edge) / radius_px;
  const double r2 = from_centre.squaredNorm();
  if (r2 > 1) from_centre /= std::sqrt(r2);
  return {from_centre.x(), from_centre.y(), std::sqrt(std::max(0.0, 1 - r2))};
}

Shading::Terms Shading::terms_of(const Eigen::Vector3d& n) {
  Terms terms;
  terms << 1, n.x(), n.y(), n.z(), n.x() * n.y(), n.x() * n.z(), n.y() * n.z(), n.x() * n.x() - n.y() * n.y(),
      3 * n.z() * n.z() - 1;
  return terms;
}

void Shading::clear() {
  normal_equations_.setZero();
  products_.setZero();
  terms_.setZero();
  covariance_.setZero();
  known_ = false;
}

void Shading::add(const Eigen::Vector3d& normal, const Eigen::Vector3d& bgr) {
  const Terms terms = terms_of(normal);
  for (int column = 0; column < kTerms; ++column) {
    for (int row = column; row < kTerms; ++row) normal_equations_(row, column) += terms[row] * terms[column];
  }
  for (int channel = 0; channel < 3; ++channel) products_.col(channel) += bgr[channel] * terms;
}

void Shading::solve() {
  // Ridge penalties: second-order shading terms are weaker than first-order terms, and those than the constant.
  constexpr double kFirst = 0.02, kSecond = 0.5;
  Terms kept_small;
  for (int k = 0; k < kTerms; ++k) kept_small[k] = k == 0 ? 0 : k < 4 ? kFirst : kSecond;
  normal_equations_.diagonal() += kept_small;
  // LDLT reads the lower triangle only.
  const Matrix inverse = normal_equations_.ldlt().solve(Matrix::Identity());
  terms_.noalias() = inverse * products_;
  // Covariance of a ridge regression: the penalties carry no noise.
  covariance_ = inverse - inverse * kept_small.asDiagonal() * inverse;
  known_ = true;
}

Eigen::Vector3d outside_slope(const EdgeProfile& profile, const EdgeModel& model) {
  return (profile.at(model.half + kSide) - profile.at(model.half + 1)) / (kSide - 1);
}

EdgeBlur blur_of(const EdgeProfile& profile, const Edgel& edgel, const EdgeModel& model) {
  const Eigen::Vector3d outside = mean_outside(profile, model), difference = mean_inside(profile, model) - outside;
  const double tilt2 = 1 / (edgel.cosine * edgel.cosine) - 1;
  const auto along = [&](const Eigen::Vector3d& w) {
    const double span = w.dot(difference);
    double moment = 0, moment2 = 0, previous = 1;
    for (int k = -model.half; k <= model.half + 1; ++k) {
      const double share = k <= model.half ? w.dot(profile.at(k) - outside) / span : 0;
      const double position = k - 0.5;
      moment += (previous - share) * position;
      moment2 += (previous - share) * position * position;
      previous = share;
    }
    // Subtract the variance of the pixel's width (1/12) twice: once for each pixel's average, once for the difference.
    return moment2 - moment * moment - 1.0 / 6 - tilt2 / 12;
  };
  EdgeBlur blur;
  const double luma = luma_direction().dot(difference);
  blur.luma_share = luma * luma / std::max(1.0, difference.squaredNorm());
  blur.colour2 = along(difference);
  blur.luma2 = luma == 0 ? 0 : along(luma_direction());
  return blur;
}

namespace {

/// The object's share of a pixel as a function of the edge position. The edge is averaged over two boxes: the pixel's
/// width, and a box for the edge's slant and the blur.
class Coverage {
 public:
  explicit Coverage(double spread_px) {
    constexpr double kSharpest = 0.05;  // px
    const double spread = std::max(spread_px, kSharpest);
    height_ = 1 / std::max(1.0, spread);
    flat_ = 0.5 * std::abs(1 - spread);
    ramp_ = std::min(1.0, spread);
  }
  /// The object's share for an edge `d` px outwards of the pixel's centre.
  double share(double d) const { return 0.5 + std::copysign(half_share(std::abs(d)), d); }
  /// Derivative of share().
  double slope(double d) const {
    const double beyond = std::abs(d) - flat_;
    return beyond <= 0 ? height_ : beyond < ramp_ ? height_ * (1 - beyond / ramp_) : 0;
  }

 private:
  double half_share(double d) const {
    if (d <= flat_) return height_ * d;
    const double rest = std::max(0.0, 1 - (d - flat_) / ramp_);
    return height_ * (flat_ + 0.5 * ramp_ * (1 - rest * rest));
  }
  double height_, flat_, ramp_;  // trapezoid: its height, half its flat top and the width of each ramp
};

/// The object's share of each pixel in a window, and the derivative of the edge position with respect to each share.
struct Window {
  static constexpr int kMost = 7;
  int half = 2;
  std::array<double, kMost> share{}, influence{};
  double& share_of(int k) { return share[static_cast<size_t>(half + k)]; }

  /// Edge position from the sum of the shares; needs no blur model.
  double by_area() {
    double covered = 0;
    for (int k = -half; k <= half; ++k) {
      covered += share_of(k);
      influence[static_cast<size_t>(half + k)] = 1;
    }
    return covered - (half + 0.5);
  }

  /// Edge position by least squares from the start `position`, for a known blur: the noise of pixels that the edge does
  /// not touch has no effect. Returns `position` when the fit fails.
  double by_shape(double position, double spread_px) {
    const Coverage coverage(spread_px);
    constexpr int kSteps = 3;
    double at = position;
    std::array<double, kMost> slopes{};
    for (int step = 0; step < kSteps; ++step) {
      double squares = 0, sum = 0;
      for (int k = -half; k <= half; ++k) {
        const auto i = static_cast<size_t>(half + k);
        slopes[i] = coverage.slope(at - k);
        squares += slopes[i] * slopes[i];
        sum += slopes[i] * (share[i] - coverage.share(at - k));
      }
      constexpr double kLeast = 0.1;
      if (squares < kLeast) return position;
      for (double& slope : slopes) slope /= squares;
      at += std::clamp(sum / squares, -0.5, 0.5);
    }
    if (!(std::abs(at - position) < 1)) return position;
    influence = slopes;
    return at;
  }
};

/// The colours of both sides of an edge, taken next to its window.
struct Sides {
  Eigen::Vector3d inside, outside;
  Eigen::Vector3d slope;      // of the background's colour, per pixel
  double belief = 0;          // in the measured slope
  double slope_noise2 = 0;    // its variance
  double outside_middle = 0;  // where `outside` holds, pixels outwards of the window's middle

  Sides(const EdgeProfile& profile, const EdgeModel& model)
      : slope_noise2(model.noise * model.noise / 2), outside_middle(model.half + 0.5 * (kSide + 1)) {
    // A slope over three pixels has the noise variance noise^2 / 2: shrink it by the usual variance of slopes (Wiener).
    belief = model.outside_slope2 / (model.outside_slope2 + slope_noise2);
    slope = belief * outside_slope(profile, model);
    inside = mean_inside(profile, model);
    outside = mean_outside(profile, model);
  }
};

/// Shading of the object across an edge, relative to the pixels next to the window, represented by the middle one of
/// them.
class RimShading {
 public:
  RimShading(const EdgeProfile& profile, const Edgel& edgel, const EdgeModel& model, const Shading& shading)
      : profile_(profile),
        edgel_(edgel),
        radius_px_(model.radius_px),
        known_(shading.known()),
        last_inside_(static_cast<int>(std::floor((edgel.at - profile.middle) * edgel.outward + 0.5))) {
    if (!known_) return;
    beside_ = terms_at(-model.half - (kSide + 1) / 2);
    at_rim_ = terms_at(last_inside_) - beside_;
  }
  const Shading::Terms& at_rim() const { return at_rim_; }
  /// At a pixel of the window; at the rim and beyond, that of the rim.
  Shading::Terms at(int k) const {
    return known_ && k < last_inside_ ? Shading::Terms(terms_at(k) - beside_) : at_rim_;
  }

 private:
  Shading::Terms terms_at(int k) const { return Shading::terms_of(surface_normal(profile_, edgel_, radius_px_, k)); }

  const EdgeProfile& profile_;
  const Edgel& edgel_;
  double radius_px_;
  bool known_;
  int last_inside_;  // pixel that contains the edge
  Shading::Terms beside_ = Shading::Terms::Zero(), at_rim_ = Shading::Terms::Zero();
};

/// Fisher's discriminant between the rim's colour and the background's. The noise is equal in all channels, plus
/// shading error along the object's own colour, plus, where the chroma is unreliable, chroma error perpendicular to the
/// brightness direction.
Eigen::Vector3d discriminant(const Eigen::Vector3d& rim, const Eigen::Vector3d& difference, const EdgeModel& model) {
  const double noise2 = model.noise * model.noise;
  const double brightness2 = std::max(1.0, rim.squaredNorm());
  const double shading2 = model.shading_error * model.shading_error * brightness2;
  const Eigen::Vector3d y = luma_direction();
  const double chroma2 = model.chroma_error * model.chroma_error * difference.squaredNorm();
  const double colour2 = kColourError * kColourError;
  Eigen::Matrix3d disturbing = (noise2 + colour2 + chroma2) * Eigen::Matrix3d::Identity();
  disturbing += (shading2 / brightness2) * rim * rim.transpose() - chroma2 * y * y.transpose();
  return disturbing.inverse() * difference;
}

using ShadingOfWindow = std::array<Shading::Terms, Window::kMost>;

/// Sets the edge's errors from the shares of the window's pixels and their influence. `w` is the discriminant, `span`
/// its value for the difference of both sides.
void propagate_errors(const EdgeProfile& profile, const EdgeModel& model, const Window& window, const Sides& sides,
                      const ShadingOfWindow& shaded, const Eigen::Vector3d& rim, const Eigen::Vector3d& w, double span,
                      Edge& edge) {
  const int half = model.half;
  const double noise2 = model.noise * model.noise, length = w.norm();
  // d at / d inside = -covered, d at / d outside = -uncovered, each the mean of kSide pixels; d at / d slope = -lever.
  double covered = 0, uncovered = 0, lever = 0, pixels = 0;
  Shading::Terms sum = Shading::Terms::Zero();
  for (int k = -half; k <= half; ++k) {
    const auto i = static_cast<size_t>(half + k);
    const double share = window.share[i], influence = window.influence[i];
    covered += influence * share;
    uncovered += influence * (1 - share);
    lever += influence * (1 - share) * (k - sides.outside_middle);
    pixels += influence * influence;
    sum += influence * std::clamp(share, 0.0, 1.0) * shaded[i];
  }
  const double gain2 = length * length / (span * span), belief = sides.belief;
  const double random =
      noise2 * (pixels + (covered * covered + uncovered * uncovered) / kSide) +
      lever * lever * (belief * belief * sides.slope_noise2 + (1 - belief) * (1 - belief) * model.outside_slope2);
  // Background texture: curvature of the background beyond what the noise explains.
  const double second = w.dot(profile.at(half + 1) - 2 * profile.at(half + 2) + profile.at(half + 3)) / span;
  const double texture = uncovered * uncovered * std::max(0.0, second * second / 6 - gain2 * noise2);
  edge.sigma_px = std::sqrt(gain2 * random + texture);
  // The shading model's error acts on about one pixel at most; the error of its fit acts on all covered pixels.
  edge.shading_px = model.shading_error * w.dot(rim) / span * std::clamp(covered, 0.0, 1.0);
  edge.shading_terms = sum;
}

}  // namespace

bool measure_edge(const EdgeProfile& profile, const Edgel& edgel, const EdgeModel& model, const Shading& shading,
                  Edge& edge) {
  const int half = model.half;
  const Sides sides(profile, model);
  const RimShading rim_shading(profile, edgel, model, shading);
  const Eigen::Vector3d rim = sides.inside + shading.colour(rim_shading.at_rim());
  const Eigen::Vector3d difference = rim - (sides.outside - sides.slope * sides.outside_middle);
  const Eigen::Vector3d w = discriminant(rim, difference, model);
  const double span = w.dot(difference);
  if (!(span > kMinContrast * w.norm())) return false;

  Window window{.half = half};
  ShadingOfWindow shaded;
  for (int k = -half; k <= half; ++k) {
    Shading::Terms& here = shaded[static_cast<size_t>(half + k)];
    here = rim_shading.at(k);
    const Eigen::Vector3d of_object = sides.inside + shading.colour(here);
    const Eigen::Vector3d of_background = sides.outside + sides.slope * (k - sides.outside_middle);
    const double whole = w.dot(of_object - of_background);
    if (!(whole > 0.2 * span)) return false;
    window.share_of(k) = w.dot(profile.at(k) - of_background) / whole;
  }
  double from_middle = window.by_area();  // outwards
  if (model.blur2 >= 0) {
    const double tilt2 = 1 / (edgel.cosine * edgel.cosine) - 1;
    from_middle = window.by_shape(from_middle, std::sqrt(tilt2 + 12 * model.blur2));
  }
  const double expected = (edgel.at - profile.middle) * edgel.outward;
  if (!(std::abs(from_middle - expected) < half)) return false;
  edge.at = profile.middle + edgel.outward * from_middle;
  propagate_errors(profile, model, window, sides, shaded, rim, w, span, edge);
  edge.shading_gain = -edgel.outward / span * w;
  return true;
}

void NoiseEstimator::add(const EdgeProfile& profile) {
  constexpr int kFirst = -EdgeProfile::kReach;
  const Eigen::Vector3d second = profile.at(kFirst) - 2 * profile.at(kFirst + 1) + profile.at(kFirst + 2);
  for (int channel = 0; channel < 3; ++channel)
    ++counts_[static_cast<size_t>(std::min(std::abs(static_cast<int>(second[channel])), 127))];
  total_ += 3;
}

double NoiseEstimator::sigma() const {
  constexpr double kRounding = 0.29;  // 1 / sqrt(12)
  if (total_ == 0) return 1;
  // Median of the histogram, with the counts spread evenly over each bin.
  int below = 0;
  size_t bin = 0;
  while (2 * (below + counts_[bin]) < total_) below += counts_[bin++];
  const double inside = (0.5 * total_ - below) / counts_[bin];
  const double median = std::max(0.0, static_cast<double>(bin) - 0.5 + inside);
  return std::max(kRounding, median / (0.6745 * std::sqrt(6.0)));
}

}  // namespace multireach::vision
