#include "vision/colour/illumination.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>

#include "numeric/random.hpp"
#include "tests/allocation_count.hpp"
#include "vision/colour/find.hpp"

namespace multireach::vision {
namespace {

/// Gains of the colour channels, exposure included.
struct Light {
  double red = 1, green = 1, blue = 1;
};

constexpr int kWidth = 160, kHeight = 120, kRadius = 18;

/// A picture of a shaded pink ball before a textured grey wall with a red, an orange and a purple disc.
cv::Mat scene(const Light& light, uint64_t frame) {
  const CounterRandom random(77, frame);
  cv::Mat image(kHeight, kWidth, CV_8UC3);
  uint64_t counter = 0;
  const double ball_x = 80 + 30 * std::sin(0.1 * static_cast<double>(frame)), ball_y = 60;
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      const auto inside = [&](double x, double y, double radius) { return std::hypot(column - x, row - y) < radius; };
      const double shade = 0.5 + 0.5 * std::clamp((ball_y - row) / kRadius, 0.0, 1.0);
      const double wall = 95 + 40 * (1 + std::sin(0.2 * column) * std::sin(0.3 * row));
      Rgb colour{1.02 * wall, wall, 0.95 * wall};
      if (inside(30, 25, 12)) colour = {230, 140, 40};
      if (inside(130, 25, 12)) colour = {110, 60, 150};
      if (inside(30, 95, 12)) colour = {200, 50, 40};
      if (inside(ball_x, ball_y, kRadius)) colour = {220 * shade, 40 * shade, 110 * shade};
      const auto pixel = [&](double value) {
        const double noise = 3 * std::sqrt(12.0) * (random.uniform(counter++) - 0.5);
        return static_cast<uint8_t>(std::clamp(value + noise + 0.5, 0.0, 255.0));
      };
      image.at<cv::Vec3b>(row, column) = {pixel(light.blue * colour.b), pixel(light.green * colour.g),
                                          pixel(light.red * colour.r)};
    }
  }
  return image;
}

struct Outcome {
  int lost = 0;             ///< frames in which the largest blob did not match the ball in position and area
  double most_members = 0;  ///< largest number of class pixels in a frame, relative to the ball's area
  WhiteBalanceGains shift;
};

Outcome track(const std::function<Light(int)>& light, int frames, bool adapting) {
  AdaptedColourModel lit(model_of({.references = {{220, 40, 110}}, .tolerance = 0.36}));
  BlobFinder finder;
  Outcome outcome;
  const double area = 3.14159 * kRadius * kRadius;
  for (int frame = 0; frame < frames; ++frame) {
    const cv::Mat image = scene(light(frame), static_cast<uint64_t>(frame));
    const FoundBlobs found = finder.find(image, {0, 0, kWidth, kHeight}, lit.members(outcome.shift));
    const double x = 80 + 30 * std::sin(0.1 * frame);
    const bool seen = !found.blobs.empty() && (found.blobs[0].centroid - Eigen::Vector2d(x, 60)).norm() < 2 &&
                      found.blobs[0].area > 0.8 * area && found.blobs[0].area < 1.1 * area;
    outcome.lost += seen ? 0 : 1;
    outcome.most_members = std::max(outcome.most_members, static_cast<double>(found.members) / area);
    if (!adapting) continue;
    outcome.shift = found.blobs.empty() ? relaxed(outcome.shift)
                                        : adapted(outcome.shift, lit.sample(outcome.shift, image, found.blobs[0]), 1);
  }
  return outcome;
}

TEST(Light, ExposureMayJump) {
  std::cout << "seed 77\n";
  const auto light = [](int frame) {
    const std::array<double, 6> exposures{1, 0.4, 2, 0.4, 1, 2};
    const double gain = exposures[static_cast<size_t>(frame / 10) % 6];
    return Light{gain, gain, gain};
  };
  for (const bool adapting : {false, true}) {
    const Outcome outcome = track(light, 60, adapting);
    EXPECT_EQ(outcome.lost, 0);
    EXPECT_LT(outcome.most_members, 1.1);
  }
}

TEST(Light, WhiteBalanceMayDriftBackAndForthWithinASecond) {
  std::cout << "seed 77\n";
  int lost_without = 0;
  for (const double red : {-0.25, 0.25}) {
    for (const double green : {-0.25, 0.25}) {
      for (const double blue : {-0.25, 0.25}) {
        const auto light = [&](int frame) {
          const double t = std::clamp(frame < 90 ? frame / 30.0 : (120 - frame) / 30.0, 0.0, 1.0);
          return Light{1 + red * t, 1 + green * t, 1 + blue * t};
        };
        const Outcome outcome = track(light, 150, true);
        EXPECT_EQ(outcome.lost, 0) << red << " " << green << " " << blue;
        EXPECT_LT(outcome.most_members, 1.15);
        EXPECT_NEAR(outcome.shift.red, 1, 0.05) << "back where it began";
        EXPECT_NEAR(outcome.shift.blue, 1, 0.05);
        lost_without += track(light, 150, false).lost;
      }
    }
  }
  EXPECT_GT(lost_without, 50) << "a light that needs no adapting tests nothing";
}

