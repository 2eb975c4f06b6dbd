#include "vision/colour/light.hpp"

#include <algorithm>
#include <cmath>

namespace multireach::vision {
namespace {

constexpr int64_t kFewestPixels = 30;
constexpr int kDark = 16;       // grey levels: below, offsets of the camera are larger than what the light does
constexpr double kRate = 0.15;  // of the way, per frame: white balance that drifts by 50 % in a second is 7 % behind
constexpr double kLargestStep = 0.05;  // per frame: one wrong blob does little
constexpr double kRelaxation = 0.01;   // per frame: half of the way in two seconds at 30 Hz
constexpr double kQuantum = 1.0 / 64;

double towards(double gain, double wanted, double rate) {
  const double step = std::clamp(rate * (wanted - gain), -kLargestStep * gain, kLargestStep * gain);
  return std::clamp(gain + step, kSmallestGain, kLargestGain);
}

ColourShift rounded(const ColourShift& shift) {
  const auto whole = [](double gain) { return std::nearbyint(gain / kQuantum) * kQuantum; };
  return {whole(shift.red), whole(shift.blue)};
}

Rgb& operator+=(Rgb& sum, const Rgb& colour) {
  sum = {sum.r + colour.r, sum.g + colour.g, sum.b + colour.b};
  return sum;
}

}  // namespace

ColourShift adapted(const ColourShift& shift, const LightSample& sample, double quality) {
  const Rgb &seen = sample.seen, &expected = sample.expected;
  const bool usable = sample.pixels >= kFewestPixels && seen.r > 0 && seen.g > 0 && seen.b > 0 && expected.r > 0 &&
                      expected.g > 0 && expected.b > 0;
  if (!usable || !(quality > 0)) return shift;
  const double rate = kRate * std::min(quality, 1.0);
  return {towards(shift.red, expected.r * seen.g / (expected.g * seen.r), rate),
          towards(shift.blue, expected.b * seen.g / (expected.g * seen.b), rate)};
}

ColourShift relaxed(const ColourShift& shift) {
  return {towards(shift.red, 1, kRelaxation), towards(shift.blue, 1, kRelaxation)};
}

LitModel::LitModel(const ColourModel& model) : model_(model), test_(model, {}), members_(model) {}

void LitModel::prepare(const ColourShift& shift) {
  const ColourShift wanted = rounded(shift);
  if (wanted == shift_) return;
  shift_ = wanted;
  test_.set_shift(wanted);
  members_ = PixelClass(test_);
}

const PixelClass& LitModel::members(const ColourShift& shift) {
  prepare(shift);
  return members_;
}

LightSample LitModel::sample(const ColourShift& shift, const cv::Mat& bgr, const Blob& blob) {
  prepare(shift);
  LightSample sample;
  // The border mixes object and background over a pixel or two, JPEG over some more.
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
  return sample;
}

}  // namespace multireach::vision
