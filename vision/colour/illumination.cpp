#include "vision/colour/illumination.hpp"

#include <algorithm>
#include <cmath>

namespace multireach::vision {
namespace {

constexpr int64_t kMinPixels = 30;
constexpr int kDark = 16;       // grey levels: below, the camera's offset outweighs the effect of the light
constexpr double kRate = 0.15;  // share of the error per frame: lags 7 % when white balance drifts by 50 % in a second
constexpr double kMaxStep = 0.05;  // relative, per frame: limits the effect of a wrong blob
constexpr double kSameColour = 2;  // standard deviations of the learned colour; its own mean deviates by less than one
// Relative standard deviation of R/G and B/G: of a colour learned from one click, the smaller of the two is 0.05 to
// 0.25 on the tuning videos (docs/real-images.md), mostly 0.08 to 0.15, and the larger one, along the saturation, 0.1
// to 1.
constexpr double kPlainSpread = 0.12;
constexpr double kOwnRate = 0.1;      // of kRate
constexpr double kRelaxation = 0.01;  // share of the error per frame: halves it in two seconds at 30 Hz
constexpr double kQuantum = 1.0 / 64;

double towards(double gain, double wanted, double rate) {
  const double step = std::clamp(rate * (wanted - gain), -kMaxStep * gain, kMaxStep * gain);
  return std::clamp(gain + step, kMinGain, kMaxGain);
}

/// What a gain is moved towards: what differs from the object's mean colour by no more than its spread moves it less.
double damped_target(double gain, double needed, double spread) {
  const double limit = 1 + std::max(0.0, spread - kPlainSpread), within = std::clamp(needed / gain, 1 / limit, limit);
  return needed / within * (1 + kOwnRate * (within - 1));
}

/// IlluminationSample::spread of a model: of its components, each about its own mean, since the nearest one counts.
WhiteBalanceGains spread_of(const ColourModel& model) {
  // Derivatives of colour_of() with respect to the chroma.
  const Eigen::Vector2d of_red(0.75, -0.25), of_green(-0.25, -0.25), of_blue(-0.25, 0.75);
  constexpr double kLeast = 0.05;  // of Y: a channel that a pure colour lacks
  double total = 0, red = 0, blue = 0;
  for (const ChromaComponent& component : model.object) {
    const Rgb colour = colour_of(component.mean);
    const auto variance = [&](const Eigen::Vector2d& of_channel, double channel) {
      const Eigen::Vector2d of_ratio = of_channel / std::max(channel, kLeast) - of_green / std::max(colour.g, kLeast);
      return of_ratio.dot(component.covariance * of_ratio);
    };
    total += component.weight;
    red += component.weight * variance(of_red, colour.r);
    blue += component.weight * variance(of_blue, colour.b);
  }
  return {std::sqrt(red / total), std::sqrt(blue / total)};
}

WhiteBalanceGains rounded(const WhiteBalanceGains& gains) {
  const auto whole = [](double gain) { return std::nearbyint(gain / kQuantum) * kQuantum; };
  return {whole(gains.red), whole(gains.blue)};
}

ColourModel with_half_tolerance(ColourModel model) {
  model.tolerance /= 2;
  return model;
}

Rgb& operator+=(Rgb& sum, const Rgb& colour) {
  sum = {sum.r + colour.r, sum.g + colour.g, sum.b + colour.b};
  return sum;
}

}  // namespace

WhiteBalanceGains adapted(const WhiteBalanceGains& gains, const IlluminationSample& sample, double quality) {
  const Rgb &seen = sample.seen, &expected = sample.expected;
  const bool usable = sample.pixels >= kMinPixels && seen.r > 0 && seen.g > 0 && seen.b > 0 && expected.r > 0 &&
                      expected.g > 0 && expected.b > 0;
  if (!usable || !(quality > 0) || sample.deviation > kSameColour) return gains;
  const double rate = kRate * std::min(quality, 1.0);
  const double red = expected.r * seen.g / (expected.g * seen.r), blue = expected.b * seen.g / (expected.g * seen.b);
  return {towards(gains.red, damped_target(gains.red, red, sample.spread.red), rate),
          towards(gains.blue, damped_target(gains.blue, blue, sample.spread.blue), rate)};
}

WhiteBalanceGains relaxed(const WhiteBalanceGains& gains) {
  return {towards(gains.red, 1, kRelaxation), towards(gains.blue, 1, kRelaxation)};
}

bool are_as_learned(const WhiteBalanceGains& gains) {
  return rounded(gains) == WhiteBalanceGains{};
}

WhiteBalanceGains returning(const WhiteBalanceGains& gains, double quality) {
  const double rate = kRate * std::clamp(quality, 0.0, 1.0);
  return {towards(gains.red, 1, rate), towards(gains.blue, 1, rate)};
}

AdaptedColourModel::AdaptedColourModel(const ColourModel& model)
    : model_(model),
      test_(model, {}),
      inner_(with_half_tolerance(model), {}),
      members_(model),
      spread_(spread_of(model)) {}

void AdaptedColourModel::prepare(const WhiteBalanceGains& gains) {
  const WhiteBalanceGains wanted = rounded(gains);
  if (wanted == gains_) return;
  gains_ = wanted;
  test_.set_gains(wanted);
  inner_.set_gains(wanted);
  members_ = ColourTable(test_);
}

const ColourTable& AdaptedColourModel::members(const WhiteBalanceGains& gains) {
  prepare(gains);
  return members_;
}

double AdaptedColourModel::share_well_inside(const WhiteBalanceGains& gains, const cv::Mat& bgr, const Blob& blob) {
  prepare(gains);
  constexpr int64_t kSamples = 64;
  int64_t pixels = 0, seen = 0, inside = 0;
  for (const Run& run : blob.runs) pixels += run.end - run.begin;
  const int64_t every = std::max<int64_t>(1, (pixels + kSamples - 1) / kSamples);
  int64_t next = every / 2;  // from the run's first pixel
  for (const Run& run : blob.runs) {
    const int64_t length = run.end - run.begin;
    for (; next < length; next += every) {
      const auto& pixel = bgr.at<cv::Vec3b>(run.row, run.begin + static_cast<int>(next));
      ++seen;
      inside += inner_.contains_as_read(
          {static_cast<double>(pixel[2]), static_cast<double>(pixel[1]), static_cast<double>(pixel[0])});
    }
    next -= length;
  }
  return seen > 0 ? static_cast<double>(inside) / static_cast<double>(seen) : 0;
}

IlluminationSample AdaptedColourModel::sample(const WhiteBalanceGains& gains, const cv::Mat& bgr, const Blob& blob) {
  prepare(gains);
  IlluminationSample sample;
  // Skip the border, where object and background mix: over a pixel or two, with JPEG over a few more.
  const auto margin = [](int size) { return 2 + size / 8; };
  const int first_row = blob.box.y + margin(blob.box.height), last_row = blob.box.br().y - margin(blob.box.height);
  constexpr double kEnough = 2000;
  const int every = 1 + static_cast<int>(blob.area / kEnough);
  for (const Run& run : blob.runs) {
    if (run.row < first_row || run.row >= last_row || (run.row - first_row) % every != 0) continue;
    const int inset = margin(run.end - run.begin);
    for (int column = run.begin + inset; column < run.end - inset; ++column) {
      const auto& pixel = bgr.at<cv::Vec3b>(run.row, column);
      const int brightest = std::max({pixel[0], pixel[1], pixel[2]});
      if (brightest < kDark || brightest >= kClipped) continue;
      const Rgb seen{static_cast<double>(pixel[2]), static_cast<double>(pixel[1]), static_cast<double>(pixel[0])};
      ++sample.pixels;
      sample.seen += seen;
      sample.expected += test_.expected(seen);
    }
  }
  sample.spread = spread_;
  if (sample.pixels > 0 && luma_of(sample.seen) > 0) sample.deviation = test_.deviation(sample.seen);
  return sample;
}

}  // namespace multireach::vision