TEST(Light, FindsTheGainsOfTheCamera) {
  const Outcome outcome = track(
      [](int frame) {
        const double t = std::min(frame / 30.0, 1.0);
        return Light{1 + 0.25 * t, 1, 1 - 0.25 * t};
      },
      120, true);
  EXPECT_NEAR(outcome.shift.red, 1 / 1.25, 0.03);
  EXPECT_NEAR(outcome.shift.blue, 1 / 0.75, 0.05);
}

TEST(Light, AdaptsByLittleAndWithinBounds) {
  const IlluminationSample red{.pixels = 1000, .seen = {200, 100, 100}, .expected = {100, 100, 100}};
  WhiteBalanceGains shift;
  EXPECT_EQ(adapted(shift, red, 0), shift) << "not sure that it is the object";
  EXPECT_EQ(adapted(shift, {.pixels = 5, .seen = {2, 1, 1}, .expected = {1, 1, 1}}, 1), shift) << "too few pixels";
  EXPECT_EQ(adapted(shift, {.pixels = 500, .seen = {0, 1, 1}, .expected = {1, 1, 1}}, 1), shift) << "no red at all";
  EXPECT_NEAR(adapted(shift, red, 1).red, 0.95, 1e-12);
  EXPECT_GT(adapted(shift, red, 0.1).red, adapted(shift, red, 1).red);
  EXPECT_EQ(adapted(shift, red, 1).blue, 1);
  // Within the spread of the learned colours, beyond that of a plain one, at a tenth.
  const IlluminationSample small{.pixels = 1000, .seen = {110, 100, 100}, .expected = {100, 100, 100}};
  IlluminationSample spread = small;
  spread.spread = {.red = 0.3, .blue = 0.3};
  const double change = 1 - adapted({}, small, 1).red;
  EXPECT_GT(change, 0.01);
  EXPECT_NEAR(1 - adapted({}, spread, 1).red, change / 10, 1e-12);
  spread.seen.r = 200;
  EXPECT_NEAR(adapted({}, spread, 1).red, 0.95, 1e-12) << "far beyond the spread";
  const IlluminationSample far{.pixels = 1000, .seen = {900, 100, 10}, .expected = {100, 100, 100}};
  for (int i = 0; i < 1000; ++i) shift = adapted(shift, far, 1);
  EXPECT_EQ(shift, (WhiteBalanceGains{kMinGain, kMaxGain}));
  for (int i = 0; i < 1000; ++i) shift = relaxed(shift);
  EXPECT_NEAR(shift.red, 1, 1e-3);
  EXPECT_NEAR(shift.blue, 1, 1e-3);
}

TEST(Light, AnotherObjectDoesNotChangeTheGains) {
  // The disc's colour passes, but in the tails of the model: light that changes slowly is not the reason.
  AdaptedColourModel lit(model_of({.references = {{220, 40, 110}}, .tolerance = 0.36}));
  const auto disc = [&](const Rgb& colour) {
    cv::Mat image(kHeight, kWidth, CV_8UC3, cv::Scalar(120, 120, 120));
    for (int row = 0; row < kHeight; ++row) {
      for (int column = 0; column < kWidth; ++column) {
        if (std::hypot(column - 80, row - 60) < kRadius)
          image.at<cv::Vec3b>(row, column) =
              cv::Vec3b(cv::saturate_cast<uint8_t>(colour.b), cv::saturate_cast<uint8_t>(colour.g),
                        cv::saturate_cast<uint8_t>(colour.r));
      }
    }
    BlobFinder finder;
    const FoundBlobs found = finder.find(image, {0, 0, kWidth, kHeight}, lit.members({}));
    return found.blobs.empty() ? IlluminationSample{} : lit.sample({}, image, found.blobs[0]);
  };
  const IlluminationSample own = disc({220, 43, 110}), other = disc({206, 54, 124});
  ASSERT_GT(own.pixels, 30);
  ASSERT_GT(other.pixels, 30) << "the other object must pass";
  EXPECT_LT(own.deviation, 1);
  EXPECT_GT(other.deviation, 2);
  EXPECT_NE(adapted({}, own, 1), WhiteBalanceGains());
  EXPECT_EQ(adapted({}, other, 1), WhiteBalanceGains());
}

