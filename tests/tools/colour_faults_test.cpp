// Why learned colours do not serve: an object that the border of its picture cuts off, a click on a highlight; and what
// may be taken for the object when it is occluded.
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "tools/calibrate/colour_faults.hpp"
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
  EXPECT_EQ(fault_of(picture({{29, 120}, smaller[0], smaller[1]}, {24, 18, 18}), {0, 90, 56, 60}), "")
      << "the rectangle reaches the border, but not the object";
}

TEST(ColourFaults, WhatIsNearAnObjectThatTheBorderCutsOffIsNotTheObject) {
  const cv::Mat image = picture({{-20, 120}, {70, 80}}, {60, 14});
  cv::Mat mask(image.size(), CV_8UC1, cv::Scalar(0));
  cv::circle(mask, {-20, 120}, 60, cv::Scalar(255), cv::FILLED);
  const PicturePart part = part_of(image, ObjectRegion{cv::boundingRect(mask), mask}, {{}, image.size()});
  const vision::ColourModel model = vision::model_of({.references = {{215, 110, 40}}, .tolerance = 0.5});
  const std::string fault = fault_of(found_by_vision(part, model), part, model);
  EXPECT_EQ(fault.find("the border cuts off the object, and by the colours alone vision may take what is at 70,80"), 0U)
      << fault;
}

TEST(ColourFaults, WhatVisionWouldTakeForAHiddenObjectIsAWarning) {
  const cv::Rect rectangle(36, 96, 49, 49);
  const auto warnings = [&](const std::vector<cv::Point>& others, const std::vector<int>& radii) {
    std::vector<cv::Point> centres{{60, 120}};
    std::vector<int> all{24};
    centres.insert(centres.end(), others.begin(), others.end());
    all.insert(all.end(), radii.begin(), radii.end());
    const ObjectColour learned =
        learn_object({.bgr = picture(centres, all), .region = ObjectRegion{rectangle, {}}, .name = "ball.png"});
    EXPECT_EQ(learned.fault, "");
    return learned.warnings;
  };
  const std::vector<std::string> smaller = warnings({{200, 180}}, {6});
  ASSERT_EQ(smaller.size(), 1U);
  EXPECT_EQ(
      smaller[0].find("ball.png: when the object is occluded or out of view, vision may take what is at 200,180 "), 0U)
      << smaller[0];
  EXPECT_EQ(warnings({}, {}), std::vector<std::string>()) << "nothing else has its colours";
  EXPECT_EQ(warnings({{200, 180}}, {2}), std::vector<std::string>()) << "too small for a first match";
  EXPECT_EQ(warnings({{180, 60}, {200, 180}}, {6, 6}), std::vector<std::string>()) << "it would be ambiguous";
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

TEST(ColourFaults, ADarkerWallOfTheBallsHueIsNoBallAroundAHighlight) {
  struct Case {
    cv::Scalar ball, wall;  // BGR
  };
  // Orange and brown, yellow and olive, green and grey-green.
  for (const Case& each : {Case{{40, 120, 225}, {62, 84, 110}}, Case{{40, 200, 225}, {70, 118, 120}},
                           Case{{60, 170, 60}, {88, 112, 88}}}) {
    cv::Mat image(240, 320, CV_8UC3);
    cv::RNG(7).fill(image, cv::RNG::NORMAL, each.wall, cv::Scalar(4, 4, 4));
    cv::circle(image, {150, 120}, 40, each.ball, cv::FILLED, cv::LINE_AA);
    cv::GaussianBlur(image, image, {0, 0}, 0.8);
    EXPECT_EQ(learn_object({.bgr = image, .region = region_around(image, {150, 120})}).fault, "") << each.wall;
  }
}

}  // namespace
}  // namespace multireach
