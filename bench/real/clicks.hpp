#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "vision/colour/colour_model.hpp"

namespace multireach::bench {

/// The clicks on an object, or on all that look alike, in an image, of which only a part may count.
struct Click {
  cv::Mat image;
  std::vector<cv::Point> at;
  std::optional<cv::Rect> within{};
};

/// A colour learned from clicks as `calibrate colour` learns it, or why that refuses it.
struct Clicked {
  std::optional<vision::ColourModel> model;
  std::string fault;
  std::vector<std::string> warnings;
  std::vector<size_t> used;  ///< numbers of the clicks
};

/// Learns one colour from all clicks. As the documentation says, pictures that `calibrate colour` names are left out
/// while there are others, but where it then doubts the colours, the object is refused.
Clicked learn_clicks(const std::vector<Click>& clicks);

}  // namespace multireach::bench
