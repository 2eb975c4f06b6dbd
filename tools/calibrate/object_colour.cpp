#include "tools/calibrate/object_colour.hpp"

#include <fmt/format.h>

#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "vision/colour/colour_table.hpp"
#include "vision/colour/find.hpp"

namespace multireach {
namespace {

constexpr double kFewest = 0.25;  // least share of the region's area that the finder must find
constexpr double kSimilar = 0.7;  // another object of this share of the object's area passes as the object

/// How many of a blob's pixels are in a region's mask, or box.
double area_inside(const vision::Blob& blob, const ObjectRegion& region) {
  double area = 0;
  for (const vision::Run& run : blob.runs) {
    if (region.mask.empty()) {
      area += (cv::Rect(run.begin, run.row, run.end - run.begin, 1) & region.box).area();
    } else {
      area += cv::countNonZero(region.mask.row(run.row).colRange(run.begin, run.end));
    }
  }
  return area;
}

/// "X,Y" in the picture.
std::string position_of(const vision::Blob& blob, const cv::Point& corner) {
  return fmt::format("{},{}", cvRound(blob.centroid.x()) + corner.x, cvRound(blob.centroid.y()) + corner.y);
}

/// Where something else has the object's colours, which learning from the whole picture leaves out, as the end of a
/// sentence; empty where nothing large has. `bgr` begins at `corner` of the picture.
std::string others_like_it(const cv::Mat& bgr, const ObjectRegion& region, const cv::Point& corner) {
  const int margin = std::max(region.box.width, region.box.height) / 2;
  const cv::Rect near =
      (region.box + cv::Size(2 * margin, 2 * margin) - cv::Point(margin, margin)) & cv::Rect(0, 0, bgr.cols, bgr.rows);
  const vision::LearnedColour alone = region.mask.empty() ? vision::learn_colour(bgr(near), region.box - near.tl())
                                                          : vision::learn_colour_of(bgr(near), region.mask(near));
  if (alone.status != vision::LearnedColour::Status::kLearned) return {};
  vision::BlobFinder finder;
  const vision::FoundBlobs found = finder.find(bgr, {0, 0, bgr.cols, bgr.rows}, vision::ColourTable(alone.model));
  const vision::Blob* largest = nullptr;
  for (const vision::Blob& blob : found.blobs) {
    if (area_inside(blob, region) > 0.1 * blob.area) continue;
    if (!largest || blob.area > largest->area) largest = &blob;
  }
  if (!largest) return {};
  return fmt::format(
      "; other objects have the same colours, e.g. at {}: take a picture without them, or set search_region_m in "
      "vision.yaml and give --within-left and --within-right",
      position_of(*largest, corner));
}

/// Why the finder does not find the object in the picture that its colour was learned from; empty when it does.
std::string finder_fault(const cv::Mat& bgr, const vision::ColourModel& model, const ObjectRegion& region,
                         const cv::Point& corner) {
  vision::BlobFinder finder;
  const vision::FoundBlobs found = finder.find(bgr, {0, 0, bgr.cols, bgr.rows}, vision::ColourTable(model));
  if (found.too_many_runs) return "the learned colours are all over the picture";
  if (found.blobs.empty())
    return "with the learned colours nothing is found, not even the object" + others_like_it(bgr, region, corner);
  const vision::Blob* object = nullptr;
  double inside = 0;
  double all_inside = 0;  // also of the object's other parts, as beside a stripe
  for (const vision::Blob& blob : found.blobs) {
    const double area = area_inside(blob, region);
    all_inside += area;
    if (area <= inside) continue;
    inside = area;
    object = &blob;
  }
  if (!object) {
    return fmt::format("with the learned colours another object is found, at {}, and not this one",
                       position_of(found.blobs[0], corner));
  }
  if (inside < 0.5 * object->area) {
    return "with the learned colours the object is found together with much of what is around it";
  }
  for (const vision::Blob& blob : found.blobs) {
    if (blob.area < kSimilar * object->area || area_inside(blob, region) > 0.5 * blob.area) continue;
    return fmt::format("with the learned colours another object is found, at {}, {:.0f} % as large as this one",
                       position_of(blob, corner), 100 * blob.area / object->area);
  }
  const double whole = region.mask.empty() ? region.box.area() : cv::countNonZero(region.mask);
  if (all_inside < kFewest * whole)
    return fmt::format("only {:.0f} % of the object is found with the learned colours", 100 * all_inside / whole) +
           others_like_it(bgr, region, corner);
  return {};
}

}  // namespace

ObjectColour learn_object(const cv::Mat& picture, const ObjectRegion& in_picture, const cv::Rect& within) {
  const cv::Mat bgr = picture(within);
  const ObjectRegion region{(in_picture.box & within) - within.tl(),
                            in_picture.mask.empty() ? cv::Mat() : in_picture.mask(within)};
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
  object.fault = finder_fault(bgr, colour.model, region, within.tl());
  return object;
}

ObjectColour learn_object(const cv::Mat& bgr, const ObjectRegion& region) {
  return learn_object(bgr, region, {0, 0, bgr.cols, bgr.rows});
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
