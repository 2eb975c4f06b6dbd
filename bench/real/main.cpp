// multireach-bench-real: learns colours from clicks on real images and tracks the objects, beside the usual OpenCV
// baseline on the same images.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <ranges>

#include "bench/real/baseline.hpp"
#include "bench/real/causes.hpp"
#include "bench/real/clicks.hpp"
#include "bench/real/limited_baseline.hpp"
#include "bench/real/pairs.hpp"
#include "bench/real/real_set.hpp"
#include "bench/real/score.hpp"
#include "bench/real/stereo_video.hpp"
#include "imaging/jpeg_decoder.hpp"
#include "runtime/files.hpp"
#include "runtime/image_file.hpp"
#include "tools/calibrate/object_colour.hpp"
#include "vision/stereo_vision.hpp"

namespace multireach::bench {
namespace {

using vision::TargetTrack;

/// What the command line chooses.
struct Choices {
  int clicks = 5;         // images of each object to learn from
  int random_clicks = 0;  // on each object of a still pair, besides the given one
  bool together = false;  // one colour from all clicks, instead of one from each
  bool refused = false;   // track also with colours that are refused
  bool causes = false, verbose = false;
};

/// One object, learned from one click or from several, through a whole video.
struct Run {
  size_t object = 0;
  std::vector<size_t> click_images;
  size_t clicks = 1, used = 1;  // learned from these; of several, those that are not left out
  std::string fault;            // why the colour was not learned, or is refused
  std::vector<std::string> warnings;
  std::unique_ptr<vision::StereoVision> ours;
  std::unique_ptr<Baseline> baseline;
  LimitedBaseline limited;
  Score ours_score, baseline_score;
  Causes causes;
};

vision::TrackerOptions options_of(const StereoRig& rig, const vision::ColourModel& left,
                                  const vision::ColourModel& right) {
  vision::TrackerOptions options;
  options.rig = rig;
  options.colour = {left, right};
  return options;
}

/// `all`: also tracks with a colour that is refused.
void learn(const RealSet& set, const std::vector<Click>& clicks, bool all, Run& run) {
  const Clicked learned = learn_clicks(clicks);
  for (const size_t k : learned.used) {
    for (const cv::Point& at : clicks[k].at) {
      const Baseline baseline(clicks[k].image, at);
      if (run.baseline) {
        run.baseline->widen(baseline);
      } else {
        run.baseline = std::make_unique<Baseline>(baseline);
      }
    }
  }
  run.fault = learned.fault;
  run.warnings = learned.warnings;
  run.clicks = clicks.size();
  run.used = learned.used.size();
  if (!learned.model || (!run.fault.empty() && !all)) return;
  run.ours = std::make_unique<vision::StereoVision>(
      std::vector(set.labelled[run.object].targets, options_of(set.rig, *learned.model, *learned.model)));
}

std::string names_of(const RealSet& set, const std::vector<size_t>& images) {
  std::string names;
  for (const size_t k : images) names.append(1, ' ').append(std::filesystem::path(set.images[k]).filename().string());
  return names;
}

/// The images to learn an object's colour from: those that the set names, or `clicks` spread evenly over its labels.
std::vector<size_t> click_images(const LabelledObject& object, int clicks) {
  if (!object.clicks.empty()) return object.clicks;
  std::vector<size_t> images;
  for (int click = 0; click < clicks; ++click) {
    const auto at = static_cast<ptrdiff_t>(object.centres.size()) * (2 * click + 1) / (2 * clicks);
    images.push_back(std::next(object.centres.begin(), at)->first);
  }
  return images;
}

/// The runs of a video: each object, learned from each of its clicks, or from all of them together.
std::vector<Run> runs_of(const RealSet& set, const Choices& choices) {
  std::vector<Run> runs;
  for (size_t k = 0; k < set.labelled.size(); ++k) {
    std::vector<Click> clicks;
    std::vector<size_t> numbers;
    for (const size_t number : click_images(set.labelled[k], choices.clicks)) {
      const cv::Mat image = read_image(set.images[number]);
      std::vector<cv::Point> points;
      for (const cv::Point2d& centre : set.labelled[k].centres.at(number)) {
        const cv::Point point(cvRound(centre.x), cvRound(centre.y));
        if (cv::Rect({0, 0}, image.size()).contains(point)) points.push_back(point);
        if (set.labelled[k].targets == 1) break;  // a click on one of them
      }
      if (points.empty()) continue;
      clicks.push_back({image, points});
      numbers.push_back(number);
    }
    const auto add = [&](const std::vector<Click>& some, const std::vector<size_t>& images) {
      Run& run = runs.emplace_back();
      run.object = k;
      run.click_images = images;
      learn(set, some, choices.refused, run);
    };
    if (choices.together && !clicks.empty()) add(clicks, numbers);
    for (size_t j = 0; j < clicks.size() && !choices.together; ++j) add({clicks[j]}, {numbers[j]});
  }
  return runs;
}

/// Distance from the nearest label if there is one, what the candidate was judged by, the evidence, and the reason.
void print_candidate(const vision::Candidate& candidate, const std::array<vision::View, 2>& views,
                     const std::vector<cv::Point2d>* labels) {
  std::printf("      candidate (%.1f, %.1f)", candidate.match.left_px.x(), candidate.match.left_px.y());
  if (labels) {
    double nearest = 1e9;
    for (const cv::Point2d& label : *labels)
      nearest =
          std::min(nearest, std::hypot(candidate.match.left_px.x() - label.x, candidate.match.left_px.y() - label.y));
    std::printf(" %.1f px from the label", nearest);
  }
  const vision::Appearance& in_left = views[0].appearance[static_cast<size_t>(candidate.match.left)];
  std::printf(": radius %.1f px, compact %.2f, colour %.2f, background %.2f, contour %d;", candidate.radius_px,
              in_left.compactness, in_left.colour_share, in_left.background, candidate.match.both_by_contour);
  for (size_t k = 0; k < vision::Evidence::kNames.size(); ++k)
    std::printf(" %s %.2f", vision::Evidence::kNames[k], candidate.evidence.term[k]);
  std::printf("; %s\n", candidate.reason);
}

void take(const RealSet& set, size_t k, const cv::Mat& image, const cv::Mat& second, bool chroma_subsampled, Run& run,
          bool verbose) {
  const LabelledObject& object = set.labelled[run.object];
  const auto found = object.centres.find(k);
  const std::vector<cv::Point2d>* labels = found == object.centres.end() ? nullptr : &found->second;
  std::vector<cv::Point2d> answers;
  if (run.ours) {
    const auto utime = static_cast<int64_t>(1e6 + 1e6 * static_cast<double>(k) / set.frames_per_s);
    vision::DecodedImages images({utime, utime, utime}, image, second, chroma_subsampled);
    run.ours->update(images);
    size_t ambiguous = 0;
    for (const vision::StereoVision::Target& target : run.ours->targets()) {
      const bool tracked = target.report.status == TargetTrack::Status::kTracked;
      if (tracked) answers.emplace_back(target.match.left_px.x(), target.match.left_px.y());
      const bool contradicted = tracked && labels && is_contradicted(target.report.estimate, set.rig, *labels);
      run.ours_score.contradicted += contradicted;
      if (tracked && labels) run.ours_score.by_contour += target.match.both_by_contour;
      ambiguous += target.report.ambiguous;
      if (!verbose) continue;
      std::printf("    %s image %zu (%s): %s (%.1f, %.1f)", object.name.c_str(), k,
                  std::filesystem::path(set.images[k]).filename().c_str(), tracked ? "tracked" : "-",
                  target.match.left_px.x(), target.match.left_px.y());
      if (labels)
        std::printf(" label (%.1f, %.1f)", (*labels)[0].x, (*labels)[0].y);
      else
        std::printf(" no label");
      std::printf("%s%s %s\n", contradicted ? " contradicted" : "", target.match.both_by_contour ? " contour" : "",
                  target.report.reason);
      for (const vision::Candidate& candidate : target.candidates) print_candidate(candidate, target.views, labels);
    }
    if (labels) {
      int missed = 0;
      for (const AnsweredLabel& each : answered_labels(*labels, answers, object.targets)) {
        if (each.error_px <= kRight) continue;
        run.causes.add(run.ours->targets(), each.label);
        ++missed;
      }
      run.ours_score.ambiguous += std::min(static_cast<int>(ambiguous), missed);
    }
  }
  const auto score = [&](const std::vector<cv::Point2d>& of, Score& sum) {
    if (labels)
      sum.add(of, *labels, object.targets);
    else
      sum.add_without_label(of);
  };
  score(answers, run.ours_score);
  const std::vector<Baseline::Contour> contours = run.baseline->contours(image);
  score(largest(contours, object.targets), run.baseline_score);
  if (labels) run.limited.add(contours, *labels, object.targets);
}

double percent(int part, int all) {
  return all > 0 ? 100.0 * part / all : 0;
}

void print_video(const RealSet& set, std::vector<Run>& runs, bool verbose) {
  for (size_t k = 0; k < set.labelled.size(); ++k) {
    Score ours, baseline, limited;
    double least = 100, most_wrong = 0, baseline_least = 100;
    size_t clicks = 0, refused = 0;
    for (const Run& run : runs) {
      if (run.object != k) continue;
      clicks += run.clicks;
      refused += run.ours && run.fault.empty() ? run.clicks - run.used : run.clicks;
      baseline.add(run.baseline_score);
      limited.add(run.limited.best(kFewWrong));
      baseline_least = std::min(baseline_least, percent(run.baseline_score.right, run.baseline_score.labelled));
      if (run.ours) {
        ours.add(run.ours_score);
        least = std::min(least, percent(run.ours_score.right, run.ours_score.labelled));
        most_wrong = std::max(most_wrong, percent(run.ours_score.wrong, run.ours_score.labelled));
      }
      if (!verbose) {
        if (!run.fault.empty())
          std::fprintf(stderr, "%s, %s, clicked in%s: refused: %s\n", set.name.c_str(), set.labelled[k].name.c_str(),
                       names_of(set, run.click_images).c_str(), run.fault.c_str());
        continue;
      }
      std::printf("  %s, clicked in%s: right %d, wrong %d of %d; baseline %d, %d; used %zu of %zu. %s\n",
                  set.labelled[k].name.c_str(), names_of(set, run.click_images).c_str(), run.ours_score.right,
                  run.ours_score.wrong, run.ours_score.labelled, run.baseline_score.right, run.baseline_score.wrong,
                  run.used, run.clicks, run.fault.c_str());
      for (const std::string& warning : run.warnings) std::printf("    warning: %s\n", warning.c_str());
    }
    const int taken = ours.labelled, all = baseline.labelled;
    if (taken == 0) least = 0;
    if (all == 0) baseline_least = 0;
    std::printf(
        "| %s | %s | %s | %zu of %zu | %.1f (%.1f) | %.1f (%.1f) | %.1f | %.1f | %.1f | %.2f | %.1f | %.1f (%.1f) | "
        "%.1f | %.1f | %.1f | %.1f |\n",
        set.name.c_str(), set.for_test ? "test" : "tuning", set.labelled[k].name.c_str(), refused, clicks,
        percent(ours.right, taken), least, percent(ours.wrong, taken), most_wrong, percent(ours.contradicted, taken),
        percent(ours.ambiguous, taken), percent(ours.by_contour, taken), ours.median_px(), percent(ours.right, all),
        percent(baseline.right, all), baseline_least, percent(baseline.wrong, all), percent(limited.right, all),
        percent(ours.answered_without, ours.without), percent(baseline.answered_without, baseline.without));
  }
  std::fflush(stdout);
}

void print_causes(const RealSet& set, const std::vector<Run>& runs) {
  for (size_t k = 0; k < set.labelled.size(); ++k) {
    Causes causes;
    int labelled = 0;
    for (const Run& run : runs) {
      if (run.object != k || !run.ours) continue;
      causes.add(run.causes);
      labelled += run.ours_score.labelled;
    }
    causes.print(set.name, set.labelled[k].name, labelled);
  }
}

/// Tracks a video's objects and prints its lines of the table. The runs are returned.
std::vector<Run> run_video(const RealSet& set, const Choices& choices) {
  std::vector<Run> runs = runs_of(set, choices);
  for (size_t k = 0; k < set.images.size(); ++k) {
    const cv::Mat image = read_image_of(set.rig.left, set.images[k]);
    const bool chroma_subsampled = jpeg_chroma_subsampled(read_binary_file(set.images[k]));
    for (Run& run : runs) take(set, k, image, second_image(image), chroma_subsampled, run, choices.verbose);
  }
  print_video(set, runs, choices.verbose);
  return runs;
}

int measure(const std::vector<std::string>& folders, const Choices& choices) {
  std::vector<RealSet> videos, stereo, still, measured;
  for (const std::string& folder : folders) {
    RealSet set = RealSet::load(folder);
    auto& of_kind = !set.stereo.empty()     ? stereo
                    : !set.images.empty()   ? videos
                    : !set.measured.empty() ? measured
                                            : still;
    of_kind.push_back(std::move(set));
  }
  if (!videos.empty()) {
    std::printf(
        "Per cent of labels. Right: TRACKED within %.0f px of the label. Wrong: beyond %.0f px of all labels. %s\n",
        kRight, kWrong,
        choices.together
            ? "All clicks of an object teach one colour, also the baseline's, but for those that calibrate colour "
              "refuses; brackets and 'of all' have no meaning of their own."
            : "The mean over an object's clicks that are not refused; in brackets the worst click. Of all: a "
              "refused click counts as no answer. The baseline answers to every click.");
    std::printf(
        "Contradicted: TRACKED beyond %.0f standard deviations from all labels, by the answer's covariance in the left "
        "image and %.0f px of the label.\n",
        kContradicted, kHandLabelSigma);
    std::printf(
        "Limited: the baseline, with the limits of a contour's area that give it the most right answers of those "
        "with at most %g %% wrong ones; they are chosen when the labels are known.\n\n",
        100 * kFewWrong);
    std::printf(
        "| video | use | object | clicks refused | right | wrong | contradicted | ambiguous | by contour | median px "
        "| right, of all | baseline: right | wrong | limited: right | answered without a label | baseline "
        "|\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  }
  std::vector<std::vector<Run>> runs;
  for (const RealSet& set : videos) runs.push_back(run_video(set, choices));
  if (choices.causes && !videos.empty()) {
    std::printf(
        "\nWhy labels have no right answer, per cent of labels:\n\n"
        "| video | object | cause | labels |\n|---|---|---|---|\n");
    for (size_t k = 0; k < videos.size(); ++k) print_causes(videos[k], runs[k]);
  }
  if (!stereo.empty()) print_stereo_videos(stereo, choices.clicks, choices.together, choices.refused, choices.verbose);
  if (!still.empty()) print_still(still, choices.random_clicks, choices.refused);
  if (!measured.empty()) print_measured(measured, choices.refused, choices.verbose);
  return 0;
}

}  // namespace
}  // namespace multireach::bench

int main(int argc, char** argv) {
  CLI::App app(
      "Tracks objects in folders of real images (docs/real-images.md) and prints tables, beside an OpenCV baseline.");
  std::vector<std::string> folders;
  multireach::bench::Choices choices;
  app.add_option("FOLDER", folders, "folders with a set.yaml")->required();
  app.add_option(
         "--clicks", choices.clicks,
         "images of each object that its colours are learned from; in videos of one camera, unless the set names them")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--random-clicks", choices.random_clicks,
                 "also so many clicks at random on each object of a pair with true disparities")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  app.add_flag("--together", choices.together, "one colour from all clicks of an object, also for the baseline");
  app.add_flag("--refused", choices.refused, "track also with colours that calibrate colour refuses");
  app.add_flag("--causes", choices.causes, "also print why labels have no right answer");
  app.add_flag("--verbose", choices.verbose, "a line for each run and image, or each measured object, as well");
  CLI11_PARSE(app, argc, argv);
  try {
    return multireach::bench::measure(folders, choices);
  } catch (const std::exception& fault) {
    std::fprintf(stderr, "multireach-bench-real: %s\n", fault.what());
    return 2;
  }
}
