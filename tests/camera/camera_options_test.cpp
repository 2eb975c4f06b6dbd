#include <gtest/gtest.h>

#include <cstdio>
#include <functional>

#include "camera/node/device_arguments.hpp"
#include "camera/pairing/stereo_buffer.hpp"
#include "runtime/files.hpp"
#include "tests/temporary_folder.hpp"

namespace multireach {
namespace {

class DeviceFile : public ::testing::Test {
 protected:
  DeviceOptions load(const std::string& text) {
    write_text_file(path_, text);
    return load_device_options(path_);
  }
  std::string fault(const std::string& text) {
    try {
      load(text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  const testing::TemporaryFolder folder_;
  const std::string path_ = folder_ / "cameras.yaml";
};

TEST_F(DeviceFile, GivesEveryKey) {
  const DeviceOptions options = load(
      "left: 0\nright: /dev/v4l/by-id/right\nwidth_px: 320\nheight_px: 240\nrate_hz: 60\nformat: YUYV\nexposure_ms: 5\n"
      "white_balance_k: 4600\ngain: 7\nlock_after_s: 3\njpeg_quality: 0\nmax_skew_ms: 2.5\nrotate_180: right\n");
  EXPECT_EQ(options.left, "0");
  EXPECT_EQ(options.right, "/dev/v4l/by-id/right");
  EXPECT_EQ(options.width, 320);
  EXPECT_EQ(options.height, 240);
  EXPECT_EQ(options.rate_hz, 60);
  EXPECT_EQ(options.format, DeviceRequest::Format::kYuyv);
  EXPECT_EQ(options.exposure_ms, 5);
  EXPECT_EQ(options.white_balance_k, 4600);
  EXPECT_EQ(options.gain, 7);
  EXPECT_EQ(options.lock_after_s, 3);
  EXPECT_EQ(options.jpeg_quality, 0);
  EXPECT_EQ(options.max_skew_ms, 2.5);
  EXPECT_EQ(options.rotate_180, DeviceOptions::Turn::kRight);
  EXPECT_NO_THROW(options.check("device"));
}

TEST_F(DeviceFile, LeavesToTheCameraWhatItDoesNotSay) {
  const DeviceOptions options = load("side_by_side: video.avi\n");
  EXPECT_EQ(options.side_by_side, folder_ / "video.avi") << "as seen from the file";
  EXPECT_EQ(options.width, 0);
  EXPECT_FALSE(options.exposure_ms || options.white_balance_k || options.gain || options.max_skew_ms);
  EXPECT_NO_THROW(options.check("device"));
}

TEST_F(DeviceFile, NamesFileLineAndKey) {
  EXPECT_NE(fault("left: 0\nexposure: 5\n").find(path_ + ":2: key 'exposure' is not known"), std::string::npos);
  EXPECT_EQ(fault("left: 0\nwhite_balance_k: 200\n"),
            path_ + ":2: key 'white_balance_k' is '200'; expected a number from 1000 to 20000");
  EXPECT_EQ(fault("max_skew_ms: -1\n"), path_ + ":1: key 'max_skew_ms' is '-1'; expected a number from 0 to 1000");
  EXPECT_EQ(fault("format: H264\n"), path_ + ":1: key 'format' is 'H264'; expected one of auto, MJPG, YUYV");
  EXPECT_EQ(fault("left: ''\n"),
            path_ + ":1: key 'left' is ''; expected a device number, a device, a FIFO or a video file");
}

TEST_F(DeviceFile, TheCommandLineGoesFirst) {
  write_text_file(path_, "left: 0\nright: 1\nwidth_px: 320\nrate_hz: 60\nexposure_ms: 5\n");
  DeviceArguments arguments;
  arguments.file = path_;
  arguments.rate_hz = 15;
  arguments.side_by_side = "3";
  const DeviceOptions options = arguments.options();
  EXPECT_EQ(options.rate_hz, 15);
  EXPECT_EQ(options.width, 320);
  EXPECT_EQ(options.exposure_ms, 5);
  EXPECT_EQ(options.side_by_side, "3");
  EXPECT_EQ(options.left, "") << "other cameras, not one of each";
}

TEST(DeviceOptions, NeedCamerasThatFitTogether) {
  const auto fault = [](const DeviceOptions& options) -> std::string {
    try {
      options.check("file.yaml");
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(fault({.left = "0", .right = "1"}), "");
  EXPECT_EQ(fault({.left = "0"}), "file.yaml: give --left and --right, or --side-by-side");
  EXPECT_EQ(fault({.left = "0", .right = "0"}), "file.yaml: left and right are the same device, '0'");
  EXPECT_NE(fault({.left = "0", .right = "1", .side_by_side = "2"}), "");
  EXPECT_NE(fault({.side_by_side = "2", .rotate_180 = DeviceOptions::Turn::kLeft}), "");
  EXPECT_EQ(fault({.side_by_side = "2", .rotate_180 = DeviceOptions::Turn::kBoth}), "");
  EXPECT_EQ(fault({.side_by_side = "2", .rate_hz = 100, .exposure_ms = 10}), "");
  EXPECT_EQ(fault({.side_by_side = "2", .rate_hz = 100, .exposure_ms = 12.5}),
            "file.yaml: exposure_ms 12.5 is longer than the 10.0 ms from one image to the next at 100 Hz");
}

constexpr int64_t kPeriod = 33333;  // us

class Buffer : public ::testing::Test {
 protected:
  void put_pairs(int count, int64_t skew) {
    for (int i = 0; i < count; ++i, now_ += kPeriod) {
      buffer_.push(Side::kLeft, Frame{.utime = now_});
      buffer_.push(Side::kRight, Frame{.utime = now_ + skew});
      ASSERT_TRUE(buffer_.pop(0));
    }
  }
  std::string state() { return buffer_.state(now_); }
  int64_t now_ = 1000000;
  StereoBuffer buffer_{FramePairing(kPeriod, 5000)};
};

TEST_F(Buffer, SaysHowFarApartTheImagesAre) {
  EXPECT_EQ(state(), "waiting for the first images");
  put_pairs(40, 1234);
  EXPECT_EQ(state(), "running, skew 1.2 ms, max 1.2, 0 unpaired");
  put_pairs(1, -3400);
  EXPECT_EQ(state(), "running, skew 1.2 ms, max 3.4, 0 unpaired");
  EXPECT_FALSE(buffer_.pop(0));
  EXPECT_FALSE(buffer_.ended());
}

TEST_F(Buffer, SaysWhatIsWrong) {
  put_pairs(3, 0);
  buffer_.set_fault(Side::kRight, "right camera 2 is gone, trying again");
  EXPECT_EQ(state(), "right camera 2 is gone, trying again");
  buffer_.set_fault(Side::kLeft, "left camera 0 gives no images");
  EXPECT_EQ(state(), "left camera 0 gives no images; right camera 2 is gone, trying again");
  buffer_.set_fault(Side::kLeft, "");
  buffer_.set_fault(Side::kRight, "");
  for (int i = 0; i < 90; ++i, now_ += kPeriod) {
    buffer_.push(Side::kLeft, Frame{.utime = now_});
    buffer_.push(Side::kRight, Frame{.utime = now_ + 10000});
  }
  EXPECT_EQ(state(), "no pair for 3 s: left and right are more than 5.0 ms apart, 179 unpaired");
}

TEST_F(Buffer, HoldsFewPairsThatNobodyTakes) {
  for (int i = 0; i < 100; ++i, now_ += kPeriod) {
    buffer_.push(Side::kLeft, Frame{.utime = now_});
    buffer_.push(Side::kRight, Frame{.utime = now_});
  }
  EXPECT_FALSE(buffer_.wait_for_room(Side::kLeft, 0));
  int held = 0;
  while (const auto pair = buffer_.pop(0)) {
    ++held;
    EXPECT_GT(pair->left.utime, now_ - 10 * kPeriod) << "the newest are kept";
  }
  EXPECT_EQ(held, 8);
  EXPECT_EQ(state(), "running, skew 0.0 ms, max 0.0, 0 unpaired, 92 pairs not sent");
  EXPECT_TRUE(buffer_.wait_for_room(Side::kLeft, 0));
}

TEST_F(Buffer, HoldsBackAFasterSideWhileTheOtherMayCome) {
  for (int i = 0; i < 8; ++i, now_ += kPeriod) buffer_.push(Side::kLeft, Frame{.utime = now_});
  EXPECT_FALSE(buffer_.wait_for_room(Side::kLeft, 0));
  buffer_.set_fault(Side::kRight, "right camera 2 is gone, trying again");
  EXPECT_TRUE(buffer_.wait_for_room(Side::kLeft, 0));
}

TEST_F(Buffer, EndsWhenASideHasEndedAndItsPairsAreTaken) {
  buffer_.push(Side::kLeft, Frame{.utime = now_});
  buffer_.end(Side::kLeft);
  EXPECT_FALSE(buffer_.ended()) << "the right one of the last pair may still come";
  buffer_.push(Side::kRight, Frame{.utime = now_});
  EXPECT_FALSE(buffer_.ended());
  EXPECT_TRUE(buffer_.pop(0));
  EXPECT_TRUE(buffer_.ended());
}

TEST_F(Buffer, EndsWhenBothHaveEndedWithoutAPair) {
  buffer_.push(Side::kLeft, Frame{.utime = now_});
  buffer_.end(Side::kLeft);
  buffer_.end(Side::kRight);
  EXPECT_TRUE(buffer_.ended());
}

}  // namespace
}  // namespace multireach
