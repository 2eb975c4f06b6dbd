#pragma once

#include <opencv2/core.hpp>

#include "vision/colour/colour_model.hpp"

namespace multireach::vision {

/// A colour model learned from a picture, and how good it is there.
struct LearnedColour {
  enum class Status {
    kLearned,
    kBadImage,      ///< not an 8-bit BGR image
    kBadRectangle,  ///< fewer than 40 of its pixels are in the image
    kOverexposed,   ///< most of the rectangle is overexposed, so that its colour is not known
    kLikeTheRest,   ///< what is in the rectangle is as frequent elsewhere in the picture
  };
  Status status = Status::kBadImage;
  ColourModel model;      ///< meaningful when learned
  double kept = 0;        ///< share of the object's pixels that are members; at least 0.8 is good
  double background = 0;  ///< share of the pixels outside that are members; up to 0.01 is good, and 0 if there are none
  bool by_brightness = false;  ///< the chroma alone does not tell the object from the rest: exposure must stay as it is
};

/// A sentence for people.
const char* description(LearnedColour::Status status);

/// Learns the colours of an object from one 8-bit BGR image. The object fills most of `rectangle`; at its corners, and
/// in spots and stripes on the object, there may be other things. The rest of the image is what the object is not: of
/// what is in the rectangle, those colours are the object's that are more frequent there. A little around the rectangle
/// is left out.
LearnedColour learn_colour(const cv::Mat& bgr, const cv::Rect& rectangle);

}  // namespace multireach::vision
