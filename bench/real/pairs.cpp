// Stereo pairs: of still scenes with true disparities, and of objects at measured positions.
#include "bench/real/pairs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "bench/real/baseline.hpp"
#include "bench/real/clicks.hpp"
#include "numeric/random.hpp"
#include "tools/log/quantile.hpp"
#include "vision/stereo/triangulate.hpp"
#include "vision/stereo_tracker.hpp"

namespace multireach::bench {
namespace {

constexpr double kHalf = 0.15;  // m, half of a search region's sides: as well as one knows where a thing lies

/// Distance of a depth from the range of true depths, m, positive when it is beyond.
double outside_range(const StillObject& object, double depth_m) {
  return depth_m < object.least_m ? depth_m - object.least_m : depth_m > object.most_m ? depth_m - object.most_m : 0;
}

/// What vision answers to a still pair.
struct StillAnswer {
  std::string text;
  double error_mm = NAN, sigmas = NAN;  // of the depth, from the range of true depths
  bool elsewhere = false;               // in the image
};

/// With a search region, a click that is refused in the whole images is learned from the parts of them that show it.
StillAnswer answer_to(const RealSet& set, const StillObject& object, const StillObject::Click& click,
                      const std::optional<vision::SearchRegion>& region, bool all) {
  vision::TrackerOptions options;
  options.rig = set.rig;
  options.search_region = region;
  const Eigen::Isometry3d X_LW = set.rig.X_WL.inverse();
  const cv::Rect whole({0, 0}, set.left.size());
  const cv::Rect in_left_image = region ? vision::search_area(*region, set.rig.left, X_LW) : whole;
  const cv::Rect in_right_image = region ? vision::search_area(*region, set.rig.right, set.rig.X_RL * X_LW) : whole;
  Clicked left = learn_clicks({{set.left, {click.left_px}}}), right = learn_clicks({{set.right, {click.right_px()}}});
  if (region && !(left.fault.empty() && right.fault.empty())) {
    left = learn_clicks({{set.left, {click.left_px}, in_left_image}});
    right = learn_clicks({{set.right, {click.right_px()}, in_right_image}});
  }
  const std::string fault = left.fault.empty() ? right.fault : left.fault;
  if (!left.model || !right.model || !(fault.empty() || all)) return {.text = fault};
  options.colour = {*left.model, *right.model};
  vision::StereoTracker tracker(options);
  const vision::StereoMatch match = tracker.find(set.left, set.right).match;
  StillAnswer answer{.text = description(match.status)};
  if (!fault.empty()) answer.text += " (click refused: " + fault + ")";
  if (match.status != vision::StereoMatch::Status::kSeen) return answer;
  const double off = outside_range(object, match.point.depth_left_m);
  answer.error_mm = 1000 * off;
  answer.sigmas = off / std::sqrt(match.covariance()(2, 2));
  const cv::Point at(cvRound(match.left_px.x()), cvRound(match.left_px.y()));
  answer.elsewhere = !object.region.contains(at);
  if (answer.elsewhere) answer.text = "seen elsewhere";
  return answer;
}

/// A box of `half_m` to each side of the position that the two clicks triangulate to.
vision::SearchRegion region_at(const RealSet& set, const StillObject::Click& click, double half_m) {
  const double depth_m = set.rig.left.fx * set.rig.baseline_m() / (click.disparity_px + set.disparity_offset_px);
  const Eigen::Vector3d p_L =
      depth_m * set.rig.left.ray(Eigen::Vector2d(click.left_px.x, click.left_px.y)).homogeneous();
  const Eigen::Vector3d p_W = set.rig.X_WL * p_L;
  return {p_W.array() - half_m, p_W.array() + half_m};
}

void run_still(const RealSet& set, bool all) {
  for (const StillObject& object : set.still) {
    const Baseline left_baseline(set.left, object.click.left_px), right_baseline(set.right, object.click.right_px());
    const auto a = left_baseline.contours(set.left), b = right_baseline.contours(set.right);
    const double fx_baseline = set.rig.left.fx * set.rig.baseline_m();
    const double baseline_mm =
        !a.empty() && !b.empty()
            ? 1000 * outside_range(object, fx_baseline / (a[0].centre.x - b[0].centre.x + set.disparity_offset_px))
            : NAN;
    const StillAnswer anywhere = answer_to(set, object, object.click, std::nullopt, all);
    const StillAnswer within = answer_to(set, object, object.click, region_at(set, object.click, kHalf), all);
    std::printf("| %s | %s | %s | %s | %.3f to %.3f | %s | %.0f | %.1f | %s | %.0f | %.1f | %.0f |\n", set.name.c_str(),
                set.for_test ? "test" : "tuning", object.name.c_str(), object.whole ? "whole" : "a part",
                object.least_m, object.most_m, anywhere.text.c_str(), anywhere.error_mm, anywhere.sigmas,
                within.text.c_str(), within.error_mm, within.sigmas, baseline_mm);
  }
  std::fflush(stdout);
}

/// Clicks at random on an object, up to a fifth of its box from the given one along each axis. The seed is fixed: the
/// same clicks in every run.
std::vector<StillObject::Click> clicks_near(const RealSet& set, const StillObject& object, int count) {
  constexpr uint64_t kSeed = 5;
  const CounterRandom random(kSeed);
  const double most = std::min(object.region.width, object.region.height) / 5.0;
  std::vector<StillObject::Click> clicks;
  for (uint64_t draw = 0; std::ssize(clicks) < count && draw < 1000; ++draw) {
    const auto away = [&](uint64_t axis) { return cvRound(random.uniform(2 * draw + axis, -most, most)); };
    StillObject::Click click{.left_px = object.click.left_px + cv::Point(away(0), away(1))};
    if (!object.region.contains(click.left_px)) continue;
    click.disparity_px = set.true_disparity_px.at<double>(click.left_px);
    const bool same = std::abs(click.disparity_px - object.click.disparity_px) < StillObject::kSameObject_px;
    if (same && click.right_px().x >= 0) clicks.push_back(click);
  }
  return clicks;
}

/// Of several answers: how many locate something, how many of these are beyond 4 sigma, and the largest error in
/// sigmas.
std::string counts_of(const std::vector<StillAnswer>& answers) {
  constexpr double kBeyond = 4;
  int seen = 0, beyond = 0;
  double most = 0;
  for (const StillAnswer& answer : answers) {
    if (std::isnan(answer.sigmas)) continue;
    ++seen;
    beyond += std::abs(answer.sigmas) > kBeyond || answer.elsewhere;
    most = std::max(most, std::abs(answer.sigmas));
  }
  return fmt::format("{} | {} | {:.1f}", seen, beyond, most);
}

void run_random_clicks(const RealSet& set, int count, bool all) {
  for (const StillObject& object : set.still) {
    std::vector<StillAnswer> anywhere, within;
    const std::vector<StillObject::Click> clicks = clicks_near(set, object, count);
    for (const StillObject::Click& click : clicks) {
      anywhere.push_back(answer_to(set, object, click, std::nullopt, all));
      within.push_back(answer_to(set, object, click, region_at(set, click, kHalf), all));
    }
    std::printf("| %s | %s | %s | %zu | %s | %s |\n", set.name.c_str(), object.name.c_str(),
                object.whole ? "whole" : "a part", clicks.size(), counts_of(anywhere).c_str(),
                counts_of(within).c_str());
  }
  std::fflush(stdout);
}

/// Where a hand-made click in each image puts an object, in W; nothing where the rays do not meet.
std::optional<Eigen::Vector3d> clicked_position(const StereoRig& rig, const MeasuredObject& object) {
  const auto ray = [](const CameraModel& camera, const cv::Point2d& px) {
    return vision::RayMeasurement{camera.ray({px.x, px.y}), vision::ray_covariance(camera, 1)};
  };
  const auto point = vision::triangulate(rig, ray(rig.left, object.left_px), ray(rig.right, object.right_px));
  return point ? std::optional(point->p_W) : std::nullopt;
}

/// Distances from the measured positions, mm, as cells of a table: median, RMS, the largest.
std::string cells_of(const std::vector<double>& mm) {
  if (mm.empty()) return "| | |";
  double square = 0;
  for (const double each : mm) square += each * each;
  return fmt::format("{:.1f} | {:.1f} | {:.1f} |", quantile(mm, 0.5),
                     std::sqrt(square / static_cast<double>(mm.size())), std::ranges::max(mm));
}

std::string offset_text(const std::optional<Eigen::Vector3d>& p_W, const MeasuredObject& object) {
  if (!p_W) return "none";
  const Eigen::Vector3d mm = 1000 * (*p_W - object.p_W);
  return fmt::format("{:.0f} {:.0f} {:.0f} mm", mm.x(), mm.y(), mm.z());
}

/// Finds each object of a pair in a search region around its measured position, and adds a row to the table.
/// `radius_m`: 0 for not known. `lines`: for each object.
std::string row_of(const RealSet& set, const std::array<vision::ColourModel, 2>& colours, double radius_m,
                   std::string& lines) {
  std::vector<double> ours_mm, clicks_mm, sigmas_mm;
  for (size_t k = 0; k < set.measured.size(); ++k) {
    const MeasuredObject& object = set.measured[k];
    vision::TrackerOptions options;
    options.rig = set.rig;
    options.colour = colours;
    options.match.radius_m = radius_m;
    options.search_region = {object.p_W.array() - kHalf, object.p_W.array() + kHalf};
    const vision::StereoMatch match = vision::StereoTracker(options).find(set.left, set.right).match;
    std::optional<Eigen::Vector3d> seen;
    if (match.status == vision::StereoMatch::Status::kSeen) seen = match.point.p_W;
    const auto clicked = clicked_position(set.rig, object);
    if (seen) {
      ours_mm.push_back(1000 * (*seen - object.p_W).norm());
      sigmas_mm.push_back(1000 * std::sqrt(match.covariance().trace()));
    }
    if (clicked) clicks_mm.push_back(1000 * (*clicked - object.p_W).norm());
    lines += fmt::format("    radius {:g} mm, object {}: {}; off by (x y z) {}, sigma {}; by click {}\n",
                         1000 * radius_m, k, vision::description(match.status), offset_text(seen, object),
                         seen ? fmt::format("{:.0f} mm", sigmas_mm.back()) : "none", offset_text(clicked, object));
  }
  return fmt::format("| {} | {} | {} | {} of {} | {} {} | {}\n", set.name, set.for_test ? "test" : "tuning",
                     radius_m > 0 ? fmt::format("{:g} mm", 1000 * radius_m) : "not known", ours_mm.size(),
                     set.measured.size(), cells_of(ours_mm),
                     sigmas_mm.empty() ? "" : fmt::format("{:.1f}", quantile(sigmas_mm, 0.5)), cells_of(clicks_mm));
}

}  // namespace

void print_still(std::span<const RealSet> pairs, int random_clicks, bool refused) {
  std::printf(
      "\nSearch region: 0.15 m to each side of the position that the two clicks triangulate to.\n\n"
      "| pair | use | object | visible | true depths, m | answer | outside by, mm | in sigmas "
      "| with a search region: answer | outside by, mm | in sigmas | baseline outside by, mm |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const RealSet& set : pairs) run_still(set, refused);
  if (random_clicks == 0) return;
  std::printf(
      "\nClicks at random on each object. Beyond: outside the true depths by more than 4 sigma, or elsewhere in the "
      "image.\n\n"
      "| pair | object | visible | clicks | seen | beyond | largest, sigmas | with a search region: seen | beyond "
      "| largest, sigmas |\n|---|---|---|---|---|---|---|---|---|---|\n");
  for (const RealSet& set : pairs) run_random_clicks(set, random_clicks, refused);
}

void print_measured(std::span<const RealSet> pairs, bool refused, bool each) {
  std::printf(
      "\nDistance from the measured positions, mm. Vision looks for each object within 0.15 m of its position, along "
      "each axis. Clicks: triangulated by the same calibration, all objects.\n\n"
      "| pair | use | radius | seen | vision: median | RMS | max | its standard deviation, median "
      "| clicks: median | RMS | max |\n|---|---|---|---|---|---|---|---|---|---|---|\n");
  std::string lines;
  for (const RealSet& set : pairs) {
    std::vector<cv::Point> in_left, in_right;
    for (const MeasuredObject& object : set.measured) {
      in_left.emplace_back(object.left_px);
      in_right.emplace_back(object.right_px);
    }
    const Clicked left = learn_clicks({{set.learn_left, in_left}}), right = learn_clicks({{set.learn_right, in_right}});
    const std::string fault = left.fault.empty() ? right.fault : left.fault;
    if (!left.model || !right.model || !(fault.empty() || refused)) {
      std::printf("| %s | | | clicks refused: %s | | | | | | | |\n", set.name.c_str(), fault.c_str());
      continue;
    }
    std::vector<double> radii{0};
    if (set.radius_m > 0) radii.push_back(set.radius_m);
    for (const double radius : radii)
      std::printf("%s", row_of(set, {*left.model, *right.model}, radius, lines).c_str());
  }
  if (each) std::printf("\n%s", lines.c_str());
  std::fflush(stdout);
}

}  // namespace multireach::bench
