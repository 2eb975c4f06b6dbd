#include "vision/colour/training_samples.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "vision/colour/colour_table.hpp"
#include "vision/colour/find.hpp"

namespace multireach::vision {
namespace {

using Status = LearnedColour::Status;

constexpr int kFewest = 40;          // pixels, smallest area of the object
constexpr double kDark = 12;         // grey levels, below which chroma is noise
constexpr double kMoreFrequent = 2;  // an object colour is this many times more frequent inside than outside
constexpr double kMinObject = 0.2;   // smallest share of object colours in the rectangle
constexpr double kEnough = 0.3;      // smallest share of object pixels with known colour, i.e. not overexposed
constexpr double kObjectSamples = 8000, kRestSamples = 30000;  // of all pictures, about

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

bool is_overexposed(const ChromaSample& sample) {
  const Rgb& c = sample.colour;
  return (c.r >= kClipped) + (c.g >= kClipped) + (c.b >= kClipped) > 1;
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

/// Marks objects of the object's main colour, with a border in which colours mix: those beyond the parts of the mask,
/// or, with `at_parts`, all. Empty where that colour is not known.
cv::Mat objects_alike(const std::vector<ChromaSample>& object, const Trial& trial, bool at_parts) {
  constexpr double kTolerance = 2, kLeastArea = 0.1, kMostArea = 25;
  constexpr double kSolid = 0.4;  // least share of its box: a ball's is 0.8, that of a texture is less
  constexpr double kShape = 0.2;  // least compactness, as a share of the object's: a coloured edge is no such object
  constexpr int kBorder = 3;      // pixels
  ColourModel main;
  main.object = fit_chroma(coloured_samples(object), 1);
  main.tolerance = kTolerance;
  if (main.object.empty()) return {};
  BlobFinder finder;
  const FoundBlobs found = finder.find(trial.bgr, {0, 0, trial.bgr.cols, trial.bgr.rows}, ColourTable(main),
                                       {.min_area = kLeastArea * trial.area, .most = 64});
  const auto largest = std::ranges::max_element(trial.parts, {}, &Trial::Part::area);
  const cv::Moments moments = cv::moments(trial.mask(largest->box), true);
  Eigen::Matrix2d spread;
  spread << moments.mu20, moments.mu11, moments.mu11, moments.mu02;
  const double least_compact = kShape * compactness(moments.m00, spread / moments.m00);
  cv::Mat alike = cv::Mat::zeros(trial.mask.size(), CV_8UC1);
  for (const Blob& blob : found.blobs) {
    if ((!at_parts && trial.area_at(blob.box) > 0) || blob.area > kMostArea * trial.area) continue;
    if (blob.area < kSolid * blob.box.area() || compactness(blob) < least_compact) continue;
    if (!is_alike(trial.bgr, blob, main.object[0])) continue;
    for (const Run& run : blob.runs) alike.row(run.row).colRange(run.begin, run.end) = 255;
  }
  cv::dilate(alike, alike, cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * kBorder + 1, 2 * kBorder + 1}));
  alike.setTo(0, trial.mask);
  return alike;
}

/// The parts of a mask that are farther apart than their widened boxes reach.
std::vector<Trial::Part> parts_of(const cv::Mat& mask) {
  cv::Mat labels, stats, centres;
  const int count = cv::connectedComponentsWithStats(mask, labels, stats, centres);
  const cv::Rect whole({0, 0}, mask.size());
  std::vector<Trial::Part> parts;
  for (int k = 1; k < count; ++k) {
    const int* of = stats.ptr<int>(k);
    const cv::Rect box(of[cv::CC_STAT_LEFT], of[cv::CC_STAT_TOP], of[cv::CC_STAT_WIDTH], of[cv::CC_STAT_HEIGHT]);
    const cv::Size margin(box.width / 2, box.height / 2);
    Trial::Part part{(box + margin + margin - cv::Point(margin)) & whole, static_cast<double>(of[cv::CC_STAT_AREA])};
    for (bool grew = true; grew;) {
      grew = false;
      for (auto other = parts.begin(); other != parts.end() && !grew; ++other) {
        if ((other->box & part.box).empty()) continue;
        part = {other->box | part.box, other->area + part.area};
        parts.erase(other);
        grew = true;
      }
    }
    parts.push_back(part);
  }
  return parts;
}

TrainingSamples failed(Status status) {
  return {.status = status, .object = {}, .rest = {}, .trials = {}};
}

/// How many samples to take of a picture, about.
struct Budget {
  double object, rest;
};

/// Of a picture in which the object fills most of a rectangle.
TrainingSamples in_rectangle(const cv::Mat& bgr, const cv::Rect& rectangle, const Budget& most) {
  const cv::Rect image(0, 0, bgr.cols, bgr.rows), inside = rectangle & image;
  if (inside.area() < kFewest) return failed(Status::kTooSmall);
  const cv::Point margin(inside.width / 4, inside.height / 4);
  const cv::Rect around(inside.tl() - margin, inside.br() + margin);
  const std::vector<ChromaSample> in_it = samples_of(bgr, inside, {}, most.object);
  TrainingSamples samples;
  samples.rest = samples_of(bgr, image, around, most.rest);

  const Frequencies here(in_it), elsewhere(samples.rest);
  const bool nothing_else = samples.rest.empty();
  for (const ChromaSample& sample : in_it) {
    if (nothing_else || here.of(sample) > kMoreFrequent * elsewhere.of(sample)) samples.object.push_back(sample);
  }
  if (total_weight(samples.object) < kMinObject * total_weight(in_it)) return failed(Status::kIndistinct);
  return samples;
}

cv::Mat disc(int size) {
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, {size, size});
}

