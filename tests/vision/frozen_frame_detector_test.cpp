#include "vision/track/frozen_frame_detector.hpp"

#include <gtest/gtest.h>

namespace multireach::vision {
namespace {

TEST(FrozenFrameDetector, TellsTheCameraThatStandsStill) {
  FrozenFrameDetector detector;
  for (int k = 0; k < 10; ++k) detector.update(100 + k, 200 + k);
  EXPECT_FALSE(detector.repeats());
  for (int k = 10; k < 20; ++k) detector.update(100 + k, 209);
  EXPECT_EQ(detector.repeats(), Side::kRight);
  detector.update(120, 220);
  EXPECT_FALSE(detector.repeats()) << "goes on";
  for (int k = 21; k < 31; ++k) detector.update(120, 200 + k);
  EXPECT_EQ(detector.repeats(), Side::kLeft);
}

TEST(FrozenFrameDetector, APairWithARepeatedImageIsNotOfOneTime) {
  FrozenFrameDetector detector;
  detector.update(1, 2);
  EXPECT_EQ(detector.fault(), nullptr);
  detector.update(3, 2);  // as of a camera that is slower than the other one
  EXPECT_STREQ(detector.fault(), "the right camera repeats its last image");
  detector.update(4, 5);
  EXPECT_EQ(detector.fault(), nullptr);
  for (int k = 10; k < 15; ++k) detector.update(4, k);
  EXPECT_STREQ(detector.fault(), "the left camera is frozen: it repeats the same image");
}

TEST(FrozenFrameDetector, AStillPictureIsNoFault) {
  FrozenFrameDetector detector;
  for (int k = 0; k < 100; ++k) detector.update(1, 2);
  EXPECT_FALSE(detector.repeats());
}

TEST(FrozenFrameDetector, GoesOnFromItsMemory) {
  FrozenFrameDetector detector, other;
  for (int k = 0; k < 4; ++k) detector.update(k, 7);
  ASSERT_TRUE(other.deserialize(detector.serialize()));
  for (int k = 4; k < 8; ++k) {
    detector.update(k, 7);
    other.update(k, 7);
    EXPECT_EQ(detector.serialize(), other.serialize());
    EXPECT_EQ(detector.repeats(), other.repeats());
  }
  EXPECT_EQ(other.repeats(), Side::kRight);
  EXPECT_FALSE(other.deserialize(std::vector<double>{1, 2, 3}));
  EXPECT_FALSE(other.deserialize(std::vector<double>{1, 2, -1, 0}));
  EXPECT_FALSE(other.deserialize(std::vector<double>{1, 2, 0.5, 0}));
}

}  // namespace
}  // namespace multireach::vision
