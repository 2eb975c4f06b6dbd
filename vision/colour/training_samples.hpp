#pragma once

#include <span>
#include <vector>

#include "vision/colour/chroma_fit.hpp"
#include "vision/colour/learn_colour.hpp"

namespace multireach::vision {

/// A picture and the object's pixels in it, for trying a colour model with the blob finder.
struct Trial {
  /// The object, or one of several that look alike.
  struct Part {
    cv::Rect box;  ///< widened by half its size: beyond it are other things, not more of the object
    double area = 0;
  };
  cv::Mat bgr, mask;
  cv::Mat alike;            ///< more pixels of the object's colour, of other objects or of itself; may be empty
  std::vector<Part> parts;  ///< none where it is not in the picture
  double area = 0;          ///< of the object, pixels: the mean of the parts; 0 where it is not in the picture

  /// The area of the parts at a box; 0 at none.
  double area_at(const cv::Rect& box) const;
};

/// What pictures show of an object and of everything else.
struct TrainingSamples {
  LearnedColour::Status status = LearnedColour::Status::kLearned;  ///< or why a picture is of no use
  std::vector<ChromaSample> object, rest;
  std::vector<Trial> trials;  ///< of pictures in which the object's pixels are known, or in which it is not
};

/// The samples of each picture: the more pictures, the fewer of each.
std::vector<TrainingSamples> training_samples(std::span<const TrainingPicture> pictures);

/// The samples of all pictures together. Each picture has the same weight, however large the object is in it. In a
/// picture without the object, other things are compared with the smallest image of it.
TrainingSamples merged(std::vector<TrainingSamples> pictures);

bool is_clipped(const ChromaSample& sample);
/// Whether the sample is too dark for its chroma to be more than noise.
bool is_dark(const ChromaSample& sample);

/// The samples of the object whose colour is known; none where too many are overexposed.
std::vector<ChromaSample> coloured_samples(const std::vector<ChromaSample>& object);

}  // namespace multireach::vision
