#include "tools/calibrate/object_colour.hpp"

#include <fmt/format.h>

#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "vision/colour/colour_table.hpp"
#include "vision/colour/find.hpp"

namespace multireach {
namespace {

/// Why the finder does not find the object in the picture that its colour was learned from; empty when it does.
std::string finder_fault(const cv::Mat& bgr, const vision::ColourModel& model, const ObjectRegion& region) {
  vision::BlobFinder finder;
  const vision::FoundBlobs found = finder.find(bgr, {0, 0, bgr.cols, bgr.rows}, vision::ColourTable(model));
  if (found.too_many_runs) return "the learned colours are all over the picture";
  if (found.blobs.empty()) return "with the learned colours nothing is found, not even the object";
  const vision::Blob& largest = found.blobs[0];
  const cv::Point at(cvRound(largest.centroid.x()), cvRound(largest.centroid.y()));
  if (region.box.contains(at)) return {};
  return fmt::format("with the learned colours another object is found, at {},{}", at.x, at.y);
}

}  // namespace

ObjectColour learn_object(const cv::Mat& bgr, const ObjectRegion& region) {
  ObjectColour object{.colour = region.mask.empty() ? vision::learn_colour(bgr, region.box)
                                                    : vision::learn_colour_of(bgr, region.mask)};
  const vision::LearnedColour& colour = object.colour;
  if (colour.status != vision::LearnedColour::Status::kLearned) throw std::runtime_error(description(colour.status));
  constexpr double kFew = 0.8, kMuch = 0.01;
  if (colour.kept < kFew)
    object.warnings.push_back(fmt::format("only {:.0f} % of the object has the learned colours", 100 * colour.kept));
  if (colour.background > kMuch) {
    object.warnings.push_back(
        fmt::format("{:.1f} % of the background has the learned colours", 100 * colour.background));
  }
  if (colour.by_brightness)
    object.warnings.push_back("only brightness distinguishes the object; lock the camera's exposure");
  object.fault = finder_fault(bgr, colour.model, region);
  return object;
}

cv::Mat members_picture(const cv::Mat& bgr, const vision::ColourModel& model, const ObjectRegion& region) {
  const vision::ColourTable members(model);
  cv::Mat shown = bgr.clone();
  for (int row = 0; row < shown.rows; ++row) {
    for (int column = 0; column < shown.cols; ++column) {
      auto& p = shown.at<cv::Vec3b>(row, column);
      if (members.contains(p[0], p[1], p[2])) continue;
      const auto grey = static_cast<uint8_t>((p[0] + 2 * p[1] + p[2]) / 12);
      p = {grey, grey, grey};
    }
  }
  if (region.mask.empty()) {
    cv::rectangle(shown, region.box, {0, 255, 0});
  } else {
    std::vector<std::vector<cv::Point>> contours;
    cv::findContours(region.mask.clone(), contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
    cv::drawContours(shown, contours, -1, {0, 255, 0});
  }
  return shown;
}

}  // namespace multireach
