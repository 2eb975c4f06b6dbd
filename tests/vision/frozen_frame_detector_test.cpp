#include "vision/track/frozen_frame_detector.hpp"

#include <gtest/gtest.h>

namespace multireach::vision {
namespace {

TEST(FrozenFrameDetector, TellsTheCameraThatStandsStill) {
  FrozenFrameDetector watch;
  for (int k = 0; k < 10; ++k) watch.take(100 + k, 200 + k);
  EXPECT_FALSE(watch.frozen());
  for (int k = 10; k < 20; ++k) watch.take(100 + k, 209);
  EXPECT_EQ(watch.frozen(), Side::kRight);
  watch.take(120, 220);
  EXPECT_FALSE(watch.frozen()) << "goes on";
  for (int k = 21; k < 31; ++k) watch.take(120, 200 + k);
  EXPECT_EQ(watch.frozen(), Side::kLeft);
}

TEST(FrozenFrameDetector, AStillPictureIsNoFault) {
  FrozenFrameDetector watch;
  for (int k = 0; k < 100; ++k) watch.take(1, 2);
  EXPECT_FALSE(watch.frozen());
}

TEST(FrozenFrameDetector, GoesOnFromItsMemory) {
  FrozenFrameDetector watch, other;
  for (int k = 0; k < 4; ++k) watch.take(k, 7);
  ASSERT_TRUE(other.deserialize(watch.serialize()));
  for (int k = 4; k < 8; ++k) {
    watch.take(k, 7);
    other.take(k, 7);
    EXPECT_EQ(watch.serialize(), other.serialize());
    EXPECT_EQ(watch.frozen(), other.frozen());
  }
  EXPECT_EQ(other.frozen(), Side::kRight);
  EXPECT_FALSE(other.deserialize(std::vector<double>{1, 2, 3}));
  EXPECT_FALSE(other.deserialize(std::vector<double>{1, 2, -1, 0}));
  EXPECT_FALSE(other.deserialize(std::vector<double>{1, 2, 0.5, 0}));
}

}  // namespace
}  // namespace multireach::vision
