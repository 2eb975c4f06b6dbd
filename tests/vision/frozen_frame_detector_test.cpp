#include "vision/camera_check/frozen_frame_detector.hpp"

#include <gtest/gtest.h>

namespace multireach::vision {
namespace {

/// Adds the k-th pair of cameras that take images at 30 Hz.
void add(FrozenFrameDetector& detector, int k, int64_t left, int64_t right) {
  const int64_t utime = 33333 * k;
  detector.update({left, utime}, {right, utime});
}

TEST(FrozenFrameDetector, TellsTheCameraThatStandsStill) {
  FrozenFrameDetector detector;
  for (int k = 0; k < 10; ++k) add(detector, k, 100 + k, 200 + k);
  EXPECT_FALSE(detector.repeats());
  for (int k = 10; k < 20; ++k) add(detector, k, 100 + k, 209);
  EXPECT_EQ(detector.repeats(), Side::kRight);
  add(detector, 20, 120, 220);
  EXPECT_FALSE(detector.repeats()) << "goes on";
  for (int k = 21; k < 31; ++k) add(detector, k, 120, 200 + k);
  EXPECT_EQ(detector.repeats(), Side::kLeft);
}

TEST(FrozenFrameDetector, ARepeatedImageIsNotOfItsNewTime) {
  FrozenFrameDetector detector;
  add(detector, 1, 1, 2);
  EXPECT_EQ(detector.fault(), nullptr);
  add(detector, 2, 3, 2);  // as of a camera that is slower than the other one
  EXPECT_STREQ(detector.fault(), "the right camera repeats its last image as a new one");
  add(detector, 3, 4, 5);
  EXPECT_EQ(detector.fault(), nullptr);
  for (int k = 10; k < 15; ++k) add(detector, k, 4, k);
  EXPECT_STREQ(detector.fault(), "the left camera is frozen: it repeats the same image");
}

TEST(FrozenFrameDetector, ARepeatedImageWithItsOwnTimeIsUsable) {
  FrozenFrameDetector detector;
  for (int k = 0; k < 20; ++k) {  // the right camera is half as fast
    detector.update({k, 33333 * k}, {100 + k / 2, 66667 * (k / 2)});
    EXPECT_EQ(detector.fault(), nullptr) << k;
  }
  for (int k = 20; k < 25; ++k) detector.update({k, 33333 * k}, {109, 66667 * 9});
  EXPECT_STREQ(detector.fault(), "the right camera is frozen: it repeats the same image");
}

TEST(FrozenFrameDetector, AStillPictureIsNoFault) {
  FrozenFrameDetector detector;
  add(detector, 0, 1, 2);
  for (int k = 1; k < 100; ++k) {
    add(detector, k, 1, 2);
    EXPECT_EQ(detector.both_repeat(), k >= 5) << k;
  }
  EXPECT_FALSE(detector.repeats());
  ASSERT_TRUE(detector.deserialize(100 * 33333, detector.serialize(100 * 33333)));
  EXPECT_FALSE(detector.both_repeat()) << "no state";
  for (int k = 100; k < 110; ++k) add(detector, k, 1, 2);
  EXPECT_TRUE(detector.both_repeat());
  add(detector, 110, 3, 2);
  EXPECT_FALSE(detector.both_repeat());
}

TEST(FrozenFrameDetector, APairThatIsSentTwiceIsNoStillPicture) {
  FrozenFrameDetector detector;
  for (int k = 0; k < 20; ++k) detector.update({1, 33333}, {2, 33333});
  EXPECT_FALSE(detector.both_repeat());
}

TEST(FrozenFrameDetector, GoesOnFromItsState) {
  FrozenFrameDetector detector, other;
  for (int k = 0; k < 4; ++k) add(detector, k, k, 7);
  ASSERT_TRUE(other.deserialize(100000, detector.serialize(100000)));
  for (int k = 4; k < 8; ++k) {
    add(detector, k, k, 7);
    add(other, k, k, 7);
    EXPECT_EQ(detector.serialize(0), other.serialize(0));
    EXPECT_EQ(detector.repeats(), other.repeats());
  }
  EXPECT_EQ(other.repeats(), Side::kRight);
  EXPECT_FALSE(other.deserialize(0, std::vector<double>{1, 2, 3}));
  // A time in nanoseconds must not make the state useless.
  detector.update({1, 1'700'000'000'000'000'000}, {2, 1'700'000'000'000'000'000});
  EXPECT_TRUE(other.deserialize(1'700'000'000'000'000, detector.serialize(1'700'000'000'000'000)));
  EXPECT_FALSE(other.deserialize(0, std::vector<double>{1, 2, -1, 0, 0, 0}));
  EXPECT_FALSE(other.deserialize(0, std::vector<double>{1, 2, 0.5, 0, 0, 0}));
}

}  // namespace
}  // namespace multireach::vision
