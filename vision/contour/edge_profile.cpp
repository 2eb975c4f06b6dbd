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

bool read_profile(const cv::Mat& image, const Edgel& edgel, EdgeProfile& profile) {
  constexpr int kReach = EdgeProfile::kReach;
  const int limit = edgel.along_row ? image.cols : image.rows, lines = edgel.along_row ? image.rows : image.cols;
  if (edgel.line < 0 || edgel.line >= lines) return false;
  const double place = std::floor(edgel.at + 0.5);
  if (!(place >= kReach && place < limit - kReach)) return false;
  profile.middle = static_cast<int>(place);
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
  const double place = std::min(edge, 0.5 * (begin + end));
  Eigen::Vector2d from_centre = edgel.normal;
  from_centre[edgel.along_row ? 0 : 1] += edgel.outward * (place - edge) / radius_px;
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
      const double place = k - 0.5;
      moment += (previous - share) * place;
      moment2 += (previous - share) * place * place;
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

  /// Edge position by least squares from the start `place`, for a known blur: the noise of pixels that the edge does
  /// not touch has no effect. Returns `place` when the fit fails.
  double by_shape(double place, double spread_px) {
    const Coverage coverage(spread_px);
    constexpr int kSteps = 3;
    double at = place;
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
      if (squares < kLeast) return place;
      for (double& slope : slopes) slope /= squares;
      at += std::clamp(sum / squares, -0.5, 0.5);
    }
    if (!(std::abs(at - place) < 1)) return place;
    influence = slopes;
    return at;
  }
};

}  // namespace

bool measure_edge(const EdgeProfile& profile, const Edgel& edgel, const EdgeModel& model, const Shading& shading,
                  Edge& edge) {
  const int half = model.half;
  const double noise2 = model.noise * model.noise;
  // A slope over three pixels has the noise variance noise^2 / 2: shrink it by the usual variance of slopes (Wiener).
  const double slope_noise2 = noise2 / 2, belief = model.outside_slope2 / (model.outside_slope2 + slope_noise2);
  const Eigen::Vector3d slope = belief * outside_slope(profile, model);
  const Eigen::Vector3d inside = mean_inside(profile, model), outside = mean_outside(profile, model);
  const double outside_middle = half + 0.5 * (kSide + 1);
  // Shading of the object relative to the pixels next to the window, represented by the middle one of them.
  const auto terms_at = [&](int k) { return Shading::terms_of(surface_normal(profile, edgel, model.radius_px, k)); };
  Shading::Terms beside = Shading::Terms::Zero(), at_rim = Shading::Terms::Zero(), sum = Shading::Terms::Zero();
  const double expected = (edgel.at - profile.middle) * edgel.outward;
  const int last_inside = static_cast<int>(std::floor(expected + 0.5));  // pixel that contains the edge
  if (shading.known()) {
    beside = terms_at(-half - (kSide + 1) / 2);
    at_rim = terms_at(last_inside) - beside;
  }
  const Eigen::Vector3d rim = inside + shading.colour(at_rim);

  // Fisher's discriminant. The noise is equal in all channels, plus shading error along the object's own colour, plus,
  // where the chroma is unreliable, chroma error perpendicular to the brightness direction.
  const Eigen::Vector3d difference = rim - (outside - slope * outside_middle);
  const double brightness2 = std::max(1.0, rim.squaredNorm());
  const double shading2 = model.shading_error * model.shading_error * brightness2;
  const Eigen::Vector3d y = luma_direction();
  const double chroma2 = model.chroma_error * model.chroma_error * difference.squaredNorm();
  const double colour2 = kColourError * kColourError;
  Eigen::Matrix3d disturbing = (noise2 + colour2 + chroma2) * Eigen::Matrix3d::Identity();
  disturbing += (shading2 / brightness2) * rim * rim.transpose() - chroma2 * y * y.transpose();
  const Eigen::Vector3d w = disturbing.inverse() * difference;
  const double span = w.dot(difference), length = w.norm();
  if (!(span > kMinContrast * length)) return false;

  Window window{.half = half};
  std::array<Shading::Terms, Window::kMost> shaded;
  for (int k = -half; k <= half; ++k) {
    Shading::Terms& here = shaded[static_cast<size_t>(half + k)];
    here = shading.known() && k < last_inside ? Shading::Terms(terms_at(k) - beside) : at_rim;
    const Eigen::Vector3d of_object = inside + shading.colour(here);
    const Eigen::Vector3d of_background = outside + slope * (k - outside_middle);
    const double whole = w.dot(of_object - of_background);
    if (!(whole > 0.2 * span)) return false;
    window.share_of(k) = w.dot(profile.at(k) - of_background) / whole;
  }
  double from_middle = window.by_area();  // outwards
  if (model.blur2 >= 0) {
    const double tilt2 = 1 / (edgel.cosine * edgel.cosine) - 1;
    from_middle = window.by_shape(from_middle, std::sqrt(tilt2 + 12 * model.blur2));
  }
  if (!(std::abs(from_middle - expected) < half)) return false;
  edge.at = profile.middle + edgel.outward * from_middle;
  // d at / d inside = -covered, d at / d outside = -uncovered, each the mean of kSide pixels; d at / d slope = -lever.
  double covered = 0, uncovered = 0, lever = 0, pixels = 0;
  for (int k = -half; k <= half; ++k) {
    const auto i = static_cast<size_t>(half + k);
    const double share = window.share[i], influence = window.influence[i];
    covered += influence * share;
    uncovered += influence * (1 - share);
    lever += influence * (1 - share) * (k - outside_middle);
    pixels += influence * influence;
    sum += influence * std::clamp(share, 0.0, 1.0) * shaded[i];
  }
  const double gain2 = length * length / (span * span);
  const double random =
      noise2 * (pixels + (covered * covered + uncovered * uncovered) / kSide) +
      lever * lever * (belief * belief * slope_noise2 + (1 - belief) * (1 - belief) * model.outside_slope2);
  // Background texture: curvature of the background beyond what the noise explains.
  const double second = w.dot(profile.at(half + 1) - 2 * profile.at(half + 2) + profile.at(half + 3)) / span;
  const double texture = uncovered * uncovered * std::max(0.0, second * second / 6 - gain2 * noise2);
  edge.sigma_px = std::sqrt(gain2 * random + texture);
  // The shading model's error acts on about one pixel at most; the error of its fit acts on all covered pixels.
  edge.shading_px = model.shading_error * w.dot(rim) / span * std::clamp(covered, 0.0, 1.0);
  edge.shading_terms = sum;
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
