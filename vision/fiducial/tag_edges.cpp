#include "vision/fiducial/tag_edges.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "imaging/lens.hpp"
#include "vision/fiducial/tag_detector.hpp"

namespace multireach::vision {
namespace {

constexpr double kReach = 0.8;         // share of a cell that a profile reaches to both sides of the edge
constexpr double kLongestReach = 6;    // pixels
constexpr double kSmallestCell = 1.5;  // pixels
constexpr double kStep = 0.25;         // pixels, along a profile
constexpr int kMostSamples = 64;       // profiles along a side
constexpr int kFewestSamples = 5;
constexpr double kPlateau = 0.75;      // from this share of its reach on, a profile is flat ...
constexpr double kTransition = 0.5;    // ... and at this share it must be within kLevel of the flat part
constexpr double kLevel = 0.1;         // share of the contrast, ...
constexpr double kLevelOfSmall = 0.2;  // ... where the reach is less than kWhole: pixels themselves blur by one
constexpr double kLeastContrast = 20;  // grey levels
constexpr double kWidestScatter = 1;   // pixels, of the displacements about their line
// Error that neighbouring profiles share, by rendered tags at all angles: pixels, at each end of a side. A profile of
// less than kWhole pixels to each side of the edge does not hold the whole transition: the error grows.
constexpr double kCommonError = 0.012;
constexpr double kWhole = 3;
constexpr double kCorrelation = 2;  // profiles a pixel apart share pixels: as many independent ones as half of them

/// Luma between the pixels, by bilinear interpolation. The point must be inside the image by a pixel.
double luma(const cv::Mat& bgr, const Eigen::Vector2d& at) {
  const double x = std::floor(at.x()), y = std::floor(at.y()), u = at.x() - x, v = at.y() - y;
  const auto* above = bgr.ptr<cv::Vec3b>(static_cast<int>(y)) + static_cast<int>(x);
  const auto* below = bgr.ptr<cv::Vec3b>(static_cast<int>(y) + 1) + static_cast<int>(x);
  const auto grey = [](const cv::Vec3b& p) { return 0.25 * (p[0] + 2 * p[1] + p[2]); };
  return (1 - v) * ((1 - u) * grey(above[0]) + u * grey(above[1])) +
         v * ((1 - u) * grey(below[0]) + u * grey(below[1]));
}

/// One point of the predicted edge.
struct Sample {
  double along = 0;  // -1 to 1 from one end of the sampled part to the other
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, kTagUnknowns> J;
};

/// A side of the square: its samples, and the brightness profiles across it, one after the other.
struct Profiles {
  std::vector<Sample> samples;
  std::vector<double> values;
  Eigen::Vector2d normal{0, 0};  // outward
  double reach = 0;
  int steps = 0;  // values of a profile, from inside to outside

