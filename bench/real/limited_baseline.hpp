#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "bench/real/baseline.hpp"
#include "bench/real/score.hpp"

namespace multireach::bench {

/// The baseline with limits of a contour's area, which are chosen from the labels: of those with few wrong answers, the
/// ones with the most right answers. No user knows them beforehand.
class LimitedBaseline {
 public:
  /// Takes the contours, the largest first, and the labels of an image.
  void add(std::vector<Baseline::Contour> contours, std::vector<cv::Point2d> labels, size_t targets);
  /// Its answers by the best limits. `most_wrong`: largest share of wrong answers, per label.
  Score best(double most_wrong) const;

 private:
  struct Image {
    std::vector<Baseline::Contour> contours;
    std::vector<cv::Point2d> labels;
    size_t targets = 1;
  };

  Score score(double least_px, double most_px) const;

  std::vector<Image> images_;
};

}  // namespace multireach::bench
