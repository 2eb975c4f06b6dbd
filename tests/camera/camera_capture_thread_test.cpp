#include "camera/devices/capture_thread.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

namespace multireach {
namespace {

constexpr int64_t kPatience = 60000000;  // us; only a test that fails waits this long

/// Gives no image: its first grab fails in a way that no device announces.
class FailingDevice : public CameraDevice {
 public:
  Grab grab(int64_t) override { throw std::runtime_error("the driver's memory is gone"); }
};

CaptureThread::Camera failing_camera() {
  CaptureThread::Camera camera{.name = "failing", .side = Side::kRight};
  camera.open = [](const std::string&, const DeviceRequest&) {
    return OpenedDevice{.device = std::make_unique<FailingDevice>()};
  };
  return camera;
}

TEST(CaptureThread, AnExceptionInTheThreadReachesWhoTakesThePairs) {
  const CaptureClock clock;
  StereoBuffer buffer(FramePairing(33333, 16666));
  const CaptureThread thread(failing_camera(), clock, buffer);
  try {
    buffer.pop(kPatience);
    FAIL() << "a camera that failed looks like one that has ended";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "right camera failing cannot go on: the driver's memory is gone");
  }
}

TEST(CaptureThread, PairsFromBeforeAFailureAreStillGiven) {
  StereoBuffer buffer(FramePairing(33333, 16666));
  buffer.push(Side::kLeft, Frame{.utime = 1});
  buffer.push(Side::kRight, Frame{.utime = 1});
  buffer.fail("gone");
  EXPECT_TRUE(buffer.pop(kPatience));
  EXPECT_THROW(buffer.pop(kPatience), std::runtime_error);
}

}  // namespace
}  // namespace multireach
