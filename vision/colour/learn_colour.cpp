#include "vision/colour/learn_colour.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "vision/colour/chroma_classifier.hpp"
#include "vision/colour/chroma_fit.hpp"
#include "vision/colour/find.hpp"

namespace multireach::vision {
namespace {

constexpr int kFewest = 40;          // pixels, smallest area of the rectangle
constexpr double kDark = 12;         // grey levels, below which chroma is noise
constexpr double kMoreFrequent = 2;  // an object colour is this many times more frequent inside than outside
constexpr double kMinObject = 0.2;   // smallest share of object colours in the rectangle
constexpr double kEnough = 0.3;      // smallest share of object pixels with known colour, i.e. not overexposed
constexpr double kSwamped = 0.05;    // misclassified background share above which brightness limits are tried
constexpr double kWideness = 0.03;   // share of the object that a tolerance wider by one sigma must add
constexpr double kClean = 0.002;     // misclassified share of the background that is acceptable

ChromaSample sample_of(const cv::Vec3b& pixel) {
  ChromaSample sample;
  sample.colour = {static_cast<double>(pixel[2]), static_cast<double>(pixel[1]), static_cast<double>(pixel[0])};
  sample.luma = luma_of(sample.colour);
  if (sample.luma >= kDark) sample.chroma = chroma_of(sample.colour);
  return sample;
}

/// Samples the pixels of `part` outside `without` on a grid, at most about `most` of them.
std::vector<ChromaSample> samples_of(const cv::Mat& bgr, const cv::Rect& part, const cv::Rect& without, double most) {
  const int step = std::max(1, static_cast<int>(std::sqrt(part.area() / most)));
  std::vector<ChromaSample> samples;
  for (int row = part.y; row < part.br().y; row += step) {
    for (int column = part.x; column < part.br().x; column += step) {
      if (without.contains({column, row})) continue;
      ChromaSample sample = sample_of(bgr.at<cv::Vec3b>(row, column));
      // The middle of the rectangle shows the object more likely than its corners.
      const double x = (column + 0.5 - part.x) / part.width * 2 - 1, y = (row + 0.5 - part.y) / part.height * 2 - 1;
      if (without.empty()) sample.weight = std::max(0.0, 1 - 0.6 * (x * x + y * y));
      samples.push_back(sample);
    }
  }
  return samples;
}

/// Samples the pixels of `part` that are inside, or outside, a mask, on a grid, at most about `most` of them.
std::vector<ChromaSample> samples_of(const cv::Mat& bgr, const cv::Rect& part, const cv::Mat& mask, bool inside,
                                     double most) {
  const int step = std::max(1, static_cast<int>(std::sqrt(part.area() / most)));
  std::vector<ChromaSample> samples;
  for (int row = part.y; row < part.br().y; row += step) {
    for (int column = part.x; column < part.br().x; column += step) {
      if ((mask.at<uint8_t>(row, column) != 0) == inside) samples.push_back(sample_of(bgr.at<cv::Vec3b>(row, column)));
    }
  }
  return samples;
}

bool clipped(const ChromaSample& sample) {
  return std::max({sample.colour.r, sample.colour.g, sample.colour.b}) >= kClipped;
}

bool overexposed(const ChromaSample& sample) {
  const Rgb& c = sample.colour;
  return (c.r >= kClipped) + (c.g >= kClipped) + (c.b >= kClipped) > 1;
}

double total_weight(const std::vector<ChromaSample>& samples) {
  double total = 0;
  for (const ChromaSample& sample : samples) total += sample.weight;
  return total;
}

/// Histogram of samples over chroma and brightness, as shares.
class Frequencies {
 public:
  explicit Frequencies(const std::vector<ChromaSample>& samples) : shares_(kChroma * kChroma * kLuma) {
    const double total = total_weight(samples);
    for (const ChromaSample& sample : samples) shares_[cell(sample)] += sample.weight / total;
  }
  double of(const ChromaSample& sample) const { return shares_[cell(sample)]; }

