#pragma once

#include <string>
#include <vector>

#include "tools/calibrate/colour_region.hpp"
#include "vision/colour/learn_colour.hpp"

namespace multireach {

/// The colours of an object in one picture.
struct ObjectColour {
  vision::LearnedColour colour;
  std::vector<std::string> warnings{};  ///< sentences
  std::string fault{};  ///< why vision would not find the object by them in this picture; empty when it would
};

/// Learns the colours of the object in a region, or, where its mask is empty, in its box. Throws std::runtime_error
/// when they cannot be learned. Only the part `within` of the picture counts, where vision will look for the object:
/// what is outside may have its colours.
ObjectColour learn_object(const cv::Mat& bgr, const ObjectRegion& region, const cv::Rect& within);
ObjectColour learn_object(const cv::Mat& bgr, const ObjectRegion& region);

/// The picture, with pixels outside the colour class shown grey and dark, and the object's region drawn.
cv::Mat members_picture(const cv::Mat& bgr, const vision::ColourModel& model, const ObjectRegion& region);

}  // namespace multireach
