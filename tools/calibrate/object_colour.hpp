#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tools/calibrate/colour_region.hpp"
#include "vision/colour/learn_colour.hpp"

namespace multireach {

/// A picture of an object, or of the same scene without it.
struct ObjectPicture {
  cv::Mat bgr;                           ///< 8-bit
  std::optional<ObjectRegion> region{};  ///< where the object is; where its mask is empty, it fills most of the box
  /// The part that counts, inside the picture, where vision will look for the object: what is outside may have its
  /// colours. Nothing: all of it.
  std::optional<cv::Rect> within{};
  std::string name{};  ///< of its file: sentences about this picture begin with it
};

/// The colours of an object in pictures of it.
struct ObjectColour {
  vision::LearnedColour colour;
  std::vector<std::string> warnings{};  ///< sentences
  /// Why the colours cannot be learned, or why vision would not find the object by them in one of the pictures, or
  /// would find something else; empty when it would find the object in all pictures that have it.
  std::string fault{};
  std::optional<size_t> faulty_picture{};  ///< number of the picture that the fault is about; nothing: all of them
};

/// Learns the colours of an object. At least one picture must have it.
ObjectColour learn_object(std::span<const ObjectPicture> pictures);
ObjectColour learn_object(const ObjectPicture& picture);

/// The numbers of the pictures that have the object, but from which alone it is not learned without a fault: a click
/// beside the object, or another thing of its colours, spoils what is learned from all.
std::vector<size_t> faulty_alone(std::span<const ObjectPicture> pictures);

/// The number of the picture of the object without which the others are learned without a fault; of several, the one
/// without which the colours contain most of the object. Nothing if there is none, or fewer than three pictures.
std::optional<size_t> faulty_among(std::span<const ObjectPicture> pictures);

/// The colours of an object from those of several pictures that agree.
struct AgreeingPictures {
  ObjectColour object;             ///< its `faulty_picture` is a number of all pictures
  std::vector<size_t> left_out{};  ///< numbers of the pictures that it is not learned from, in their order
  /// Why these colours are not to be relied on, as a clause; empty where they are. Most pictures of the object are
  /// refused even alone, or vision would not find it by these colours in one that is left out.
  std::string doubt{};
};

/// Leaves out what faulty_alone() and then, one after another, what faulty_among() tells, or the picture that a fault
/// is about where it tells nothing or more than six are left, until the others are learned without a fault or one
/// picture of the object is left.
AgreeingPictures learn_agreeing(std::span<const ObjectPicture> pictures);

/// The largest share, over the pictures of an object, of its pixels that these colours contain, as those that the other
/// camera shows: where it is small, something else was clicked.
double largest_share(std::span<const ObjectPicture> pictures, const vision::ColourModel& model);

/// The picture, with pixels outside the colour class shown grey and dark, and the object's region, if any, drawn.
cv::Mat members_picture(const ObjectPicture& picture, const vision::ColourModel& model);

}  // namespace multireach