 private:
  static constexpr int kChroma = 24, kLuma = 8;
  static size_t cell(const ChromaSample& sample) {
    const auto chroma = [](double value) { return std::clamp(static_cast<int>((value + 2) * 4), 0, kChroma - 1); };
    const int luma = std::min(static_cast<int>(std::sqrt(sample.luma) / 2), kLuma - 1);
    return static_cast<size_t>((luma * kChroma + chroma(sample.chroma.y())) * kChroma + chroma(sample.chroma.x()));
  }
  std::vector<double> shares_;
};

double share_of_members(const ColourModel& model, const std::vector<ChromaSample>& samples) {
  const ChromaClassifier test(model, {});
  double members = 0;
  for (const ChromaSample& sample : samples) members += test.contains(sample.colour) ? sample.weight : 0;
  return samples.empty() ? 0 : members / total_weight(samples);
}

/// The image and the object's pixels in it, for trying a model with the blob finder.
struct Trial {
  cv::Mat bgr, mask;  // empty where the object's pixels are not known
  cv::Mat alike;      // pixels of other objects of the same colour; empty where there are none
  cv::Rect box;       // of the mask, widened: other blobs do not touch it
  double area = 0;    // of the mask, pixels
};

struct Pictures {
  std::vector<ChromaSample> object, rest;
  Trial trial;
};

struct Grade {
  double kept, background;
  double clutter = 0;  // area of blobs of other things, relative to the object's
  /// 1 % of the background misclassified costs as much as 10 % of the object missed; blobs cost by their area.
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

/// What the finder finds beside the object and others of its colour, relative to the object's area.
double clutter_of(const ColourModel& model, const Trial& trial) {
  if (trial.mask.empty()) return 0;
  BlobFinder finder;
  const FoundBlobs found =
      finder.find(trial.bgr, {0, 0, trial.bgr.cols, trial.bgr.rows}, ColourTable(model), {.most = 64});
  if (found.too_many_runs) return 1e3;
  double area = 0;
  for (const Blob& blob : found.blobs) {
    if ((blob.box & trial.box).empty()) area += area_outside(blob, trial.alike);
    // A blob that contains the object and much else.
    if (!(blob.box & trial.box).empty()) area += std::max(0.0, blob.area - 1.5 * trial.area);
  }
  return area / trial.area;
}

Grade grade(const ColourModel& model, const Pictures& pictures) {
  return {share_of_members(model, pictures.object), share_of_members(model, pictures.rest),
          clutter_of(model, pictures.trial)};
}

/// Cuts the background pixels that are classified as the object out of the model, by components for them, if that
/// improves the score. Returns the grade.
Grade cut_background(ColourModel& model, const Pictures& pictures) {
  model.background.clear();
  Grade best = grade(model, pictures);
  if (best.background <= kClean && best.clutter == 0) return best;
  const ChromaClassifier test(model, {});
  std::vector<ChromaSample> confused;
  for (const ChromaSample& sample : pictures.rest) {
    if (sample.luma >= kDark && !clipped(sample) && test.contains(sample.colour)) confused.push_back(sample);
  }
  if (confused.empty()) return best;
  const std::vector<ChromaComponent> components = fit_chroma(confused, 3);
  const double share = total_weight(confused) / total_weight(pictures.rest);
  // The shares of the object and of its background differ from picture to picture, so the score chooses.
  ColourModel chosen = model;
  for (const double factor : {1.0, 10.0, 100.0}) {
    if (factor > 1 && pictures.trial.mask.empty()) break;  // the object's share is not known
    ColourModel with = model;
    with.background = components;
    for (ChromaComponent& component : with.background) component.weight *= share * factor;
    const Grade now = grade(with, pictures);
    if (now.score() <= best.score()) continue;
    best = now;
    chosen = with;
  }
  model = chosen;
  return best;
}

/// Sets the tolerance with the best score, with the background cut out or not. Objects that this picture does not show
/// may have similar colours, so what a tolerance beyond the usual one adds must be worth it.
void choose_tolerance(ColourModel& model, const Pictures& pictures, bool cut) {
  constexpr double kUsual = 3;
  double best_score = -1e9;
  ColourModel best = model;
  for (const double tolerance : {4.0, 3.5, 3.0, 2.5, 2.0, 1.5}) {
    ColourModel with = model;
    with.tolerance = tolerance;
    const Grade now = cut ? cut_background(with, pictures) : grade(with, pictures);
    // What a rectangle shows besides the object hides how much a tolerance gains: the widest that is clean.
    const bool rectangle = pictures.trial.mask.empty();
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
bool separate_by_brightness(ColourModel& model, const Pictures& pictures) {
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
  accumulate(object, pictures.object, [](const ChromaSample&) { return true; });
  accumulate(rest, pictures.rest, [&](const ChromaSample& sample) { return test.contains(sample.colour); });
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
      with.min_luma = 0;
      with.max_luma = limit;
    } else {
      with.min_luma = std::min(limit, with.max_luma - 1);
    }
    if (grade(with, pictures).score() > grade(best, pictures).score()) best = with;
  }
  const bool better = grade(best, pictures).score() > grade(model, pictures).score() + 0.01;
  if (better) model = best;
  return better;
}

/// Where the finder finds other things of the object's chroma in the image, limits the brightness to that of the
/// object, with some room for other exposures: as much as the other things allow.
void limit_brightness(ColourModel& model, const Pictures& pictures) {
  Grade best = grade(model, pictures);
  if (best.clutter == 0) return;
  std::vector<double> lumas;
  for (const ChromaSample& sample : pictures.object) lumas.push_back(sample.luma);
  std::ranges::sort(lumas);
  const double darkest = lumas[lumas.size() / 50], brightest = lumas[lumas.size() - 1 - lumas.size() / 50];
  ColourModel limited = model;
  for (const double room : {3.0, 2.0, 1.5, 1.2}) {
    ColourModel with = limited;
    with.min_luma = std::max(with.min_luma, darkest / room);
    with.max_luma = std::min(with.max_luma, brightest * room);
    const Grade now = grade(with, pictures);
    constexpr double kWorthwhile = 0.05;
    if (now.score() < best.score() + kWorthwhile) continue;
    best = now;
    model = with;
  }
}

/// Chooses tolerance, limits of brightness and background for given components of the object. Returns whether it set a
/// limit of brightness.
bool tune(ColourModel& model, const Pictures& pictures) {
  ColourModel cut = model;
  choose_tolerance(model, pictures, false);
  const Grade by_chroma = grade(model, pictures);
  bool by_brightness = false;
  if (by_chroma.background > kSwamped) {
    ColourModel limited = model;
    limited.tolerance = 4;
    by_brightness = separate_by_brightness(limited, pictures);
    if (by_brightness) {
      model = limited;
      choose_tolerance(model, pictures, false);
    }
  }
  if (pictures.trial.mask.empty()) {
    cut_background(model, pictures);
    return by_brightness;
  }
  // Cut by the colours around the object, its chroma may distinguish it after all.
  choose_tolerance(cut, pictures, true);
  if (!by_brightness || grade(cut, pictures).score() > grade(model, pictures).score()) {
    model = cut;
    by_brightness = false;
  }
  if (!by_brightness) limit_brightness(model, pictures);
  return by_brightness;
}

}  // namespace

const char* description(LearnedColour::Status status) {
  switch (status) {
    case LearnedColour::Status::kLearned:
      return "learned";
    case LearnedColour::Status::kBadImage:
      return "the image is not an 8-bit colour image";
    case LearnedColour::Status::kBadRectangle:
      return "the rectangle is outside of the image, or too small: at least 40 of its pixels must be in the image";
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

/// The samples of the object whose colour is known; none where too many are overexposed.
std::vector<ChromaSample> coloured_samples(const Pictures& pictures) {
  const double object = total_weight(pictures.object);
  std::vector<ChromaSample> coloured = pictures.object;
  std::erase_if(coloured, clipped);
  if (total_weight(coloured) < kEnough * object) {
    // Accept one clipped channel: the true colour is at least as saturated as it appears. With two clipped channels the
    // colour is unknown.
    coloured = pictures.object;
    std::erase_if(coloured, overexposed);
    if (total_weight(coloured) < kEnough * object) coloured.clear();
  }
  return coloured;
}

/// Widens the model along saturation: under other light, through haze or with more reflected white, an object keeps its
/// hue, but one picture shows it at one position only. Takes the wider of two that keeps no less of the
/// object, and lets no more of this picture's background pass, or no more than kClean. At a tolerance of three standard
/// deviations the wider allows three tenths of the saturation more or less; with half of it, as
/// limits in HSV often allow, following the white balance took such changes for those of the light (docs/vision.md,
/// pink on the tuning videos).
void widen_saturation(LearnedColour& learned, const Pictures& pictures) {
  const Grade before = grade(learned.model, pictures);
  for (const double share : {0.1, 0.05}) {
    ColourModel with = learned.model;
    for (ChromaComponent& component : with.object) {
      const Eigen::Vector2d along = share * component.mean;
      component.covariance += along * along.transpose();
    }
    const Grade now = grade(with, pictures);
    if (now.background > std::max(before.background, kClean) || now.clutter > before.clutter || now.kept < before.kept)
      continue;
    learned = {Status::kLearned, with, now.kept, now.background, learned.by_brightness};
    return;
  }
}

/// Learns from the samples of object and background.
LearnedColour learn(const Pictures& pictures) {
  std::vector<ChromaSample> coloured = coloured_samples(pictures);
  if (coloured.empty()) return failed(Status::kOverexposed);
  std::erase_if(coloured, [](const ChromaSample& sample) { return sample.luma < kDark; });
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
    const bool by_brightness = tune(model, pictures);
    const Grade now = grade(model, pictures);
    if (now.score() <= best) continue;
    best = now.score();
    result = {Status::kLearned, model, now.kept, now.background, by_brightness};
  }
  // A rectangle does not tell which blobs are the object's, and so not what a wider model lets pass.
  if (!pictures.trial.mask.empty()) widen_saturation(result, pictures);
  return result;
}

/// Whether the mean chroma of a blob is that of a component: within its standard deviation, not only in its tails.
bool is_alike(const cv::Mat& bgr, const Blob& blob, const ChromaComponent& component) {
  constexpr double kDistance = 1.2;
  Eigen::Vector2d sum(0, 0);
  for (const Run& run : blob.runs) {
    for (int column = run.begin; column < run.end; ++column)
      sum += sample_of(bgr.at<cv::Vec3b>(run.row, column)).chroma;
  }
  const Eigen::Vector2d from = sum / blob.area - component.mean;
  return from.dot(component.covariance.inverse() * from) < kDistance * kDistance;
}

/// Marks other objects of the object's main colour, with a border in which colours mix.
cv::Mat objects_alike(const Pictures& pictures) {
  constexpr double kTolerance = 2, kLeastArea = 0.1, kMostArea = 25;
  constexpr double kSolid = 0.4;  // least share of its box: a ball's is 0.8, that of a texture is less
  constexpr int kBorder = 7;      // pixels
  const Trial& trial = pictures.trial;
  ColourModel main;
  main.object = fit_chroma(coloured_samples(pictures), 1);
  main.tolerance = kTolerance;
  if (main.object.empty()) return {};
  BlobFinder finder;
  const FoundBlobs found = finder.find(trial.bgr, {0, 0, trial.bgr.cols, trial.bgr.rows}, ColourTable(main),
                                       {.min_area = kLeastArea * trial.area, .most = 64});
  cv::Mat alike = cv::Mat::zeros(trial.mask.size(), CV_8UC1);
  for (const Blob& blob : found.blobs) {
    if (!(blob.box & trial.box).empty() || blob.area > kMostArea * trial.area) continue;
    if (blob.area < kSolid * blob.box.area() || !is_alike(trial.bgr, blob, main.object[0])) continue;
    for (const Run& run : blob.runs) alike.row(run.row).colRange(run.begin, run.end) = 255;
  }
  cv::dilate(alike, alike, cv::getStructuringElement(cv::MORPH_ELLIPSE, {kBorder, kBorder}));
  return alike;
}

}  // namespace

LearnedColour learn_colour(const cv::Mat& bgr, const cv::Rect& rectangle) {
  if (bgr.type() != CV_8UC3) return failed(Status::kBadImage);
  const cv::Rect image(0, 0, bgr.cols, bgr.rows), inside = rectangle & image;
  if (inside.area() < kFewest) return failed(Status::kBadRectangle);
  const cv::Point margin(inside.width / 4, inside.height / 4);
  const cv::Rect around(inside.tl() - margin, inside.br() + margin);
  const std::vector<ChromaSample> in_rectangle = samples_of(bgr, inside, {}, 8000);
  Pictures pictures;
  pictures.rest = samples_of(bgr, image, around, 30000);

  const Frequencies here(in_rectangle), elsewhere(pictures.rest);
  const bool nothing_else = pictures.rest.empty();
  for (const ChromaSample& sample : in_rectangle) {
    if (nothing_else || here.of(sample) > kMoreFrequent * elsewhere.of(sample)) pictures.object.push_back(sample);
  }
  if (total_weight(pictures.object) < kMinObject * total_weight(in_rectangle)) return failed(Status::kIndistinct);
  return learn(pictures);
}

LearnedColour learn_colour_of(const cv::Mat& bgr, const cv::Mat& mask) {
  if (bgr.type() != CV_8UC3 || mask.type() != CV_8UC1 || mask.size() != bgr.size()) return failed(Status::kBadImage);
  Pictures pictures;
  cv::Mat inner, outer;
  constexpr int kBorder = 7;  // pixels in which object and background mix
  const auto disc = [](int size) { return cv::getStructuringElement(cv::MORPH_ELLIPSE, {size, size}); };
  cv::erode(mask, inner, disc(3));
  if (cv::countNonZero(inner) < kFewest / 2) inner = mask;
  cv::dilate(mask, outer, disc(2 * kBorder + 1));
  const cv::Rect whole(0, 0, bgr.cols, bgr.rows), box = cv::boundingRect(mask);
  pictures.trial = {bgr, mask, {}, box + cv::Size(2, 2), static_cast<double>(cv::countNonZero(mask))};
  pictures.trial.box = (pictures.trial.box - cv::Point(1, 1)) & whole;
  if (pictures.trial.area < kFewest) return failed(Status::kBadRectangle);
  pictures.object = samples_of(bgr, box, inner, true, 8000);
  pictures.rest = samples_of(bgr, whole, outer, false, 30000);
  if (pictures.object.empty()) return failed(Status::kBadRectangle);
  // Other objects of the same colour must not cut this one up: they are not background.
  pictures.trial.alike = objects_alike(pictures);
  if (cv::countNonZero(pictures.trial.alike) > 0)
    pictures.rest = samples_of(bgr, whole, outer | pictures.trial.alike, false, 30000);
  return learn(pictures);
}

}  // namespace multireach::vision