  double at(size_t sample, int step) const { return values[sample * static_cast<size_t>(steps) + step]; }
  double offset(int step) const { return (step + 0.5) * (2 * reach / steps) - reach; }
};

/// Mean brightness of all profiles between two offsets, pixels.
double level(const Profiles& p, double from, double to) {
  double sum = 0, count = 0;
  for (int step = 0; step < p.steps; ++step) {
    if (p.offset(step) < from || p.offset(step) > to) continue;
    for (size_t k = 0; k < p.samples.size(); ++k) sum += p.at(k, step);
    count += static_cast<double>(p.samples.size());
  }
  return count > 0 ? sum / count : 0;
}

EdgeFault sample_side(const TagCamera& camera, const TagPlacement& tag, double size_m, int k, Profiles& side) {
  const Eigen::Vector2d a = size_m * tag_corner(k), b = size_m * tag_corner((k + 1) % 4), middle = 0.5 * (a + b);
  Eigen::Matrix<double, 2, kTagUnknowns> J;
  Eigen::Vector2d first, last, inner, outer;
  const Eigen::Vector2d out_T = middle.normalized() * (size_m / kTagCells);
  for (const auto& [p_T, pixel] :
       {std::pair(a, &first), {b, &last}, {middle, &inner}, {Eigen::Vector2d(middle + out_T), &outer}}) {
    if (!project(camera, tag, p_T, *pixel, J)) return EdgeFault::kCutOff;
  }
  const Eigen::Vector2d way = (last - first).normalized();
  side.normal = {-way.y(), way.x()};
  if (side.normal.dot(outer - inner) < 0) side.normal = -side.normal;
  const double cell = side.normal.dot(outer - inner), length = (last - first).norm();
  if (!(cell >= kSmallestCell)) return EdgeFault::kTooSmall;
  side.reach = std::min(kReach * cell, kLongestReach);
  side.steps = static_cast<int>(std::ceil(2 * side.reach / kStep));
  const double margin = (side.reach + 1) / length;  // profiles must not reach around the corners
  const int count = std::min(static_cast<int>((1 - 2 * margin) * length), kMostSamples);
  if (count < kFewestSamples) return EdgeFault::kTooSmall;
  for (int i = 0; i < count; ++i) {
    Sample sample;
    sample.along = 2.0 * i / (count - 1) - 1;
    const double share = margin + (1 - 2 * margin) * i / (count - 1);
    if (!project(camera, tag, a + share * (b - a), sample.pixel, sample.J)) return EdgeFault::kCutOff;
    side.samples.push_back(sample);
  }
  return EdgeFault::kNone;
}

EdgeFault read_profiles(const cv::Mat& bgr, const cv::Rect& window, Profiles& side) {
  for (const Sample& sample : side.samples) {
    for (int step = 0; step < side.steps; ++step) {
      const Eigen::Vector2d at = sample.pixel + side.offset(step) * side.normal;
      const bool inside =
          at.x() >= window.x && at.y() >= window.y && at.x() < window.br().x - 1 && at.y() < window.br().y - 1;
      if (!inside) return EdgeFault::kCutOff;
      side.values.push_back(luma(bgr, at));
    }
  }
  return EdgeFault::kNone;
}

EdgeFault displacement_of(const Profiles& p, double sigma_px, TagSide& side) {
  const double dark = level(p, -p.reach, -kPlateau * p.reach), bright = level(p, kPlateau * p.reach, p.reach);
  const double contrast = bright - dark;
  if (contrast < kLeastContrast) return EdgeFault::kLowContrast;
  const auto n = static_cast<double>(p.samples.size());
  std::vector<double> displacements;
  double mean = 0, slope = 0, along2 = 0;
  side.normal = p.normal;
  side.J = {TagRow::Zero(), TagRow::Zero()};
  for (size_t k = 0; k < p.samples.size(); ++k) {
    double bright_part = 0;
    for (int step = 0; step < p.steps; ++step) bright_part += (p.at(k, step) - dark) / contrast;
    const double displacement = p.reach - bright_part * (2 * p.reach / p.steps), along = p.samples[k].along;
    displacements.push_back(displacement);
    mean += displacement / n;
    slope += along * displacement;
    along2 += along * along;
    const TagRow row = p.normal.transpose() * p.samples[k].J;
    side.J[0] += row / n;
    side.J[1] += along * row;
  }
  slope /= along2;
  side.J[1] /= along2;
  double scatter2 = 0;
  for (size_t k = 0; k < p.samples.size(); ++k) {
    const double r = displacements[k] - mean - slope * p.samples[k].along;
    scatter2 += r * r / (n - 2);
  }
  side.displacement_px = {mean, slope};
  const double common = kCommonError * std::max(1.0, kWhole / p.reach);
  const double common2 = (common * common + sigma_px * sigma_px) / 2;
  side.variance_px2 = {kCorrelation * scatter2 / n + common2, kCorrelation * scatter2 / along2 + common2};
  if (scatter2 > kWidestScatter * kWidestScatter) return EdgeFault::kNotStraight;
  // Where the edge is not near the middle of the profiles, the next step will put it there.
  if (std::abs(mean) > 0.2 * p.reach) return EdgeFault::kNone;
  const double near = kTransition * p.reach;
  const double inside = level(p, mean - near - kStep, mean - near + kStep),
               outside = level(p, mean + near - kStep, mean + near + kStep);
  const double most = contrast * (p.reach < kWhole ? kLevelOfSmall : kLevel);
  if (inside - dark > most || bright - outside > most) return EdgeFault::kBlurred;
  return EdgeFault::kNone;
}

}  // namespace

bool project(const TagCamera& camera, const TagPlacement& tag, const Eigen::Vector2d& p_T, Eigen::Vector2d& pixel,
             Eigen::Matrix<double, 2, kTagUnknowns>& J) {
  const Eigen::Vector3d from_centre = tag.X_LT.linear() * Eigen::Vector3d(p_T.x(), p_T.y(), 0);
  const Eigen::Vector3d p = camera.X_CL * (tag.X_LT.translation() + tag.scale * from_centre);
  if (!(p.z() > 1e-6)) return false;
  const LensPoint at = image_of(camera.model, p.hnormalized());
  pixel = at.pixel;
  Eigen::Matrix<double, 2, 3> by_point;
  by_point << 1 / p.z(), 0, -p.x() / (p.z() * p.z()), 0, 1 / p.z(), -p.y() / (p.z() * p.z());
  by_point = (at.d_pixel_d_ray * by_point * camera.X_CL.linear()).eval();
  const Eigen::Vector3d r = tag.scale * from_centre;
  Eigen::Matrix3d turn;  // w x r = turn w
  turn << 0, r.z(), -r.y(), -r.z(), 0, r.x(), r.y(), -r.x(), 0;
  J << by_point, by_point * turn, by_point * from_centre;
  return pixel.allFinite();
}

TagEdges measure_edges(const TagCamera& camera, const TagPlacement& tag, double size_m, const cv::Mat& bgr,
                       const cv::Rect& window, double sigma_px) {
  TagEdges edges;
  for (int k = 0; k < 4; ++k) {
    Profiles profiles;
    edges.fault = sample_side(camera, tag, size_m, k, profiles);
    if (edges.fault == EdgeFault::kNone) edges.fault = read_profiles(bgr, window, profiles);
    if (edges.fault == EdgeFault::kNone)
      edges.fault = displacement_of(profiles, sigma_px, edges.sides[static_cast<size_t>(k)]);
    if (edges.fault != EdgeFault::kNone) break;
  }
  return edges;
}

}  // namespace multireach::vision
