// Videos of two cameras, with labels in both images.
#include "bench/real/stereo_video.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>

#include "bench/real/baseline.hpp"
#include "bench/real/clicks.hpp"
#include "bench/real/score.hpp"
#include "imaging/jpeg_decoder.hpp"
#include "runtime/files.hpp"
#include "runtime/image_file.hpp"
#include "tools/log/quantile.hpp"
#include "vision/stereo/triangulate.hpp"
#include "vision/stereo_vision.hpp"

namespace multireach::bench {
namespace {

constexpr double kLabelSigma = 0.5;  // px, standard deviation of a label's coordinates
constexpr double k95 = 7.815;        // 95 % of chi^2 with three degrees of freedom

/// An answer: pixels in both images, and the position with its covariance.
struct Answer {
  StereoPoint px;
  std::optional<Eigen::Vector3d> p_W;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// Answers of one method to the labels of a video.
struct StereoScore {
  int labelled = 0, right = 0, wrong = 0;
  std::vector<double> errors_mm, squared_sigmas;

  void add(const Answer& answer, const StereoPoint& label, const vision::Triangulation& truth, bool has_covariance) {
    const double px = std::max(cv::norm(answer.px.left - label.left), cv::norm(answer.px.right - label.right));
    right += px <= kRight;
    wrong += px > kWrong;
    if (!answer.p_W) return;
    const Eigen::Vector3d error = *answer.p_W - truth.p_W;
    errors_mm.push_back(1000 * error.norm());
    if (!has_covariance) return;
    squared_sigmas.push_back(error.dot((answer.covariance + truth.covariance).ldlt().solve(error)));
  }
  void add(const StereoScore& other) {
    labelled += other.labelled;
    right += other.right;
    wrong += other.wrong;
    errors_mm.insert(errors_mm.end(), other.errors_mm.begin(), other.errors_mm.end());
    squared_sigmas.insert(squared_sigmas.end(), other.squared_sigmas.begin(), other.squared_sigmas.end());
  }
};

/// Median and RMS, as cells of a table.
std::string cells_of(const std::vector<double>& mm) {
  if (mm.empty()) return " | ";
  double square = 0;
  for (const double each : mm) square += each * each;
  return fmt::format("{:.1f} | {:.1f}", quantile(mm, 0.5), std::sqrt(square / static_cast<double>(mm.size())));
}

/// NEES/3, the share inside the 95 % ellipsoid and the largest error, as cells of a table.
std::string covariance_cells(const std::vector<double>& squared_sigmas) {
  if (squared_sigmas.empty()) return " | | ";
  double sum = 0;
  for (const double each : squared_sigmas) sum += each;
  const auto count = static_cast<double>(squared_sigmas.size());
  const auto inside = static_cast<double>(std::ranges::count_if(squared_sigmas, [](double s) { return s < k95; }));
  return fmt::format("{:.2f} | {:.1f} % | {:.1f}", sum / count / 3, 100 * inside / count,
                     std::sqrt(std::ranges::max(squared_sigmas)));
}

std::optional<vision::Triangulation> position_of(const StereoRig& rig, const StereoPoint& px) {
  const auto ray = [](const CameraModel& camera, const cv::Point2d& at) {
    return vision::RayMeasurement{camera.ray({at.x, at.y}), vision::ray_covariance(camera, kLabelSigma)};
  };
  auto point = vision::triangulate(rig, ray(rig.left, px.left), ray(rig.right, px.right));
  // If the rays miss each other by more (a moving object, unsynchronised cameras), the covariance grows accordingly.
  if (point) point->covariance *= std::max(1.0, point->chi2 / point->degrees_of_freedom);
  return point;
}

/// One object, learned from some clicks, through a whole video.
struct Run {
  const StereoObject* object = nullptr;
  size_t clicks = 0, used = 0;  // of several clicks, those that are not left out of one of the images
  std::string fault;
  std::unique_ptr<vision::StereoVision> ours;
  std::array<std::unique_ptr<Baseline>, 2> baseline;
  StereoScore ours_score, baseline_score;
};

Run run_of(const RealSet& set, const StereoObject& object, const std::vector<size_t>& images, bool refused) {
  Run run;
  run.object = &object;
  std::array<std::vector<Click>, 2> clicks;
  for (const size_t k : images) {
    const StereoPoint& at = object.clicks.at(k);
    const std::array<cv::Mat, 2> pair{read_image(set.images[k]), read_image(set.right_images[k])};
    const std::array<cv::Point, 2> points{at.left, at.right};
    for (size_t side = 0; side < 2; ++side) clicks[side].push_back({pair[side], {points[side]}});
  }
  const std::array<Clicked, 2> learned{learn_clicks(clicks[0]), learn_clicks(clicks[1])};
  for (size_t side = 0; side < 2; ++side) {
    for (const size_t k : learned[side].used) {
      const Baseline one(clicks[side][k].image, clicks[side][k].at.front());
      if (run.baseline[side])
        run.baseline[side]->widen(one);
      else
        run.baseline[side] = std::make_unique<Baseline>(one);
    }
  }
  const auto& [left, right] = learned;
  run.clicks = images.size();
  run.used = std::min(left.used.size(), right.used.size());
  run.fault = left.fault.empty() ? right.fault : left.fault;
  if (!left.model || !right.model || !(run.fault.empty() || refused)) return run;
  vision::TrackerOptions options;
  options.rig = set.rig;
  options.colour = {*left.model, *right.model};
  run.ours = std::make_unique<vision::StereoVision>(std::vector{options});
  return run;
}

void take(const RealSet& set, size_t k, const std::array<cv::Mat, 2>& pair, bool chroma_subsampled, Run& run,
          bool each) {
  const auto found = run.object->centres.find(k);
  const bool labelled = found != run.object->centres.end();
  const auto truth = labelled ? position_of(set.rig, found->second) : std::nullopt;
  run.ours_score.labelled += truth.has_value();
  run.baseline_score.labelled += truth.has_value();
  if (run.ours) {
    const auto utime = static_cast<int64_t>(1e6 + 1e6 * static_cast<double>(k) / set.frames_per_s);
    vision::DecodedImages images({utime, utime, utime}, pair[0], pair[1], chroma_subsampled);
    run.ours->update(images);
    const vision::StereoVision::Target& target = run.ours->targets()[0];
    const bool tracked = target.report.status == vision::TargetTrack::Status::kTracked;
    if (truth && tracked) {
      const auto& match = target.match;
      const Answer answer{{{match.left_px.x(), match.left_px.y()}, {match.right_px.x(), match.right_px.y()}},
                          target.report.estimate.position,
                          target.report.estimate.covariance};
      run.ours_score.add(answer, found->second, *truth, true);
    }
    if (each) {
      std::printf("    %s image %zu: %s", run.object->name.c_str(), k, target.report.reason);
      if (truth && tracked) {
        std::printf("; %.1f mm off, %.1f sigma", run.ours_score.errors_mm.back(),
                    std::sqrt(run.ours_score.squared_sigmas.back()));
      }
      std::printf("\n");
    }
  }
  const auto in_left = run.baseline[0]->contours(pair[0]), in_right = run.baseline[1]->contours(pair[1]);
  if (!truth || in_left.empty() || in_right.empty()) return;
  const StereoPoint px{in_left[0].centre, in_right[0].centre};
  const auto point = position_of(set.rig, px);
  run.baseline_score.add({px, point ? std::optional(point->p_W) : std::nullopt}, found->second, *truth, false);
}

void run_video(const RealSet& set, int clicks, bool together, bool refused, bool each) {
  std::vector<Run> runs;
  for (const StereoObject& object : set.stereo) {
    std::vector<size_t> all;
    for (const auto& [image, at] : object.clicks) all.push_back(image);
    std::vector<size_t> chosen;
    const size_t count = std::min(static_cast<size_t>(clicks), all.size());
    for (size_t click = 0; click < count; ++click) chosen.push_back(all[all.size() * (2 * click + 1) / (2 * count)]);
    if (together) runs.push_back(run_of(set, object, chosen, refused));
    for (size_t k = 0; k < chosen.size() && !together; ++k) runs.push_back(run_of(set, object, {chosen[k]}, refused));
  }
  for (size_t k = 0; k < set.images.size(); ++k) {
    const std::array<cv::Mat, 2> pair{read_image(set.images[k]), read_image(set.right_images[k])};
    const bool chroma_subsampled = jpeg_chroma_subsampled(read_binary_file(set.images[k]));
    for (Run& run : runs) take(set, k, pair, chroma_subsampled, run, each);
  }
  for (const StereoObject& object : set.stereo) {
    StereoScore ours, baseline;
    size_t taken = 0, all = 0;
    for (const Run& run : runs) {
      if (run.object != &object) continue;
      all += run.clicks;
      if (each && !run.fault.empty()) std::printf("  %s: %s\n", object.name.c_str(), run.fault.c_str());
      baseline.add(run.baseline_score);
      if (!run.ours) continue;
      taken += run.used;
      ours.add(run.ours_score);
    }
    const auto percent = [](int part, int whole) { return whole > 0 ? 100.0 * part / whole : 0; };
    std::printf("| %s | %s | %s | %zu of %zu | %.1f | %.1f | %s | %s | %.1f | %.1f | %s |\n", set.name.c_str(),
                set.for_test ? "test" : "tuning", object.name.c_str(), taken, all, percent(ours.right, ours.labelled),
                percent(ours.wrong, ours.labelled), cells_of(ours.errors_mm).c_str(),
                covariance_cells(ours.squared_sigmas).c_str(), percent(baseline.right, baseline.labelled),
                percent(baseline.wrong, baseline.labelled), cells_of(baseline.errors_mm).c_str());
  }
  std::fflush(stdout);
}

}  // namespace

void print_stereo_videos(std::span<const RealSet> videos, int clicks, bool together, bool refused, bool each) {
  std::printf(
      "\nPer cent of labels. Right: TRACKED, in both images within %.0f px of the label. Wrong: in one beyond %.0f px. "
      "Distances from the labels' triangulation. The baseline's largest contours are triangulated.\n\n"
      "| video | use | object | clicks taken | right | wrong | error: median, mm | RMS | NEES/3 | inside the 95 %% "
      "ellipsoid | "
      "largest error, sigmas | baseline: right | wrong | error: median, mm | RMS |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
      kRight, kWrong);
  for (const RealSet& set : videos) run_video(set, clicks, together, refused, each);
}

}  // namespace multireach::bench
