#include "bench/real/limited_baseline.hpp"

#include <algorithm>
#include <iterator>
#include <set>
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
  constexpr size_t kMost = 80;  // limits that are tried for each end
  // Other limits than the areas of the objects exclude no more of the rest.
  std::set<double> areas;
  for (const Image& image : images_) {
    for (const Baseline::Contour& contour : image.contours) {
      const auto near = [&](const cv::Point2d& label) { return cv::norm(label - contour.centre) <= kRight; };
      if (std::ranges::any_of(image.labels, near)) areas.insert(contour.area_px);
    }
  }
  const std::vector<double> all(areas.begin(), areas.end());
  std::vector<double> limits;
  const size_t steps = std::min(kMost, all.size());
  for (size_t k = 0; k < steps; ++k) limits.push_back(all[steps < 2 ? 0 : k * (all.size() - 1) / (steps - 1)]);
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
