#pragma once

#include <opencv2/core.hpp>

#include "vision/colour/colour_model.hpp"

namespace multireach::vision {

/// A colour model learned from an image, with its classification rates on that image.
struct LearnedColour {
  enum class Status {
    kLearned,
    kBadImage,      ///< not an 8-bit BGR image
    kBadRectangle,  ///< fewer than 40 of its pixels are in the image
    kOverexposed,   ///< most of the object is overexposed, so that its colour is unknown
    kIndistinct,    ///< the rectangle's colours are as frequent elsewhere in the image
  };
  Status status = Status::kBadImage;
  ColourModel model;      ///< valid when kLearned
  double kept = 0;        ///< share of the object's pixels that the model contains; at least 0.8 is good
  double background = 0;  ///< share of the pixels outside that it contains; up to 0.01 is good; 0 if there are none
  bool by_brightness = false;  ///< chroma alone does not separate the object: the exposure must not change
};

/// The status as a sentence.
const char* description(LearnedColour::Status status);

/// Learns the colours of an object from one 8-bit BGR image. The object fills most of `rectangle`; its corners, and
/// spots and stripes on the object, may show other things. The rest of the image is background, except a margin around
/// the rectangle. Object colours are those that are more frequent in the rectangle than in the background.
LearnedColour learn_colour(const cv::Mat& bgr, const cv::Rect& rectangle);

/// The same for an object whose pixels are known: those that are not 0 in `mask`, 8-bit, of the image's size. The
/// background is what is more than a few pixels away from them. Of several models, it chooses the one that finds most
/// of the object, and least of anything else, in this image.
LearnedColour learn_colour_of(const cv::Mat& bgr, const cv::Mat& mask);

}  // namespace multireach::vision
