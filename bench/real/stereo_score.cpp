#include "bench/real/stereo_score.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "bench/real/score.hpp"
#include "tools/log/quantile.hpp"

namespace multireach::bench {
namespace {

constexpr double kLabelSigma = 0.5;  // px, standard deviation of a label's coordinates
constexpr double k95 = 7.815;        // 95 % of chi^2 with three degrees of freedom

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double each : values) sum += each;
  return sum / static_cast<double>(values.size());
}

}  // namespace

std::optional<vision::Triangulation> position_of_labels(const StereoRig& rig, const StereoPoint& px) {
  const auto ray = [](const CameraModel& camera, const cv::Point2d& at) {
    return vision::RayMeasurement{camera.ray({at.x, at.y}), vision::ray_covariance(camera, kLabelSigma)};
  };
  auto point = vision::triangulate(rig, ray(rig.left, px.left), ray(rig.right, px.right));
  if (point) point->covariance *= std::max(1.0, point->chi2 / point->degrees_of_freedom);
  return point;
}

void StereoScore::add(const StereoAnswer& answer, const StereoPoint& label, const vision::Triangulation& truth) {
  const double px = std::max(cv::norm(answer.px.left - label.left), cv::norm(answer.px.right - label.right));
  right += px <= kRight;
  wrong += px > kWrong;
  if (!answer.p_W) return;
  const Eigen::Vector3d error = *answer.p_W - truth.p_W;
  errors_mm.push_back(1000 * error.norm());
  if (answer.covariance)
    squared_sigmas.push_back(error.dot((*answer.covariance + truth.covariance).ldlt().solve(error)));
}

void StereoScore::add(const StereoScore& other) {
  labelled += other.labelled;
  right += other.right;
  wrong += other.wrong;
  errors_mm.insert(errors_mm.end(), other.errors_mm.begin(), other.errors_mm.end());
  squared_sigmas.insert(squared_sigmas.end(), other.squared_sigmas.begin(), other.squared_sigmas.end());
}

std::string StereoScore::error_cells() const {
  if (errors_mm.empty()) return " | ";
  std::vector<double> squares;
  for (const double each : errors_mm) squares.push_back(each * each);
  return fmt::format("{:.1f} | {:.1f}", quantile(errors_mm, 0.5), std::sqrt(mean_of(squares)));
}

std::string StereoScore::covariance_cells() const {
  if (squared_sigmas.empty()) return " | | ";
  const auto inside = static_cast<double>(std::ranges::count_if(squared_sigmas, [](double s) { return s < k95; }));
  return fmt::format("{:.2f} | {:.1f} % | {:.1f}", mean_of(squared_sigmas) / 3,
                     100 * inside / static_cast<double>(squared_sigmas.size()),
                     std::sqrt(std::ranges::max(squared_sigmas)));
}

}  // namespace multireach::bench
