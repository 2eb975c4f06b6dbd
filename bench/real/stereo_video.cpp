// Videos of two cameras, with labels in both images.
#include "bench/real/stereo_video.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>

#include "bench/real/baseline.hpp"
#include "bench/real/clicks.hpp"
#include "bench/real/score.hpp"
#include "bench/real/stereo_score.hpp"
#include "imaging/jpeg_decoder.hpp"
#include "runtime/files.hpp"
#include "runtime/image_file.hpp"
#include "vision/stereo_vision.hpp"

namespace multireach::bench {
namespace {

/// One object, learned from some clicks, through a whole video.
struct Run {
  const StereoObject* object = nullptr;
  double radius_m = 0;          // that vision is told; 0: none
  size_t clicks = 0, used = 0;  // of several clicks, those that are not left out of one of the images
  std::string fault;
  std::unique_ptr<vision::StereoVision> ours;
  std::array<std::unique_ptr<Baseline>, 2> baseline;
  StereoScore ours_score, baseline_score;
};

std::array<cv::Mat, 2> read_pair(const RealSet& set, size_t k) {
  return {read_image_of(set.rig.left, set.images[k]), read_image_of(set.rig.right, set.right_images[k])};
}

Run run_of(const RealSet& set, const StereoObject& object, const std::vector<size_t>& images, double radius_m,
           bool refused) {
  Run run;
  run.object = &object;
  run.radius_m = radius_m;
  std::array<std::vector<Click>, 2> clicks;
  for (const size_t k : images) {
    const StereoPoint& at = object.clicks.at(k);
    const std::array<cv::Mat, 2> pair = read_pair(set, k);
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
  const Clicked &left = learned[0], &right = learned[1];
  run.clicks = images.size();
  run.used = static_cast<size_t>(
      std::ranges::count_if(left.used, [&](size_t k) { return std::ranges::find(right.used, k) != right.used.end(); }));
  run.fault = left.fault.empty() ? right.fault : left.fault;
  if (!left.model || !right.model || !(run.fault.empty() || refused)) return run;
  vision::TrackerOptions options;
  options.rig = set.rig;
  options.colour = {*left.model, *right.model};
  options.match.radius_m = radius_m;
  run.ours = std::make_unique<vision::StereoVision>(std::vector{options});
  return run;
}

void take(const RealSet& set, size_t k, const std::array<cv::Mat, 2>& pair, bool chroma_subsampled, Run& run,
          bool each) {
  const auto found = run.object->centres.find(k);
  const bool labelled = found != run.object->centres.end();
  const auto truth = labelled ? position_of_labels(set.rig, found->second) : std::nullopt;
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
      const StereoAnswer answer{{{match.left_px.x(), match.left_px.y()}, {match.right_px.x(), match.right_px.y()}},
                                target.report.estimate.position,
                                target.report.estimate.covariance};
      run.ours_score.add(answer, found->second, *truth);
    }
    if (each) {
      std::printf("    %s image %zu: %s", run.object->name.c_str(), k, target.report.reason);
      if (truth && tracked) {
        const auto& match = target.match;
        std::printf(
            "; (%.0f, %.0f) and (%.0f, %.0f), labels (%.0f, %.0f) and (%.0f, %.0f), %s; %.1f mm off, %.1f sigma",
            match.left_px.x(), match.left_px.y(), match.right_px.x(), match.right_px.y(), found->second.left.x,
            found->second.left.y, found->second.right.x, found->second.right.y,
            match.both_by_contour ? "by contour" : "by centroid", run.ours_score.errors_mm.back(),
            std::sqrt(run.ours_score.squared_sigmas.back()));
      }
      std::printf("\n");
    }
  }
  const auto in_left = run.baseline[0]->contours(pair[0]), in_right = run.baseline[1]->contours(pair[1]);
  if (!truth || in_left.empty() || in_right.empty()) return;
  const StereoPoint px{in_left[0].centre, in_right[0].centre};
  const auto point = position_of_labels(set.rig, px);
  run.baseline_score.add({px, point ? std::optional(point->p_W) : std::nullopt, std::nullopt}, found->second, *truth);
}

void print_row(const RealSet& set, const StereoObject& object, double radius_m, const std::vector<Run>& runs,
               bool each) {
  StereoScore ours, baseline;
  size_t taken = 0, all = 0;
  for (const Run& run : runs) {
    if (run.object != &object || run.radius_m != radius_m) continue;
    all += run.clicks;
    if (each && !run.fault.empty()) std::printf("  %s: %s\n", object.name.c_str(), run.fault.c_str());
    baseline.add(run.baseline_score);
    if (!run.ours) continue;
    taken += run.used;
    ours.add(run.ours_score);
  }
  std::printf("| %s | %s | %s | %s | %zu of %zu | %.1f | %.1f | %s | %s | %.1f | %.1f | %s |\n", set.name.c_str(),
              set.for_test ? "test" : "tuning", object.name.c_str(),
              radius_m > 0 ? fmt::format("{:g} mm", 1000 * radius_m).c_str() : "not known", taken, all,
              ours.right_percent(), ours.wrong_percent(), ours.error_cells().c_str(), ours.covariance_cells().c_str(),
              baseline.right_percent(), baseline.wrong_percent(), baseline.error_cells().c_str());
}

void run_video(const RealSet& set, int clicks, bool together, bool refused, bool each) {
  std::vector<Run> runs;
  std::vector<double> radii{0};
  if (set.radius_m > 0) radii.push_back(set.radius_m);
  for (const StereoObject& object : set.stereo) {
    std::vector<size_t> all;
    for (const auto& [image, at] : object.clicks) all.push_back(image);
    std::vector<size_t> chosen;
    const size_t count = std::min(static_cast<size_t>(clicks), all.size());
    for (size_t click = 0; click < count; ++click) chosen.push_back(all[all.size() * (2 * click + 1) / (2 * count)]);
    for (const double radius_m : radii) {
      if (together) runs.push_back(run_of(set, object, chosen, radius_m, refused));
      for (size_t k = 0; k < chosen.size() && !together; ++k)
        runs.push_back(run_of(set, object, {chosen[k]}, radius_m, refused));
    }
  }
  for (size_t k = 0; k < set.images.size(); ++k) {
    const std::array<cv::Mat, 2> pair = read_pair(set, k);
    const bool chroma_subsampled = jpeg_chroma_subsampled(read_binary_file(set.images[k]));
    for (Run& run : runs) take(set, k, pair, chroma_subsampled, run, each);
  }
  for (const StereoObject& object : set.stereo) {
    for (const double radius_m : radii) print_row(set, object, radius_m, runs, each);
  }
  std::fflush(stdout);
}

}  // namespace

void print_stereo_videos(std::span<const RealSet> videos, int clicks, bool together, bool refused, bool each) {
  std::printf(
      "\nPer cent of labels. Right: TRACKED, in both images within %.0f px of the label. Wrong: in one beyond %.0f px. "
      "Distances from the labels' triangulation. The baseline's largest contours are triangulated.\n\n"
      "| video | use | object | radius | clicks taken | right | wrong | error: median, mm | RMS | NEES/3 | inside the "
      "95 %% "
      "ellipsoid | "
      "largest error, sigmas | baseline: right | wrong | error: median, mm | RMS |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
      kRight, kWrong);
  for (const RealSet& set : videos) run_video(set, clicks, together, refused, each);
}

}  // namespace multireach::bench
