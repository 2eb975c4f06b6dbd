#include "vision/colour/learn_colour.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "vision/colour/chroma_classifier.hpp"
#include "vision/colour/colour_table.hpp"
#include "vision/colour/find.hpp"
#include "vision/colour/training_samples.hpp"

namespace multireach::vision {
namespace {

constexpr double kSwamped = 0.05;   // misclassified background share above which brightness limits are tried
constexpr double kWideness = 0.03;  // share of the object that a tolerance wider by one sigma must add
constexpr double kClean = 0.002;    // misclassified share of the background that is acceptable
constexpr double kTolerances[] = {4.0, 3.5, 3.0, 2.5, 2.0, 1.5};  // standard deviations
constexpr double kWorthwhile = 0.05;  // by how much a limit of brightness must improve the score

double share_of_members(const ColourModel& model, const std::vector<ChromaSample>& samples) {
  const ChromaClassifier test(model, {});
  double members = 0;
  for (const ChromaSample& sample : samples) members += test.contains(sample.colour) ? sample.weight : 0;
  return samples.empty() ? 0 : members / total_weight(samples);
}

struct Grade {
  double kept, background;
  double clutter = 0;  // area of the largest other thing that is found, relative to the object's; the worst picture's
  /// 1 % of the background misclassified costs as much as 10 % of the object missed.
  double score() const { return kept - 10 * background - clutter / (1 + clutter); }
};

/// Pixels of a blob that are not in `mask`; all where it is empty.
double area_outside(const Blob& blob, const cv::Mat& mask) {
  if (mask.empty()) return blob.area;
  double area = 0;
  for (const Run& run : blob.runs) {
    const auto* row = mask.ptr<uint8_t>(run.row);
    area += static_cast<double>(std::count(row + run.begin, row + run.end, uint8_t{0}));
  }
  return area;
}

/// The largest thing that the finder finds beside the object and others of its colour, relative to the object's area.
double clutter_of(const ColourTable& members, const Trial& trial) {
  BlobFinder finder;
  const FoundBlobs found = finder.find(trial.bgr, {0, 0, trial.bgr.cols, trial.bgr.rows}, members, {.most = 64});
  if (found.too_many_runs) return 1e3;
  double area = 0;
  for (const Blob& blob : found.blobs) {
    // A blob that contains the object may contain much else.
    area = std::max(area, area_outside(blob, trial.alike) - 1.5 * trial.area_at(blob.box));
  }
  return area / trial.area;
}

/// That of the worst picture.
double clutter_of(const ColourModel& model, const std::vector<Trial>& trials) {
  if (trials.empty()) return 0;
  const ColourTable members(model);
  double most = 0;
  for (const Trial& trial : trials) most = std::max(most, clutter_of(members, trial));
  return most;
}

Grade grade(const ColourModel& model, const TrainingSamples& training) {
  return {share_of_members(model, training.object), share_of_members(model, training.rest),
          clutter_of(model, training.trials)};
}

/// Cuts the background pixels that are classified as the object out of the model, by components for them, if that
/// improves the score. Returns the grade.
Grade cut_background(ColourModel& model, const TrainingSamples& training) {
  model.background.clear();
  Grade best = grade(model, training);
  if (best.background <= kClean && best.clutter == 0) return best;
  const ChromaClassifier test(model, {});
  std::vector<ChromaSample> confused;
  for (const ChromaSample& sample : training.rest) {
    if (!is_dark(sample) && !is_clipped(sample) && test.contains(sample.colour)) confused.push_back(sample);
  }
  if (confused.empty()) return best;
  const std::vector<ChromaComponent> components = fit_chroma(confused, 3);
  const double share = total_weight(confused) / total_weight(training.rest);
  // The shares of the object and of its background differ from picture to picture, so the score chooses.
  ColourModel chosen = model;
  for (const double factor : {1.0, 10.0, 100.0}) {
    if (factor > 1 && training.trials.empty()) break;  // the object's share is not known
    ColourModel with = model;
    with.background = components;
    for (ChromaComponent& component : with.background) component.weight *= share * factor;
    const Grade now = grade(with, training);
    if (now.score() <= best.score()) continue;
    best = now;
    chosen = with;
  }
  model = chosen;
  return best;
}

/// Sets the tolerance with the best score, with the background cut out or not. Objects that no picture shows
/// may have similar colours, so what a tolerance beyond the usual one adds must be worth it.
void choose_tolerance(ColourModel& model, const TrainingSamples& training, bool cut) {
  constexpr double kUsual = 3;
  double best_score = -1e9;
  ColourModel best = model;
  for (const double tolerance : kTolerances) {
    ColourModel with = model;
    with.tolerance = tolerance;
    const Grade now = cut ? cut_background(with, training) : grade(with, training);
    // What a rectangle shows besides the object hides how much a tolerance gains: the widest that is clean.
    const bool rectangle = training.trials.empty();
    if (rectangle && now.background <= kClean) {
      model = with;
      return;
    }
    const double score = now.score() - (rectangle ? 0 : kWideness * std::max(0.0, tolerance - kUsual));
    if (score <= best_score) continue;
    best_score = score;
    best = with;
  }
  model = best;
}

/// Sets a limit of brightness that separates the object from background pixels of its chroma. Returns false, and
/// changes nothing, when that does not improve the score.
bool separate_by_brightness(ColourModel& model, const TrainingSamples& training) {
  std::array<double, 257> object{}, rest{};  // cumulative histograms: share of pixels darker than the index
  const ChromaClassifier test(model, {});
  const auto accumulate = [](std::array<double, 257>& shares, const std::vector<ChromaSample>& samples, auto counts) {
    double total = 0;
    for (const ChromaSample& sample : samples) {
      if (!counts(sample)) continue;
      shares[static_cast<size_t>(sample.luma) + 1] += sample.weight;
      total += sample.weight;
    }
    for (size_t i = 1; i < shares.size(); ++i) shares[i] = shares[i] / std::max(total, 1e-9) + shares[i - 1];
  };
  accumulate(object, training.object, [](const ChromaSample&) { return true; });
  accumulate(rest, training.rest, [&](const ChromaSample& sample) { return test.contains(sample.colour); });
  // Shares on the wrong side of a limit, for an object that is darker, or brighter, than the rest.
  const auto wrong = [&](size_t limit, bool darker) {
    return darker ? 1 - object[limit] + rest[limit] : object[limit] + 1 - rest[limit];
  };
  ColourModel best = model;
  for (const bool darker : {true, false}) {
    double least = 2;
    for (size_t limit = 1; limit < 256; ++limit) least = std::min(least, wrong(limit, darker));
    size_t first = 256, last = 0;  // range of limits within 0.01 of the best
    for (size_t limit = 1; limit < 256; ++limit) {
      if (wrong(limit, darker) > least + 0.01) continue;
      first = std::min(first, limit);
      last = std::max(last, limit);
    }
    ColourModel with = model;
    // Light scales brightness, so use the geometric mean of the range.
    const double limit = std::sqrt(static_cast<double>(first) * static_cast<double>(last));
    if (darker) {
      with.min_luma = model.min_luma > ColourModel{}.min_luma ? model.min_luma : 0;
      with.max_luma = std::max(limit, with.min_luma + 1);
    } else {
      with.min_luma = std::clamp(limit, model.min_luma, with.max_luma - 1);
    }
    if (grade(with, training).score() > grade(best, training).score()) best = with;
  }
  const bool better = grade(best, training).score() > grade(model, training).score() + 0.01;
  if (better) model = best;
  return better;
}

/// How bright the object's samples are.
class LumaQuantiles {
 public:
  explicit LumaQuantiles(std::vector<ChromaSample> object) : object_(std::move(object)), total_(total_weight(object_)) {
    std::ranges::sort(object_, {}, &ChromaSample::luma);
  }
  /// The limits of all but a tail at each end.
  double min_luma() const { return quantile(kTail); }
  double max_luma() const { return quantile(object_.rbegin(), object_.rend(), kTail); }
  /// The brightness below which this share of them is.
  double quantile(double share) const { return quantile(object_.begin(), object_.end(), share); }
  /// Limits to try, in this order: with less and less room for darker exposures, and then with less of the object.
  std::vector<double> candidates() const {
    std::vector<double> limits;
    for (const double room : {3.0, 2.0, 1.5, 1.2}) limits.push_back(min_luma() / room);
    for (const double share : {0.05, 0.1, 0.15}) limits.push_back(quantile(share));
    return limits;
  }
  /// Share of the samples that are at least as bright.
  double share_from(double luma) const {
    double weight = 0;
    for (const ChromaSample& sample : object_) weight += sample.luma >= luma ? sample.weight : 0;
    return weight / total_;
  }

