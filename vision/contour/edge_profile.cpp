#include "vision/contour/edge_profile.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace multireach::vision {
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
  for (cv::Vec3b& colour : profile.bgr) {
    colour = cv::Vec3b(pixel);
    pixel += step;
  }
  return true;
}

Eigen::Vector3d outside_slope(const EdgeProfile& profile, int half) {
  return (profile.at(half + EdgeModel::kSide) - profile.at(half + 1)) / (EdgeModel::kSide - 1);
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
