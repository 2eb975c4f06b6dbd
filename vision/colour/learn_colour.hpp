#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "vision/colour/colour_model.hpp"

namespace multireach::vision {

/// A picture to learn an object's colours from.
struct TrainingPicture {
  cv::Mat bgr;             ///< 8-bit
  bool has_object = true;  ///< false: nothing in it is the object, and nothing may have its colours
  cv::Rect rectangle{};    ///< the object fills most of it; its corners, and spots and stripes, may show other things
  cv::Mat mask{};          ///< where its pixels are known: 8-bit, of the picture's size, not 0 for them
};

/// A colour model learned from pictures, with its classification rates on them.
struct LearnedColour {
  enum class Status {
    kLearned,
    kBadImage,     ///< a picture, or a mask, is not as TrainingPicture says
    kNoObject,     ///< no picture has the object
    kTooSmall,     ///< fewer than 40 pixels of the rectangle or the mask are in the picture
    kOverexposed,  ///< most of the object is overexposed, so that its colour is unknown
    kIndistinct,   ///< the rectangle's colours are as frequent elsewhere in the image
  };
  /// Shares of pixels that the model contains.
  struct Rates {
    double kept = 0;        ///< of the object's; 0 in a picture without it
    double background = 0;  ///< of the others
  };
  Status status = Status::kBadImage;
  std::optional<size_t> picture{};  ///< number of the picture that the status is about; nothing: all of them
  ColourModel model;                ///< valid when kLearned
  double kept = 0;                  ///< share of the object's pixels that the model contains; at least 0.8 is good
  double background = 0;  ///< share of the pixels outside that it contains; up to 0.01 is good; 0 if there are none
  std::vector<Rates> rates{};  ///< of each picture
  bool by_brightness = false;  ///< chroma alone does not separate the object: the exposure must not change
};

/// The status as a sentence.
const char* description(LearnedColour::Status status);

/// Learns the colours of an object from pictures of it: all of them count the same. Where its pixels are known, the
/// background is what is more than a few pixels away from them, but not other objects that look the same; of several
/// models, it chooses the one that finds most of the object, and least of anything else, in these pictures. In a
/// rectangle, object colours are those that are more frequent there than in the rest of the picture, of which a margin
/// around the rectangle does not count. At least one picture must have the object.
LearnedColour learn_colour(std::span<const TrainingPicture> pictures);

/// The same from one picture, by a rectangle, or by a mask.
LearnedColour learn_colour(const cv::Mat& bgr, const cv::Rect& rectangle);
LearnedColour learn_colour_of(const cv::Mat& bgr, const cv::Mat& mask);

}  // namespace multireach::vision