 private:
  static constexpr double kTail = 0.02;
  template <class Iterator>
  double quantile(Iterator first, Iterator last, double share) const {
    double weight = first->weight;
    while (weight <= share * total_ && std::next(first) != last) weight += (++first)->weight;
    return first->luma;
  }

  std::vector<ChromaSample> object_;  // by brightness
  double total_;
};

/// Where the finder finds other things of the object's chroma in the image, limits the brightness to that of the
/// object, with some room for other exposures: as much as the other things allow. If need be also to a part of it:
/// chroma says least about the darkest pixels, such as the coloured fringes that lenses leave at edges of black things.
void limit_brightness(ColourModel& model, const TrainingSamples& training) {
  Grade best = grade(model, training);
  const LumaQuantiles luma(training.object);
  const ColourModel before = model;
  const auto limit = [&](double darkest, double brightest) {
    if (best.clutter == 0) return;
    ColourModel with = before;
    with.min_luma = std::max(with.min_luma, darkest);
    with.max_luma = std::min(with.max_luma, brightest);
    const Grade now = grade(with, training);
    if (now.score() < best.score() + kWorthwhile) return;
    best = now;
    model = with;
  };
  for (const double room : {3.0, 2.0, 1.5, 1.2}) limit(luma.min_luma() / room, luma.max_luma() * room);
  for (const double share : {0.05, 0.1, 0.15}) limit(luma.quantile(share), model.max_luma);
}

/// Chooses tolerance, limits of brightness within those of the model, and background for given components of the
/// object. Returns whether only brightness separates the object.
bool tune_within_limits(ColourModel& model, const TrainingSamples& training) {
  ColourModel cut = model;
  choose_tolerance(model, training, false);
  const Grade by_chroma = grade(model, training);
  bool by_brightness = false;
  if (by_chroma.background > kSwamped) {
    ColourModel limited = model;
    limited.tolerance = 4;
    by_brightness = separate_by_brightness(limited, training);
    if (by_brightness) {
      model = limited;
      choose_tolerance(model, training, false);
    }
  }
  if (training.trials.empty()) {
    cut_background(model, training);
    return by_brightness;
  }
  // Cut by the colours around the object, its chroma may distinguish it after all.
  choose_tolerance(cut, training, true);
  if (!by_brightness || grade(cut, training).score() > grade(model, training).score()) {
    model = cut;
    by_brightness = false;
  }
  if (!by_brightness) limit_brightness(model, training);
  return by_brightness;
}

/// The same, and sets `min_luma` where darker things of nearly the object's chroma, such as a brown door behind an
/// orange ball, would cost more of the object otherwise.
bool tune(ColourModel& model, const TrainingSamples& training) {
  const ColourModel before = model;
  bool by_brightness = tune_within_limits(model, training);
  if (training.trials.empty()) return by_brightness;
  const LumaQuantiles luma(training.object);
  double best = grade(model, training).score();
  for (const double limit : luma.candidates()) {
    // The score is at most the share of the object that is left.
    if (limit <= before.min_luma || limit >= before.max_luma || luma.share_from(limit) < best + kWorthwhile) continue;
    ColourModel with = before;
    with.min_luma = limit;
    const bool only_brightness = tune_within_limits(with, training);
    const double now = grade(with, training).score();
    if (now < best + kWorthwhile) continue;
    best = now;
    model = with;
    by_brightness = only_brightness;
  }
  return by_brightness;
}

}  // namespace

const char* description(LearnedColour::Status status) {
  switch (status) {
    case LearnedColour::Status::kLearned:
      return "learned";
    case LearnedColour::Status::kBadImage:
      return "the image is not an 8-bit colour image";
    case LearnedColour::Status::kNoObject:
      return "no picture has the object";
    case LearnedColour::Status::kTooSmall:
      return "the object's region is outside of the picture, or too small: at least 40 of its pixels must be in it; "
             "a click on a highlight or a mark finds no more than that: click beside it";
    case LearnedColour::Status::kOverexposed:
      return "the object is overexposed, so that its colour is not known: make the exposure shorter";
    case LearnedColour::Status::kIndistinct:
      return "what is in the rectangle is as frequent in the rest of the picture";
  }
  return "";
}

namespace {

using Status = LearnedColour::Status;

LearnedColour failed(Status status) {
  LearnedColour result;
  result.status = status;
  return result;
}

LearnedColour graded(const ColourModel& model, const Grade& grade, bool by_brightness) {
  LearnedColour result;
  result.status = Status::kLearned;
  result.model = model;
  result.kept = grade.kept;
  result.background = grade.background;
  result.by_brightness = by_brightness;
  return result;
}

/// Widens the model along saturation: in other light, through haze or with more reflected white, an object keeps its
/// hue, but a few pictures show it at few saturations. Takes the wider of two models that keeps no less of the object,
/// and lets no more of the background pass, or no more than kClean. At a tolerance of three standard deviations the
/// wider one allows three tenths of the saturation more or less. Half of it, as limits in HSV often allow, would let a
/// change of the light pass as a change of the white balance.
void widen_saturation(LearnedColour& learned, const TrainingSamples& training) {
  const Grade before = grade(learned.model, training);
  for (const double share : {0.1, 0.05}) {
    ColourModel with = learned.model;
    for (ChromaComponent& component : with.object) {
      const Eigen::Vector2d along = share * component.mean;
      component.covariance += along * along.transpose();
    }
    const Grade now = grade(with, training);
    if (now.background > std::max(before.background, kClean) || now.clutter > before.clutter || now.kept < before.kept)
      continue;
    learned = graded(with, now, learned.by_brightness);
    return;
  }
}

/// Keeps the model away from large parts of the background: a small change of the light would make them pass. If a
/// tolerance kMargin times as wide lets something pass that is kLarge times as large as the object, takes the
/// largest smaller tolerance at which nothing that large passes, if there is one. On the tuning videos of
/// docs/real-images.md nothing else that passes then is larger than the object.
void keep_away_from_background(LearnedColour& learned, const TrainingSamples& training) {
  constexpr double kMargin = 1.2, kLarge = 10;
  const auto is_near = [&](ColourModel model) {
    model.tolerance *= kMargin;
    return clutter_of(model, training.trials) > kLarge;
  };
  if (!is_near(learned.model)) return;
  for (const double tolerance : kTolerances) {
    ColourModel with = learned.model;
    with.tolerance = tolerance;
    if (tolerance >= learned.model.tolerance || is_near(with)) continue;
    learned = graded(with, grade(with, training), learned.by_brightness);
    return;
  }
}

/// Learns from the samples of object and background.
LearnedColour learn(const TrainingSamples& training) {
  std::vector<ChromaSample> coloured = coloured_samples(training.object);
  if (coloured.empty()) return failed(Status::kOverexposed);
  std::erase_if(coloured, is_dark);
  LearnedColour result;
  result.model.object = fit_chroma(coloured, 3);
  // A black object has no chroma: use a neutral component for its noise.
  if (result.model.object.empty()) result.model.object.push_back({{0, 0}, 0.04 * Eigen::Matrix2d::Identity(), 1});

  // Some components may describe other things inside the rectangle, so try every subset and keep the best.
  const std::vector<ChromaComponent> components = result.model.object;
  double best = -1e9;
  for (size_t some = 1; some < size_t{1} << components.size(); ++some) {
    ColourModel model;
    for (size_t i = 0; i < components.size(); ++i) {
      if (some >> i & 1) model.object.push_back(components[i]);
    }
    const bool by_brightness = tune(model, training);
    const Grade now = grade(model, training);
    if (now.score() <= best) continue;
    best = now.score();
    result = graded(model, now, by_brightness);
  }
  // A rectangle does not tell which blobs are the object's, and so not what a wider model lets pass.
  if (!training.trials.empty()) widen_saturation(result, training);
  keep_away_from_background(result, training);
  return result;
}

}  // namespace

LearnedColour learn_colour(std::span<const TrainingPicture> pictures) {
  if (std::ranges::none_of(pictures, &TrainingPicture::has_object)) return failed(Status::kNoObject);
  const std::vector<TrainingSamples> samples = training_samples(pictures);
  for (size_t k = 0; k < samples.size(); ++k) {
    if (samples[k].status == Status::kLearned) continue;
    LearnedColour result = failed(samples[k].status);
    result.picture = k;
    return result;
  }
  LearnedColour learned = learn(merged(samples));
  if (learned.status != Status::kLearned) return learned;
  for (const TrainingSamples& picture : samples) {
    learned.rates.push_back(
        {share_of_members(learned.model, picture.object), share_of_members(learned.model, picture.rest)});
  }
  return learned;
}

LearnedColour learn_colour(const cv::Mat& bgr, const cv::Rect& rectangle) {
  return learn_colour(std::array{TrainingPicture{.bgr = bgr, .rectangle = rectangle}});
}

LearnedColour learn_colour_of(const cv::Mat& bgr, const cv::Mat& mask) {
  if (mask.empty()) return failed(Status::kBadImage);
  return learn_colour(std::array{TrainingPicture{.bgr = bgr, .mask = mask}});
}

}  // namespace multireach::vision