/// Samples what is not the object's: more than a few pixels away from its mask, and not alike.
std::vector<ChromaSample> rest_of(const Trial& trial, double most) {
  constexpr int kMixed = 7;  // pixels to each side of the edge in which object and background mix
  cv::Mat outer;
  cv::dilate(trial.mask, outer, disc(2 * kMixed + 1));
  if (!trial.alike.empty()) outer |= trial.alike;
  return samples_of(trial.bgr, {{0, 0}, trial.bgr.size()}, outer, false, most);
}

/// Of a picture in which the object's pixels are known.
TrainingSamples in_mask(const cv::Mat& bgr, const cv::Mat& mask, const Budget& most) {
  cv::Mat inner;
  cv::erode(mask, inner, disc(3));
  if (cv::countNonZero(inner) < kFewest / 2) inner = mask;
  const cv::Rect box = cv::boundingRect(mask);
  Trial trial{.bgr = bgr, .mask = mask, .alike = {}, .parts = parts_of(mask)};
  const int area = cv::countNonZero(mask);
  if (area < kFewest) return failed(Status::kTooSmall);
  trial.area = area / static_cast<double>(trial.parts.size());
  TrainingSamples samples;
  samples.object = samples_of(bgr, box, inner, true, most.object);
  if (samples.object.empty()) samples.object = samples_of(bgr, box, mask, true, box.area());  // a thin one
  // Other objects of the same colour must not cut this one up: they are not background.
  trial.alike = objects_alike(samples.object, trial, false);
  samples.rest = rest_of(trial, most.rest);
  samples.trials = {trial};
  return samples;
}

/// Of a picture without the object.
TrainingSamples without_object(const cv::Mat& bgr, const Budget& most) {
  const cv::Mat nothing = cv::Mat::zeros(bgr.size(), CV_8UC1);
  TrainingSamples samples;
  samples.rest = samples_of(bgr, {0, 0, bgr.cols, bgr.rows}, nothing, false, most.rest);
  samples.trials = {{.bgr = bgr, .mask = nothing, .alike = {}, .parts = {}}};
  return samples;
}

void scale(std::vector<ChromaSample>& samples, double factor) {
  for (ChromaSample& sample : samples) sample.weight *= factor;
}

