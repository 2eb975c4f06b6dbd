#include "bench/real/limited_baseline.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace multireach::bench {

void LimitedBaseline::add(std::vector<Baseline::Contour> contours, std::vector<cv::Point2d> labels, size_t targets) {
  images_.push_back({std::move(contours), std::move(labels), targets});
}

Score LimitedBaseline::score(double least_px, double most_px) const {
  Score score;
  for (const Image& image : images_) {
    std::vector<Baseline::Contour> between;
    std::ranges::copy_if(image.contours, std::back_inserter(between), [&](const Baseline::Contour& contour) {
      return contour.area_px >= least_px && contour.area_px <= most_px;
    });
    score.add(largest(between, image.targets), image.labels, image.targets);
  }
  return score;
}

Score LimitedBaseline::best(double most_wrong) const {
  constexpr size_t kSteps = 50;  // limits that are tried for each end: quantiles of the areas
  std::vector<double> areas;
  for (const Image& image : images_) {
    for (const Baseline::Contour& contour : image.contours) areas.push_back(contour.area_px);
  }
  std::ranges::sort(areas);
  std::vector<double> limits;
  for (size_t k = 0; k <= kSteps && !areas.empty(); ++k) limits.push_back(areas[k * (areas.size() - 1) / kSteps]);
  Score best = score(1, 0);  // no answers
  for (size_t low = 0; low < limits.size(); ++low) {
    for (size_t high = low; high < limits.size(); ++high) {
      const Score other = score(limits[low], limits[high]);
      if (other.right > best.right && other.wrong <= most_wrong * other.labelled) best = other;
    }
  }
  return best;
}

}  // namespace multireach::bench
