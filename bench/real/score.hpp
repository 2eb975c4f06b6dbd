#pragma once

#include <limits>
#include <opencv2/core.hpp>
#include <vector>

#include "imaging/stereo_rig.hpp"
#include "vision/track/target_track.hpp"

namespace multireach::bench {

/// Distances from a label, pixels: answers within the first are right, beyond the second from all labels wrong.
inline constexpr double kRight = 10, kWrong = 25;
/// An answer is contradicted beyond so many standard deviations from all labels. Each coordinate of a label is taken to
/// have a standard deviation of kHandLabelSigma pixels, a choice: most are more accurate.
inline constexpr double kContradicted = 4, kHandLabelSigma = 5;
/// Share of wrong answers, per label, up to which a method counts as reliable.
inline constexpr double kFewWrong = 0.01;

/// A label, and how far the answer that belongs to it is away.
struct AnsweredLabel {
  cv::Point2d label;
  double error_px = std::numeric_limits<double>::infinity();  ///< infinite: none belongs to it
};

/// Gives each label of an image an answer of its own, those nearest to each other first, and returns the labels that
/// count, by their errors: at most `targets`, as many answers as are wanted at most.
std::vector<AnsweredLabel> answered_labels(const std::vector<cv::Point2d>& labels,
                                           const std::vector<cv::Point2d>& answers, size_t targets);

/// Whether the labels contradict an answer, by its covariance as the left image shows it.
bool is_contradicted(const vision::PositionEstimate& answer, const StereoRig& rig,
                     const std::vector<cv::Point2d>& labels);

/// Answers of one method to the labels of a video. Several objects that look alike have several labels in an image, and
/// as many answers.
struct Score {
  int labelled = 0, right = 0, wrong = 0, ambiguous = 0, by_contour = 0, contradicted = 0;
  int without = 0, answered_without = 0;  ///< images without a label, in which the object may still be
  std::vector<double> errors_px;          ///< of answers that are not wrong

  /// Takes the answers to an image with labels.
  void add(const std::vector<cv::Point2d>& answers, const std::vector<cv::Point2d>& labels, size_t targets);
  /// Takes the answers to an image without one.
  void add_without_label(const std::vector<cv::Point2d>& answers);
  void add(const Score& other);
  double median_px() const;
};

}  // namespace multireach::bench
