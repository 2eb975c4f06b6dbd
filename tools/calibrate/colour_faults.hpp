#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/calibrate/colour_region.hpp"
#include "vision/colour/colour_model.hpp"
#include "vision/colour/colour_table.hpp"
#include "vision/matching/target_match.hpp"

namespace multireach {

// Why learned colours do not serve to find an object in a picture, by what the finder, and vision, find there. All
// positions in the sentences are in the picture.

/// The part of a picture that counts, with what it shows of the object.
struct PicturePart {
  cv::Mat bgr;
  std::optional<ObjectRegion> region;
  cv::Point corner;             ///< in the picture
  std::vector<cv::Rect> boxes;  ///< around the parts of the region: each object that was clicked, or each patch of one
};

/// `region`: of the picture; nothing where it does not have the object. `within`: inside the picture.
PicturePart part_of(const cv::Mat& bgr, const std::optional<ObjectRegion>& region, const cv::Rect& within);

/// Pixels.
double area_of(const ObjectRegion& region);

using FoundByVision = std::optional<vision::TargetMatch>;

/// What vision, knowing only the colours, finds in a picture where the other camera sees just the same, as of things
/// half a metre away: its optical axis passes to the right of the middle. Nothing of a picture that is too small.
FoundByVision found_by_vision(const PicturePart& part, const vision::ColourModel& model);

/// Why the colours do not serve to find the object in a picture that has it, as a clause; empty when they do.
/// `found`: by vision.
std::string fault_of(const FoundByVision& found, const PicturePart& part, const vision::ColourModel& model);

/// What is doubtful about colours that serve, as clauses.
std::vector<std::string> doubts_of(const FoundByVision& found, const PicturePart& part,
                                   const vision::ColourModel& model);

/// Why the finder finds something in a picture without the object, which has `area` pixels elsewhere, as a clause;
/// empty when it does not.
std::string fault_without_object(const PicturePart& part, const vision::ColourModel& model, double area);

/// Why vision would not find the object by the colours in a picture that they were not learned from, as a clause; empty
/// where it would, where the object is one of several that it would not choose from, or where something is cut off by
/// the border. `name`: of the picture.
std::string not_found(const PicturePart& part, const std::string& name, const vision::ColourModel& model);

/// Adds the number of the region's pixels in a box, and of those of them that have the learned colours.
void count_learned(const PicturePart& part, const cv::Rect& box, const vision::ColourTable& members, int& pixels,
                   int& learned);

}  // namespace multireach
