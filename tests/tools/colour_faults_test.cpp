// Why learned colours do not serve: an object that the border of its picture cuts off.
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "tools/calibrate/object_colour.hpp"

namespace multireach {
namespace {

const cv::Scalar kOrange(40, 110, 215);

/// Orange discs, blurred as by a lens, before a grey wall.
cv::Mat picture(const std::vector<cv::Point>& centres, const std::vector<int>& radii) {
  cv::Mat image(240, 320, CV_8UC3);
  cv::RNG(7).fill(image, cv::RNG::NORMAL, cv::Scalar(130, 132, 130), cv::Scalar(4, 4, 4));
  for (size_t k = 0; k < centres.size(); ++k) cv::circle(image, centres[k], radii[k], kOrange, cv::FILLED, cv::LINE_AA);
  cv::GaussianBlur(image, image, {0, 0}, 0.8);
  return image;
}

std::string fault_of(const cv::Mat& image, const cv::Rect& rectangle) {
  return learn_object({.bgr = image, .region = ObjectRegion{rectangle, {}}}).fault;
}

TEST(ColourFaults, AnObjectThatTheBorderCutsOffIsNotTheOneThatWouldBeTaken) {
  const std::vector<cv::Point> smaller{{180, 60}, {200, 180}};
  EXPECT_EQ(fault_of(picture({{60, 120}, smaller[0], smaller[1]}, {24, 13, 13}), {36, 96, 49, 49}), "")
      << "all of it is in the picture, and the others are smaller";
  const std::string fault = fault_of(picture({{2, 120}, smaller[0], smaller[1]}, {24, 13, 13}), {0, 96, 27, 49});
  EXPECT_EQ(fault.find("the border cuts off the object, and by the colours alone vision may take what is at "), 0U)
      << fault;
  EXPECT_EQ(fault_of(picture({{2, 120}}, {24}), {0, 96, 27, 49}), "") << "nothing else could be taken";
}

TEST(ColourFaults, AClickOnAHighlightShowsNotTheObject) {
  cv::Mat image = picture({{150, 120}}, {40});
  cv::Mat shine(image.size(), CV_8UC3, cv::Scalar::all(0));
  cv::circle(shine, {140, 105}, 9, cv::Scalar(110, 90, 35), cv::FILLED, cv::LINE_AA);
  cv::GaussianBlur(shine, shine, {0, 0}, 1.5);
  cv::add(image, shine, image);
  const auto learned = [&](const cv::Point& click) {
    return learn_object({.bgr = image, .region = region_around(image, click)});
  };
  EXPECT_EQ(learned({160, 135}).fault, "");
  const std::string fault = learned({140, 105}).fault;
  EXPECT_EQ(fault.find("what is around the outline of the click has the same colour"), 0U) << fault;
}

}  // namespace
}  // namespace multireach
