// Step 1 of the set-up course: both cameras are found, paired, sharp and well exposed.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tools/page/course_step.hpp"
#include "tools/page/job.hpp"

namespace multireach {
namespace {

constexpr int64_t kSecond = 1000000;
constexpr double kDark = 35, kBright = 215;  // grey levels, mean
constexpr double kMostClipped = 0.05;        // share of the pixels that are white
constexpr double kMostSkew = 0.010;          // s

/// One camera's image.
struct Look {
  int width = 0, height = 0;
  double mean = 0, clipped = 0, sharpness = 0;

  std::string fault(const char* side) const {
    if (width == 0) return fmt::format("the {} image is missing or cannot be decoded", side);
    if (mean < kDark) return fmt::format("the {} image is too dark: more light, or a longer exposure", side);
    if (mean > kBright || clipped > kMostClipped)
      return fmt::format("the {} image is overexposed: less light, or a shorter exposure", side);
    return "";
  }
};

Look look_at(const cv::Mat& bgr) {
  Look look;
  if (bgr.empty()) return look;
  look.width = bgr.cols;
  look.height = bgr.rows;
  cv::Mat grey, edges;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  look.mean = cv::mean(grey)[0];
  look.clipped = static_cast<double>(cv::countNonZero(grey >= 254)) / static_cast<double>(grey.total());
  cv::Laplacian(grey, edges, CV_32F);
  cv::Scalar mean, deviation;
  cv::meanStdDev(edges, mean, deviation);
  look.sharpness = deviation[0];
  return look;
}

class CamerasStep : public CourseStep {
 public:
  const char* name() const override { return "cameras"; }
  bool done() const override { return looked_ && fault().empty(); }
  void begin(CourseContext& context, const json&) override { context.show(practice_scene_t::EMPTY); }
  void again(CourseContext&) override {}

  void images(const std::shared_ptr<const images_t>& images, CourseContext& context) override {
    // Of the last second, by the clock here.
    arrivals_.push_back(context.now_us);
    heard_us_ = context.now_us;
    std::array<int64_t, 2> utimes{-1, -1};
    for (size_t i = 0; i < images->images.size() && i < images->image_types.size(); ++i)
      utimes[images->image_types[i] == images_t::RIGHT ? 1 : 0] = images->images[i].utime;
    if (utimes[0] >= 0 && utimes[1] >= 0) skew_s_ = 1e-6 * static_cast<double>(std::abs(utimes[1] - utimes[0]));
    if (job_.busy() || context.now_us - looked_us_ < kSecond / 2) return;
    looked_us_ = context.now_us;
    job_.start([images] {
      const auto pair = decoded_pair(*images);
      return std::array{look_at(pair[0]), look_at(pair[1])};
    });
  }

  void tick(CourseContext& context) override {
    if (const auto looks = job_.take()) {
      looks_ = *looks;
      looked_ = true;
    }
    std::erase_if(arrivals_, [&](int64_t at) { return at < context.now_us - 2 * kSecond; });
    silent_ = context.now_us - heard_us_ > 3 * kSecond;
  }

  std::string text() const override {
    if (!looked_ || silent_)
      return "No pair of images arrives. Are both cameras plugged in, and does multireach-camera run? NODE_STATUS "
             "below "
             "tells what it waits for.";
    const std::string why = fault();
    return why.empty()
               ? "Both cameras are there, paired, and well exposed. Turn each focus ring until its sharpness is "
                 "largest, then fix it: from now on neither camera nor lens may move against the other."
               : "Not yet: " + why + ".";
  }

  json details() const override {
    json sides = json::array();
    for (const Look& look : looks_) {
      sides.push_back({{"width", look.width},
                       {"height", look.height},
                       {"mean", std::round(look.mean)},
                       {"clipped", look.clipped},
                       {"sharpness", std::round(10 * look.sharpness) / 10}});
    }
    return {{"rate", static_cast<double>(arrivals_.size()) / 2}, {"skew_ms", 1e3 * skew_s_}, {"sides", sides}};
  }

 private:
  std::string fault() const {
    if (silent_) return "no images arrive";
    for (size_t side = 0; side < 2; ++side) {
      if (const std::string why = looks_[side].fault(side == 0 ? "left" : "right"); !why.empty()) return why;
    }
    if (looks_[0].width != looks_[1].width || looks_[0].height != looks_[1].height)
      return "the images differ in size: set both cameras to the same";
    if (skew_s_ > kMostSkew)
      return fmt::format("the images of a pair are {:.0f} ms apart: set both cameras to the same rate", 1e3 * skew_s_);
    return "";
  }

  std::vector<int64_t> arrivals_;
  int64_t heard_us_ = 0, looked_us_ = 0;
  double skew_s_ = 0;
  bool looked_ = false, silent_ = true;
  std::array<Look, 2> looks_{};
  Job<std::array<Look, 2>> job_;
};

}  // namespace

std::unique_ptr<CourseStep> cameras_step() {
  return std::make_unique<CamerasStep>();
}

}  // namespace multireach