TEST(Light, AnObjectThatWasLearnedInSeveralLightsMayGoFromOneIntoAnother) {
  // A disc that becomes paler and back within two seconds, in colours that were all learned: the camera's white balance
  // is the same throughout. On real videos (docs/real-images.md) it was taken for another one, and the object was lost.
  std::cout << "seed 5\n";
  const Rgb deep{210, 40, 60}, pale{190, 110, 120};
  const Eigen::Vector2d mean = (chroma_of(deep) + chroma_of(pale)) / 2, half = (chroma_of(deep) - chroma_of(pale)) / 2;
  ColourModel model;
  model.object = {{mean, half * half.transpose() + 0.01 * Eigen::Matrix2d::Identity()}};
  model.tolerance = 2;
  AdaptedColourModel lit(model);
  const CounterRandom random(5);
  uint64_t counter = 0;
  WhiteBalanceGains gains;
  for (int frame = 0; frame < 120; ++frame) {
    const double share = 0.5 + 0.5 * std::cos(2 * 3.14159 * frame / 60);
    cv::Mat image(kHeight, kWidth, CV_8UC3, cv::Scalar(150, 120, 90));
    for (int row = 0; row < kHeight; ++row) {
      for (int column = 0; column < kWidth; ++column) {
        if (std::hypot(column - 80, row - 60) > kRadius) continue;
        const auto channel = [&](double a, double b) {
          return static_cast<uint8_t>(share * a + (1 - share) * b + random.uniform(counter++, -3, 3));
        };
        image.at<cv::Vec3b>(row, column) = {channel(deep.b, pale.b), channel(deep.g, pale.g), channel(deep.r, pale.r)};
      }
    }
    BlobFinder finder;
    const FoundBlobs found = finder.find(image, {0, 0, kWidth, kHeight}, lit.members(gains));
    ASSERT_EQ(found.blobs.size(), 1U) << frame;
    EXPECT_NEAR(found.blobs[0].area, 3.14159 * kRadius * kRadius, 60) << frame;
    gains = adapted(gains, lit.sample(gains, image, found.blobs[0]), 1);
    // Its R/G differs from the mean by a factor of 1.75, of which 1 + 0.55 - 0.12 counts as its own.
    EXPECT_NEAR(gains.red, 1, 0.25) << frame;
    EXPECT_NEAR(gains.blue, 1, 0.25) << frame;
  }
}

TEST(Light, TheAnswerDependsOnTheShiftAlone) {
  const ColourModel model = model_of({.references = {{220, 40, 110}}, .tolerance = 0.36});
  AdaptedColourModel walked(model), fresh(model);
  for (int i = 0; i <= 20; ++i) walked.members({1 + 0.013 * i, 1 - 0.011 * i});
  const WhiteBalanceGains last{1.26, 0.78};
  const ColourTable &a = walked.members(last), &b = fresh.members(last);
  int members = 0;
  for (int i = 0; i < 256 * 256 * 256; i += 7) {
    const auto blue = static_cast<uint8_t>(i), green = static_cast<uint8_t>(i >> 8),
               red = static_cast<uint8_t>(i >> 16);
    ASSERT_EQ(a.contains(blue, green, red), b.contains(blue, green, red));
    members += a.contains(blue, green, red) ? 1 : 0;
  }
  EXPECT_GT(members, 1000);
}

TEST(Light, AdaptingAllocatesNothing) {
  AdaptedColourModel lit(model_of({.references = {{220, 40, 110}}, .tolerance = 0.36}));
  BlobFinder finder;
  const cv::Mat image = scene({}, 0);
  const FoundBlobs found = finder.find(image, {0, 0, kWidth, kHeight}, lit.members({}));
  ASSERT_FALSE(found.blobs.empty());
  const testing::AllocationCount before = testing::allocations();
  for (int i = 0; i < 20; ++i) lit.sample({1 + 0.02 * i, 1}, image, found.blobs[0]);
  EXPECT_EQ(testing::allocations().number, before.number);
}

TEST(Light, GainsThatHideAPartOfTheObjectReturn) {
  WhiteBalanceGains gains{.red = 0.7, .blue = 1.4};
  for (int k = 0; k < 30; ++k) gains = returning(gains, 1);
  EXPECT_NEAR(gains.red, 1, 0.01);
  EXPECT_NEAR(gains.blue, 1, 0.01);
  const WhiteBalanceGains before{.red = 0.7, .blue = 1.4}, slowly = returning(before, 0.5),
                                                           not_at_all = returning(before, 0);
  EXPECT_LT(slowly.red, returning(before, 1).red) << "more slowly where it is less sure what is seen";
  EXPECT_EQ(not_at_all, before);
}

}  // namespace
}  // namespace multireach::vision
