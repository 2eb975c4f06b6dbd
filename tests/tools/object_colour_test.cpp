// Colours learned from the regions that clicks propose, on generated pictures of shaded balls.
#include "tools/calibrate/object_colour.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tests/tools/shaded_balls.hpp"
#include "vision/colour/find.hpp"

namespace multireach {
namespace {

/// A colour learned from a click at the middle of a ball.
ObjectColour learned(const cv::Mat& image, const Ball& ball) {
  return learn_object({.bgr = image, .region = region_around(image, ball.centre)});
}

TEST(ObjectColourOf, IsCutByColoursNearIt) {
  // A carpet of colours from skin nearly to the ball's red: the model ends there, but keeps most of the ball.
  const Ball ball{{150, 110}, 20, kRed};
  std::vector<Patch> carpet;
  const CounterRandom random(9);
  for (int k = 0; k < 192; ++k) {
    const auto n = static_cast<uint64_t>(k);
    const double t = random.uniform(2 * n, 0.15, 1), bright = random.uniform(2 * n + 1, 0.2, 1);
    const auto mixed = [&](double red, double skin) { return bright * (red + t * (skin - red)); };
    carpet.push_back(
        {{k % 16 * 20, k / 16 * 20, 20, 20}, {mixed(kRed.r, kSkin.r), mixed(kRed.g, kSkin.g), mixed(kRed.b, kSkin.b)}});
  }
  const ObjectColour object = learned(picture({ball}, carpet, 2), ball);
  EXPECT_EQ(object.fault, "");
  EXPECT_GT(object.colour.kept, 0.6);
  EXPECT_LT(object.colour.background, 0.01);
}

TEST(ObjectColourOf, IsNotWiderThanTheObjectNeeds) {
  // Nothing else in the picture has a colour: still a ball of a redder orange, which it does not show, is another one.
  const Ball orange{{150, 110}, 20, kOrange}, red{{150, 110}, 20, {215, 95, 40}};
  const ObjectColour object = learned(picture({orange}, {}, 3), orange);
  EXPECT_EQ(object.fault, "");
  EXPECT_GT(object.colour.kept, 0.9);
  vision::BlobFinder finder;
  const cv::Mat other = picture({red}, {}, 4);
  const auto found = finder.find(other, {0, 0, kWidth, kHeight}, vision::ColourTable(object.colour.model));
  EXPECT_TRUE(found.blobs.empty());
}

TEST(ObjectColourOf, IsNotCutUpByOthersOfTheSameColour) {
  const Ball ball{{60, 60}, 20, kOrange};
  const std::vector<Ball> alike{ball, {{160, 60}, 24, kOrange}, {{250, 60}, 18, kOrange}, {{100, 170}, 22, kOrange}};
  const ObjectColour object = learned(picture(alike, {}, 5), ball);
  EXPECT_GT(object.colour.kept, 0.8);
}

TEST(ObjectColourOf, IsRefusedWhereAnotherObjectPasses) {
  const Ball ball{{60, 110}, 20, kOrange};
  for (const double radius : {9.0, 19.0, 30.0}) {
    const cv::Mat image = picture({ball, {{220, 120}, radius, kOrange}}, {}, 6);
    const std::string fault = learned(image, ball).fault;
    if (radius < 10) {
      EXPECT_EQ(fault, "") << "a quarter of its area: the object stands out";
    } else {
      EXPECT_NE(fault.find("another object is found, at 2"), std::string::npos) << radius << ": " << fault;
    }
  }
}

TEST(ObjectColourOf, SaysWhereTheRestOfThePictureHasItsColours) {
  // A small ball, and a wall of its colours in every light: nothing of the ball is left that the wall has not.
  const Ball ball{{60, 60}, 12, kOrange};
  std::vector<Patch> wall;
  const CounterRandom random(11);
  for (int k = 0; k < 192; ++k) {
    const double bright = random.uniform(static_cast<uint64_t>(k), 0.2, 1.1);
    wall.push_back(
        {{160 + k % 16 * 10, k / 16 * 20, 10, 20}, {bright * kOrange.r, bright * kOrange.g, bright * kOrange.b}});
  }
  const ObjectColour object = learned(picture({ball}, wall, 8), ball);
  const size_t at = object.fault.find("; what is at ");
  ASSERT_NE(at, std::string::npos) << object.fault;
  EXPECT_GE(std::stoi(object.fault.substr(at + 13)), 160) << "the wall's first column";
}

TEST(ObjectColourOf, WhatIsBeyondTheSearchedPartMayHaveItsColours) {
  const Ball ball{{60, 110}, 20, kOrange}, near{{100, 60}, 18, kOrange}, beyond{{240, 110}, 24, kOrange};
  const cv::Rect searched(10, 20, 140, 160);
  const auto within = [&](const cv::Mat& image) {
    return learn_object({.bgr = image, .region = region_around(image, ball.centre), .within = searched});
  };
  const cv::Mat two = picture({ball, beyond}, {}, 12);
  EXPECT_NE(learned(two, ball).fault, "") << "the other ball has its colour";
  const ObjectColour object = within(two);
  EXPECT_EQ(object.fault, "");
  EXPECT_GT(object.colour.kept, 0.9);

  const std::string other = within(picture({ball, near, beyond}, {}, 13)).fault;
  const size_t at = other.find("another object is found, at ");
  ASSERT_NE(at, std::string::npos) << other;
  EXPECT_NEAR(std::stoi(other.substr(at + 28)), near.centre.x, 3) << "in the whole picture";
}

// At the left border as well, or where all that counts begins just beside it.
TEST(ObjectColourOf, VisionIsAskedAlsoAboutWhatIsAtTheBorder) {
  const Ball ball{{8, 110}, 24, kOrange}, small{{180, 60}, 16, kOrange};
  const std::string fault = learned(picture({ball, small}, {}, 15), ball).fault;
  EXPECT_NE(fault.find("vision would take what is at 1"), std::string::npos) << fault;
}

// Vision does not answer with what the border cuts off, so that a smaller object of the colour wins.
TEST(ObjectColourOf, IsRefusedWhereVisionWouldTakeSomethingElseForTheObject) {
  const Ball ball{{kWidth - 8, 110}, 24, kOrange}, small{{80, 60}, 16, kOrange};
  EXPECT_EQ(learned(picture({ball}, {}, 15), ball).fault, "");
  const cv::Mat two = picture({ball, small}, {}, 15);
  const auto is_named = [](const std::string& fault) {
    const size_t at = fault.find("vision would take what is at ");
    return at != std::string::npos && std::abs(std::stoi(fault.substr(at + 29)) - 80) <= 3;
  };
  EXPECT_PRED1(is_named, learned(two, ball).fault);

  const cv::Rect box(kWidth - 32, 86, 32, 48);
  const Ball beside{{kWidth - 52, 110}, 12, kOrange};
  const std::string fault =
      learn_object({.bgr = picture({ball, beside}, {}, 15), .region = ObjectRegion{box, {}}}).fault;
  EXPECT_NE(fault.find("vision would take what is at "), std::string::npos)
      << fault << ": what is beside a rectangle is not a part of the object";
}

TEST(ObjectColourOf, IsThatOfTheSameObjectInTheOtherPicture) {
  const Ball ball{{60, 110}, 20, kOrange}, other{{200, 110}, 20, {40, 90, 180}};
  const cv::Mat left = picture({ball, other}, {}, 16), right = picture({ball, other}, {}, 17);
  const ObjectColour object = learned(left, ball);
  EXPECT_GT(largest_share(std::array{ObjectPicture{right, region_around(right, ball.centre)}}, object.colour.model),
            0.8);
  EXPECT_LT(largest_share(std::array{ObjectPicture{right, region_around(right, other.centre)}}, object.colour.model),
            0.1);
}

TEST(ObjectColourOf, TakesTheTwoSidesOfAStripeForOneObject) {
  const Ball ball{{150, 110}, 24, kOrange};
  cv::Mat image = picture({ball}, {}, 7);
  cv::rectangle(image, {120, 106, 60, 9}, cv::Scalar(150, 152, 150), cv::FILLED);
  ObjectRegion region;
  region.mask = cv::Mat::zeros(image.size(), CV_8UC1);
  cv::circle(region.mask, ball.centre, static_cast<int>(ball.radius), cv::Scalar::all(255), cv::FILLED);
  cv::rectangle(region.mask, {120, 106, 60, 9}, cv::Scalar(0), cv::FILLED);
  region.box = cv::boundingRect(region.mask);
  EXPECT_EQ(learn_object({.bgr = image, .region = region}).fault, "");
}

// A white highlight, or a stripe, divides the object, and the click shows one side of it only.
TEST(ObjectColourOf, AsksForAClickOnWhatMayBeAPartOfTheObject) {
  const Ball ball{{150, 110}, 24, kOrange};
  const auto fault_and_warnings = [&](int stripe_at, const std::vector<Ball>& others) {
    std::vector<Ball> balls{ball};
    balls.insert(balls.end(), others.begin(), others.end());
    cv::Mat image = picture(balls, {}, 7);
    cv::rectangle(image, {stripe_at, 80, 9, 60}, cv::Scalar(235, 238, 236), cv::FILLED);
    ObjectRegion region;
    region.mask = cv::Mat::zeros(image.size(), CV_8UC1);
    cv::circle(region.mask, ball.centre, static_cast<int>(ball.radius), cv::Scalar::all(255), cv::FILLED);
    region.mask.colRange(0, stripe_at + 9) = 0;
    region.box = cv::boundingRect(region.mask);
    const ObjectColour object = learn_object({.bgr = image, .region = region});
    std::string all = object.fault;
    for (const std::string& warning : object.warnings) all += "\n" + warning;
    return all;
  };
  const std::string part = "if that is a part of the object, click there as well";
  const std::string equal = fault_and_warnings(146, {}), small = fault_and_warnings(134, {});
  EXPECT_NE(equal.find("another object is found, at 1"), std::string::npos) << equal;
  EXPECT_NE(equal.find(part), std::string::npos) << equal;
  EXPECT_NE(small.find("has its colours, too: " + part), std::string::npos) << small;
  const std::string far = fault_and_warnings(128, {{{300, 110}, 12, kOrange}});
  EXPECT_EQ(far.find(part), std::string::npos) << "a thing elsewhere is no part of it: " << far;
}

/// Area of what a model finds in an image around a place, pixels.
double found_at(const ObjectColour& object, const cv::Mat& image, const cv::Point& place) {
  vision::BlobFinder finder;
  const auto found = finder.find(image, {0, 0, kWidth, kHeight}, vision::ColourTable(object.colour.model));
  double area = 0;
  for (const vision::Blob& blob : found.blobs) area += blob.box.contains(place) ? blob.area : 0;
  return area;
}

ObjectPicture clicked(const cv::Mat& image, const Ball& ball, const std::string& name) {
  return {.bgr = image, .region = region_around(image, ball.centre), .name = name};
}

TEST(ObjectColourOf, SeveralPicturesIsThatOfAllTheirLights) {
  // The same ball in clear light, in haze, and, larger, in yellow light.
  const std::vector<Ball> balls{
      {{80, 110}, 20, kOrange}, {{150, 60}, 16, {205, 145, 95}}, {{220, 150}, 26, {200, 135, 15}}};
  std::vector<ObjectPicture> pictures;
  for (size_t k = 0; k < balls.size(); ++k)
    pictures.push_back(clicked(picture({balls[k]}, {}, 20 + k), balls[k], std::to_string(k)));
  const ObjectColour together = learn_object(pictures);
  EXPECT_EQ(together.fault, "");
  for (size_t k = 0; k < balls.size(); ++k) {
    const double area = 3.14159 * balls[k].radius * balls[k].radius;
    EXPECT_GT(together.colour.rates[k].kept, 0.8) << k;
    EXPECT_GT(found_at(together, pictures[k].bgr, balls[k].centre), 0.7 * area) << k;
    const size_t other = (k + 1) % balls.size();
    EXPECT_LT(found_at(learn_object(pictures[other]), pictures[k].bgr, balls[k].centre), 0.5 * area)
        << "learned in the light of " << other << " alone, that of " << k << " is another colour";
  }
}

TEST(ObjectColourOf, IsNotThatOfAPictureWithoutTheObject) {
  const Ball ball{{80, 110}, 20, kOrange};
  const cv::Point place(220, 110);
  const Patch box{{place.x - 30, place.y - 30, 60, 60}, {215, 105, 32}};
  const ObjectPicture with = clicked(picture({ball}, {}, 30), ball, "with");
  const ObjectPicture without{.bgr = picture({}, {box}, 31), .name = "without"};
  const double area = 3.14159 * ball.radius * ball.radius;
  EXPECT_GT(found_at(learn_object(with), without.bgr, place), 0.5 * area) << "a box of nearly its colour";
  const ObjectColour object = learn_object(std::array{with, without});
  EXPECT_EQ(object.fault, "");
  EXPECT_LT(found_at(object, without.bgr, place), 0.2 * area);
  EXPECT_GT(found_at(object, with.bgr, ball.centre), 0.5 * area);

  const ObjectPicture twin{.bgr = picture({{place, 20, kOrange}}, {}, 32), .name = "twin"};
  const ObjectColour refused = learn_object(std::array{with, twin});
  EXPECT_EQ(refused.faulty_picture, size_t{1});
  EXPECT_EQ(refused.fault.find("twin: with the learned colours something is found at 2"), 0U) << refused.fault;
}

TEST(ObjectColourOf, APictureWithoutItMustNotHaveIt) {
  // The same picture, and darker and brighter ones: what is learned becomes narrower, but still finds the ball there.
  const Ball ball{{80, 110}, 20, kOrange};
  const ObjectPicture with = clicked(picture({ball}, {}, 30), ball, "with");
  for (const double gain : {0.8, 1.0, 1.15}) {
    ObjectPicture without{.bgr = cv::Mat(), .name = "without"};
    with.bgr.convertTo(without.bgr, -1, gain);
    const ObjectColour object = learn_object(std::array{with, without});
    EXPECT_NE(object.fault, "") << gain;
  }
}

TEST(ObjectColourOf, APictureWithoutItCountsForItsSmallestImageToo) {
  // A dark disc of the balls' chroma: nothing beside the near ball, but as large as the far one.
  const Ball near{{110, 110}, 70, kOrange}, far{{60, 60}, 13, kOrange};
  const Ball dark{{220, 120}, 13, {0.2 * kOrange.r, 0.2 * kOrange.g, 0.2 * kOrange.b}};
  const std::vector<ObjectPicture> pictures{clicked(picture({near}, {}, 60), near, "near"),
                                            clicked(picture({far}, {}, 61), far, "far"),
                                            {.bgr = picture({dark}, {}, 62), .name = "without"}};
  EXPECT_EQ(learn_object(pictures).fault, "");
}

TEST(ObjectColourOf, SaysWhereVisionWouldNotKnowIt) {
  const Ball ball{{60, 110}, 20, kOrange}, smaller{{220, 120}, 12, kOrange};
  const ObjectColour object = learned(picture({ball, smaller}, {}, 70), ball);
  EXPECT_EQ(object.fault, "") << "the other is a third as large";
  ASSERT_EQ(object.warnings.size(), 1U);
  EXPECT_NE(object.warnings[0].find("vision may take what is at 2"), std::string::npos) << object.warnings[0];
  EXPECT_TRUE(learned(picture({ball}, {}, 71), ball).warnings.empty());
}

TEST(ObjectColourOf, SaysWhereVisionWouldTakeWhatIsBetweenTwoClicks) {
  const Ball between{{160, 120}, 10, kOrange};
  const cv::Mat image = picture({between}, {{{30, 75, 80, 7}, kOrange}, {{210, 160, 80, 7}, kOrange}}, 72);
  const ObjectColour object =
      learn_object({.bgr = image, .region = region_around(image, std::vector<cv::Point>{{70, 78}, {250, 163}})});
  EXPECT_EQ(object.fault, "");
  EXPECT_TRUE(std::ranges::any_of(object.warnings, [](const std::string& warning) {
    return warning.find("by the colours alone vision would take what is at 1") != std::string::npos;
  }));
}

TEST(ObjectColourOf, SeveralPicturesIsRefusedWithTheNameOfTheFaultyOne) {
  const Ball ball{{60, 110}, 20, kOrange};
  const std::vector<ObjectPicture> pictures{
      clicked(picture({ball}, {}, 40), ball, "good.png"),
      clicked(picture({ball, {{220, 120}, 30, kOrange}}, {}, 41), ball, "bad.png")};
  const ObjectColour object = learn_object(pictures);
  EXPECT_EQ(object.faulty_picture, size_t{1});
  EXPECT_EQ(object.fault.find("bad.png: with the learned colours another object is found"), 0U) << object.fault;
  EXPECT_EQ(faulty_alone(pictures), std::vector<size_t>{1});
}

TEST(ObjectColourOf, IsNotCutForDarkThingsOfItsColour) {
  // A pale orange ball, a brown door and a cushion: of nearly its chroma, but much darker (as on a tuning video of
  // docs/real-images.md). A limit of brightness leaves more of the ball than a narrower chroma.
  const Ball ball{{80, 110}, 11, {149, 87, 46}};
  const Patch door{{200, 0, 120, 240}, {57, 41, 25}}, cushion{{0, 0, 60, 60}, {31, 16, 9}};
  const ObjectColour object = learned(picture({ball}, {door, cushion}, 80), ball);
  EXPECT_EQ(object.fault, "");
  EXPECT_GT(object.colour.kept, 0.9);
}

TEST(ObjectColourOf, SeveralThatLookAlikeIsLearnedFromAClickOnEach) {
  const std::vector<Ball> balls{{{60, 60}, 20, kOrange}, {{160, 120}, 22, kOrange}, {{250, 170}, 20, kOrange}};
  const cv::Mat image = picture(balls, {}, 81);
  std::vector<cv::Point> clicks;
  for (const Ball& ball : balls) clicks.push_back(ball.centre);
  EXPECT_NE(learn_object({.bgr = image, .region = region_around(image, balls[0].centre)}).fault, "");
  const ObjectColour each = learn_object({.bgr = image, .region = region_around(image, clicks)});
  EXPECT_EQ(each.fault, "");
  EXPECT_TRUE(each.warnings.empty()) << each.warnings[0] << ": that they are alike is no news";
  // Of one that moves fast a click may show no more than the middle.
  ObjectRegion region{{}, cv::Mat::zeros(image.size(), CV_8UC1)};
  for (const Ball& ball : balls) cv::circle(region.mask, ball.centre, ball.radius == 22 ? 13 : 20, 255, cv::FILLED);
  region.box = cv::boundingRect(region.mask);
  EXPECT_EQ(learn_object({.bgr = image, .region = region}).fault, "");
}

TEST(ObjectColourOf, SeveralThatLookAlikeIsNotThatOfAThingBetweenThem) {
  // A yellow cloth between two orange balls, within the box around both.
  const std::vector<Ball> balls{{{50, 60}, 18, kOrange}, {{270, 180}, 18, kOrange}};
  const cv::Mat image = picture(balls, {{{110, 70, 100, 100}, {205, 125, 60}}}, 85);
  const ObjectColour object =
      learn_object({.bgr = image, .region = region_around(image, {balls[0].centre, balls[1].centre})});
  EXPECT_EQ(object.fault, "");
  EXPECT_LT(found_at(object, image, {160, 120}), 100);
  for (const Ball& ball : balls) EXPECT_GT(found_at(object, image, ball.centre), 500);
}

TEST(ObjectColourOf, SaysThatASmallThingThatWasClickedIsNotLearned) {
  const std::vector<Ball> balls{{{90, 120}, 50, kRed}, {{250, 100}, 10, {60, 150, 70}}};
  const cv::Mat image = picture(balls, {}, 86);
  const ObjectColour object =
      learn_object({.bgr = image, .region = region_around(image, {balls[0].centre, balls[1].centre})});
  ASSERT_FALSE(object.warnings.empty());
  EXPECT_EQ(object.warnings[0].find("what was clicked at 2"), 0U) << object.warnings[0];
}

TEST(ObjectColourOf, SeveralPicturesSaysWithoutWhichTheOthersPass) {
  const Ball ball{{60, 110}, 20, kOrange};
  const Ball twin{{220, 120}, 30, kOrange};
  const std::vector<ObjectPicture> pictures{clicked(picture({ball}, {}, 82), ball, "good.png"),
                                            clicked(picture({ball, twin}, {}, 83), ball, "twin.png"),
                                            clicked(picture({ball}, {}, 84), ball, "also good.png")};
  EXPECT_NE(learn_object(pictures).fault, "");
  EXPECT_EQ(faulty_among(pictures), size_t{1});
  EXPECT_FALSE(faulty_among(std::span(pictures).first(2)).has_value()) << "one picture is not several";
}

TEST(ObjectColourOf, PicturesThatAgreeIsLearnedWithoutTheOthers) {
  const Ball ball{{60, 110}, 20, kOrange}, twin{{220, 120}, 30, kOrange}, grey{{60, 110}, 20, {150, 152, 150}};
  const ObjectPicture without{.bgr = picture({}, {}, 90), .name = "without.png"};
  const ObjectPicture good = clicked(picture({ball}, {}, 87), ball, "good.png");
  EXPECT_TRUE(learn_agreeing(std::vector{good, without}).left_out.empty());
  // Vision does not choose between the ball and the twin.
  const std::vector<ObjectPicture> one{without, clicked(picture({ball, twin}, {}, 88), ball, "twin.png"), good};
  const AgreeingPictures agreeing = learn_agreeing(one);
  EXPECT_EQ(agreeing.left_out, std::vector<size_t>{1});
  EXPECT_EQ(agreeing.object.fault, "");
  EXPECT_EQ(agreeing.doubt, "");
  // In another light the ball does not have its colours, so that vision takes the twin.
  const std::vector<ObjectPicture> other{good, clicked(picture({grey, twin}, {}, 88), grey, "grey.png")};
  const AgreeingPictures misled = learn_agreeing(other);
  EXPECT_EQ(misled.left_out, std::vector<size_t>{1});
  EXPECT_EQ(misled.object.fault, "");
  EXPECT_EQ(misled.doubt.find("by their colours vision would take what is at "), 0U) << misled.doubt;
}

TEST(ObjectColourOf, PicturesThatAgreeAreDoubtedWhereVisionWouldNotFindTheObjectInAnother) {
  const Ball ball{{60, 110}, 20, kOrange}, grey{{60, 110}, 20, {150, 152, 150}};
  const std::vector<ObjectPicture> pictures{clicked(picture({ball}, {}, 87), ball, "good.png"),
                                            clicked(picture({ball}, {}, 89), ball, "also good.png"),
                                            clicked(picture({grey}, {}, 88), grey, "grey.png")};
  const AgreeingPictures agreeing = learn_agreeing(pictures);
  ASSERT_EQ(agreeing.left_out, std::vector<size_t>{2});
  EXPECT_EQ(agreeing.doubt.find("by their colours vision would not find the object in grey.png"), 0U) << agreeing.doubt;
}

TEST(ObjectColourOf, PicturesWithoutTheObjectAreNotLeftOut) {
  const Ball ball{{60, 110}, 20, kOrange};
  const std::vector<ObjectPicture> pictures{clicked(picture({ball}, {}, 82), ball, "good.png"),
                                            clicked(picture({ball}, {}, 84), ball, "also good.png"),
                                            {.bgr = picture({ball}, {}, 85), .name = "with.png"}};
  EXPECT_NE(learn_object(pictures).fault, "");
  EXPECT_FALSE(faulty_among(pictures).has_value());
  EXPECT_NE(learn_agreeing(pictures).object.fault, "");
}

TEST(ObjectColourOf, PicturesThatAgreeIsDoubtedWhereTheyAreFew) {
  const Ball ball{{60, 110}, 20, kOrange}, twin{{220, 120}, 30, kOrange};
  const std::vector<ObjectPicture> pictures{clicked(picture({ball}, {}, 87), ball, "good.png"),
                                            clicked(picture({ball, twin}, {}, 88), ball, "bad.png"),
                                            clicked(picture({ball, twin}, {}, 89), ball, "also bad.png"),
                                            {.bgr = picture({}, {}, 90), .name = "without.png"}};
  const AgreeingPictures agreeing = learn_agreeing(pictures);
  EXPECT_EQ(agreeing.left_out, (std::vector<size_t>{1, 2}));
  EXPECT_EQ(agreeing.object.fault, "");
  EXPECT_EQ(agreeing.doubt, "most pictures of the object are refused even alone") << "the fourth does not have it";
}

}  // namespace
}  // namespace multireach