TrainingSamples samples_of_picture(const TrainingPicture& picture, const Budget& most) {
  const cv::Mat& bgr = picture.bgr;
  if (bgr.type() != CV_8UC3 || bgr.empty()) return failed(Status::kBadImage);
  if (!picture.has_object) return without_object(bgr, most);
  if (picture.mask.empty()) return in_rectangle(bgr, picture.rectangle, most);
  if (picture.mask.type() != CV_8UC1 || picture.mask.size() != bgr.size()) return failed(Status::kBadImage);
  return in_mask(bgr, picture.mask, most);
}

}  // namespace

double Trial::area_at(const cv::Rect& box) const {
  double sum = 0;
  for (const Part& part : parts) sum += (part.box & box).empty() ? 0 : part.area;
  return sum;
}

std::vector<TrainingSamples> training_samples(std::span<const TrainingPicture> pictures) {
  const auto with = std::ranges::count_if(pictures, &TrainingPicture::has_object);
  const Budget most{kObjectSamples / static_cast<double>(std::max<ptrdiff_t>(1, with)),
                    kRestSamples / static_cast<double>(std::max<size_t>(1, pictures.size()))};
  std::vector<TrainingSamples> samples;
  for (const TrainingPicture& picture : pictures) samples.push_back(samples_of_picture(picture, most));
  if (with < 2 || std::ranges::any_of(samples, [](const auto& of) { return of.status != Status::kLearned; }))
    return samples;
  // All pictures together tell best what is alike, and what is more of the object: a click may show one patch of it.
  const std::vector<ChromaSample> object = merged(samples).object;
  for (TrainingSamples& of_picture : samples) {
    if (of_picture.trials.empty() || of_picture.trials[0].parts.empty()) continue;
    Trial& trial = of_picture.trials[0];
    const cv::Mat more = objects_alike(object, trial, true);
    if (more.empty()) continue;
    trial.alike = trial.alike.empty() ? more : cv::Mat(trial.alike | more);
    of_picture.rest = rest_of(trial, most.rest);
  }
  return samples;
}

TrainingSamples merged(std::vector<TrainingSamples> pictures) {
  if (pictures.size() == 1) return std::move(pictures.front());
  TrainingSamples all;
  double smallest = 0;  // of the objects whose pixels are known
  for (TrainingSamples& picture : pictures) {
    for (auto* samples : {&picture.object, &picture.rest}) {
      if (!samples->empty()) scale(*samples, 1 / total_weight(*samples));
    }
    all.object.insert(all.object.end(), picture.object.begin(), picture.object.end());
    all.rest.insert(all.rest.end(), picture.rest.begin(), picture.rest.end());
    for (const Trial& trial : picture.trials) {
      all.trials.push_back(trial);
      if (trial.area > 0) smallest = smallest > 0 ? std::min(smallest, trial.area) : trial.area;
    }
  }
  if (!(smallest > 0)) all.trials.clear();
  for (Trial& trial : all.trials) {
    if (!(trial.area > 0)) trial.area = smallest;
  }
  return all;
}

bool is_clipped(const ChromaSample& sample) {
  return std::max({sample.colour.r, sample.colour.g, sample.colour.b}) >= kClipped;
}

bool is_dark(const ChromaSample& sample) {
  return sample.luma < kDark;
}

std::vector<ChromaSample> coloured_samples(const std::vector<ChromaSample>& object) {
  const double total = total_weight(object);
  std::vector<ChromaSample> coloured = object;
  std::erase_if(coloured, is_clipped);
  if (total_weight(coloured) < kEnough * total) {
    // Accept one clipped channel: the true colour is at least as saturated as it appears. With two clipped channels the
    // colour is unknown.
    coloured = object;
    std::erase_if(coloured, is_overexposed);
    if (total_weight(coloured) < kEnough * total) coloured.clear();
  }
  return coloured;
}

}  // namespace multireach::vision
