#include "bench/real/score.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "imaging/lens.hpp"

namespace multireach::bench {

std::vector<AnsweredLabel> answered_labels(const std::vector<cv::Point2d>& labels,
                                           const std::vector<cv::Point2d>& answers, size_t targets) {
  struct Pair {
    size_t label, answer;
    double error_px;
  };
  std::vector<Pair> pairs;
  for (size_t i = 0; i < labels.size(); ++i) {
    for (size_t j = 0; j < answers.size(); ++j) pairs.push_back({i, j, cv::norm(labels[i] - answers[j])});
  }
  std::ranges::stable_sort(pairs, {}, &Pair::error_px);
  std::vector<AnsweredLabel> answered;
  for (const cv::Point2d& label : labels) answered.push_back({label});
  std::vector<bool> label_has(labels.size()), answer_has(answers.size());
  for (const Pair& pair : pairs) {
    if (label_has[pair.label] || answer_has[pair.answer]) continue;
    label_has[pair.label] = answer_has[pair.answer] = true;
    answered[pair.label].error_px = pair.error_px;
  }
  std::ranges::stable_sort(answered, {}, &AnsweredLabel::error_px);
  answered.resize(std::min(answered.size(), targets));
  return answered;
}

bool is_contradicted(const vision::PositionEstimate& answer, const StereoRig& rig,
                     const std::vector<cv::Point2d>& labels) {
  const Eigen::Vector3d p_L = rig.X_WL.inverse() * answer.position;
  const LensPoint shown = image_of(rig.left, p_L.hnormalized());
  Eigen::Matrix<double, 2, 3> d_ray_d_p_L;
  d_ray_d_p_L << Eigen::Matrix2d::Identity() / p_L.z(), -p_L.hnormalized() / p_L.z();
  const Eigen::Matrix<double, 2, 3> J = shown.d_pixel_d_ray * d_ray_d_p_L * rig.X_WL.linear().transpose();
  const Eigen::Matrix2d of_label = kHandLabelSigma * kHandLabelSigma * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d covariance = J * answer.covariance * J.transpose() + of_label;
  return std::ranges::all_of(labels, [&](const cv::Point2d& label) {
    const Eigen::Vector2d error = shown.pixel - Eigen::Vector2d(label.x, label.y);
    return error.dot(covariance.ldlt().solve(error)) > kContradicted * kContradicted;
  });
}

void Score::add(const std::vector<cv::Point2d>& answers, const std::vector<cv::Point2d>& labels, size_t targets) {
  for (const AnsweredLabel& each : answered_labels(labels, answers, targets)) {
    ++labelled;
    right += each.error_px <= kRight;
    if (each.error_px <= kWrong) errors_px.push_back(each.error_px);
  }
  for (const cv::Point2d& answer : answers) {
    const auto away = [&](const cv::Point2d& label) { return cv::norm(answer - label) > kWrong; };
    wrong += std::ranges::all_of(labels, away);
  }
}

void Score::add_without_label(const std::vector<cv::Point2d>& answers) {
  ++without;
  answered_without += !answers.empty();
}

void Score::add(const Score& other) {
  labelled += other.labelled;
  right += other.right;
  wrong += other.wrong;
  ambiguous += other.ambiguous;
  by_contour += other.by_contour;
  contradicted += other.contradicted;
  without += other.without;
  answered_without += other.answered_without;
  errors_px.insert(errors_px.end(), other.errors_px.begin(), other.errors_px.end());
}

double Score::median_px() const {
  if (errors_px.empty()) return 0;
  std::vector<double> sorted = errors_px;
  std::ranges::sort(sorted);
  return sorted[sorted.size() / 2];
}

}  // namespace multireach::bench
