// The conversation with a V4L2 driver, with one that the test plays.
#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include <cerrno>
#include <deque>
#include <map>
#include <opencv2/core.hpp>

#include "camera/devices/v4l2_device.hpp"

namespace multireach {
namespace {

/// A driver with the sizes, formats and controls that a test gives it.
class Driver : public DeviceCalls {
 public:
  struct Control {
    int32_t min, max, value;
  };
  struct Image {
    std::vector<uint8_t> data;
    int64_t stamp_us = 0;
    uint32_t flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  };

  bool present = true;
  uint32_t capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  std::vector<uint32_t> formats{V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_MJPEG};
  uint32_t width = 640, height = 480, bytes_per_line = 1280;
  uint32_t rate_hz = 30;
  std::map<uint32_t, Control> controls;
  std::deque<Image> images;
  int64_t now_us = 5000000;

  int opened = 0, mapped = 0, queued = 0;
  bool streaming = false;
  uint32_t format = 0;

  int open(const std::string&) override {
    if (!present) return fail(ENOENT);
    ++opened;
    return 3;
  }
  int close(int) override {
    --opened;
    return 0;
  }
  void* map(int, size_t, off_t offset) override {
    ++mapped;
    return memory_[static_cast<size_t>(offset)].data();
  }
  void unmap(void*, size_t) override { --mapped; }
  int wait(int, int64_t timeout_us) override {
    if (!present || !images.empty()) return 1;
    now_us += timeout_us;
    return 0;
  }
  int64_t monotonic_us() override { return now_us; }

  int ioctl(int, unsigned long request, void* argument) override {
    if (!present) return fail(ENODEV);
    switch (request) {
      case VIDIOC_QUERYCAP:
        static_cast<v4l2_capability*>(argument)->capabilities = V4L2_CAP_DEVICE_CAPS | V4L2_CAP_VIDEO_CAPTURE;
        static_cast<v4l2_capability*>(argument)->device_caps = capabilities;
        return 0;
      case VIDIOC_ENUM_FMT:
        return enumerate(*static_cast<v4l2_fmtdesc*>(argument));
      case VIDIOC_ENUM_FRAMESIZES:
        return enumerate(*static_cast<v4l2_frmsizeenum*>(argument));
      case VIDIOC_S_FMT:
        return set_format(static_cast<v4l2_format*>(argument)->fmt.pix);
      case VIDIOC_S_PARM:
        static_cast<v4l2_streamparm*>(argument)->parm.capture.timeperframe = {1, rate_hz};
        return 0;
      case VIDIOC_QUERYCTRL:
      case VIDIOC_S_CTRL:
      case VIDIOC_G_CTRL:
        return control(request, argument);
      case VIDIOC_REQBUFS:
        static_cast<v4l2_requestbuffers*>(argument)->count = kBuffers;
        return 0;
      case VIDIOC_QUERYBUF:
        static_cast<v4l2_buffer*>(argument)->length = static_cast<uint32_t>(memory_[0].size());
        static_cast<v4l2_buffer*>(argument)->m.offset = static_cast<v4l2_buffer*>(argument)->index;
        return 0;
      case VIDIOC_QBUF:
        ++queued;
        return 0;
      case VIDIOC_STREAMON:
        streaming = true;
        return 0;
      case VIDIOC_STREAMOFF:
        streaming = false;
        return 0;
      case VIDIOC_DQBUF:
        return give(*static_cast<v4l2_buffer*>(argument));
      default:
        return fail(ENOTTY);
    }
  }

 private:
  static constexpr uint32_t kBuffers = 3;

  static int fail(int error) {
    errno = error;
    return -1;
  }
  int enumerate(v4l2_fmtdesc& description) const {
    if (description.index >= formats.size()) return fail(EINVAL);
    description.pixelformat = formats[description.index];
    return 0;
  }
  int enumerate(v4l2_frmsizeenum& size) const {
    if (size.index > 0) return fail(EINVAL);
    size.type = V4L2_FRMSIZE_TYPE_DISCRETE;
    size.discrete = {width, height};
    return 0;
  }
  int set_format(v4l2_pix_format& pix) {
    if (std::ranges::find(formats, pix.pixelformat) == formats.end()) pix.pixelformat = formats[0];
    pix.width = width;
    pix.height = height;
    pix.bytesperline = bytes_per_line;
    format = pix.pixelformat;
    return 0;
  }
  int control(unsigned long request, void* argument) {
    const uint32_t id = *static_cast<uint32_t*>(argument);
    const auto found = controls.find(id);
    if (found == controls.end()) return fail(EINVAL);
    if (request == VIDIOC_QUERYCTRL) {
      static_cast<v4l2_queryctrl*>(argument)->minimum = found->second.min;
      static_cast<v4l2_queryctrl*>(argument)->maximum = found->second.max;
    } else if (request == VIDIOC_S_CTRL) {
      found->second.value = static_cast<v4l2_control*>(argument)->value;
    } else {
      static_cast<v4l2_control*>(argument)->value = found->second.value;
    }
    return 0;
  }
  int give(v4l2_buffer& buffer) {
    if (images.empty()) return fail(EAGAIN);
    const Image image = images.front();
    images.pop_front();
    buffer.index = next_++ % kBuffers;
    std::ranges::copy(image.data, memory_[buffer.index].begin());
    buffer.bytesused = static_cast<uint32_t>(image.data.size());
    buffer.flags = image.flags;
    buffer.timestamp = {image.stamp_us / 1000000, image.stamp_us % 1000000};
    --queued;
    return 0;
  }

  std::vector<std::vector<uint8_t>> memory_{kBuffers, std::vector<uint8_t>(700000)};
  uint32_t next_ = 0;
};

std::vector<uint8_t> jpeg(int width, int height) {
  return ImageCodec().encode_jpeg(cv::Mat(height, width, CV_8UC3, cv::Scalar(10, 200, 30)), 90);
}

class V4l2 : public ::testing::Test {
 protected:
  OpenedDevice open(const DeviceRequest& request = {}) { return open_v4l2(driver_, "/dev/video0", request); }
  void TearDown() override {
    EXPECT_EQ(driver_.opened, 0) << "not closed";
    EXPECT_EQ(driver_.mapped, 0) << "memory not given back";
    EXPECT_FALSE(driver_.streaming && driver_.present) << "not stopped";
  }
  Driver driver_;
};

TEST_F(V4l2, GivesJpegWithTheDriversTime) {
  auto opened = open();
  ASSERT_TRUE(opened.device) << opened.fault;
  EXPECT_TRUE(opened.remarks.empty());
  EXPECT_EQ(driver_.format, V4L2_PIX_FMT_MJPEG);
  auto image = jpeg(640, 480);
  const auto whole = image;
  image.insert(image.end(), 100, 0);  // some cameras pad
  driver_.images.push_back({image, 4990000});
  const Grab grab = opened.device->grab(1000);
  ASSERT_EQ(grab.kind, Grab::Kind::kImage);
  EXPECT_EQ(grab.image.data, whole);
  EXPECT_EQ(grab.image.width, 640);
  EXPECT_EQ(grab.image.monotonic_us, 4990000);
  EXPECT_EQ(driver_.queued, 3) << "the buffer goes back";
  EXPECT_EQ(opened.device->grab(1000).kind, Grab::Kind::kNoImage);
}

TEST_F(V4l2, StampsItselfWhatHasNoTimeOfThisClock) {
  auto opened = open();
  for (const Driver::Image& image : {Driver::Image{jpeg(640, 480), 4990000, V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN},
                                     Driver::Image{jpeg(640, 480), 5000001}, Driver::Image{jpeg(640, 480), 1000000}}) {
    driver_.images.push_back(image);
    EXPECT_EQ(opened.device->grab(1000).image.monotonic_us, 5000000);
  }
}

TEST_F(V4l2, TakesYuyvWhereThereIsNoJpeg) {
  driver_.formats = {V4L2_PIX_FMT_YUYV};
  driver_.bytes_per_line = 1290;
  auto opened = open();
  ASSERT_TRUE(opened.device) << opened.fault;
  driver_.images.push_back({std::vector<uint8_t>(size_t{1290} * 480, 9), 4990000});
  Grab grab = opened.device->grab(1000);
  ASSERT_EQ(grab.kind, Grab::Kind::kImage);
  EXPECT_EQ(grab.image.format, PixelFormat::kYuyv);
  EXPECT_EQ(grab.image.row_stride, 1290);
  driver_.images.push_back({std::vector<uint8_t>(1290 * 479, 9), 4990000});
  EXPECT_EQ(opened.device->grab(1000).kind, Grab::Kind::kDamaged);
}

TEST_F(V4l2, RefusesAnotherSizeOrFormatAndSaysWhatThereIs) {
  EXPECT_EQ(open({.width = 1280, .height = 720}).fault,
            "'/dev/video0': gives images of 640 x 480 pixels, not 1280 x 720 as asked; it has 640 x 480");
  driver_.formats = {V4L2_PIX_FMT_YUYV};
  EXPECT_EQ(open({.format = DeviceRequest::Format::kMjpg}).fault, "'/dev/video0': does not give MJPG; it has YUYV");
  driver_.formats = {V4L2_PIX_FMT_SBGGR10};
  EXPECT_EQ(open().fault, "'/dev/video0': does not give a format that can be sent; it has BG10");
}

TEST_F(V4l2, RefusesWhatIsNoCamera) {
  driver_.capabilities = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING;
  EXPECT_NE(open().fault.find("gives no images"), std::string::npos);
  driver_.present = false;
  EXPECT_EQ(open().fault, "'/dev/video0': cannot be opened (No such file or directory)");
}

TEST_F(V4l2, LocksWhatIsGivenAndRemarksWhatIsNotAccepted) {
  driver_.rate_hz = 25;
  driver_.controls = {{V4L2_CID_EXPOSURE_AUTO, {0, 3, 3}},
                      {V4L2_CID_EXPOSURE_ABSOLUTE, {1, 5000, 250}},
                      {V4L2_CID_EXPOSURE_AUTO_PRIORITY, {0, 1, 1}},
                      {V4L2_CID_AUTO_WHITE_BALANCE, {0, 1, 1}},
                      {V4L2_CID_WHITE_BALANCE_TEMPERATURE, {2800, 6500, 4000}}};
  const auto opened = open({.exposure_ms = 7.5, .white_balance_k = 9000, .gain = 4});
  ASSERT_TRUE(opened.device);
  EXPECT_EQ(opened.remarks,
            (std::vector<std::string>{
                "'/dev/video0': gives 25 images per second, not 30 as asked",
                "'/dev/video0': gain 4 was not accepted: the device has no such control",
                "'/dev/video0': white_balance_k 9000 was not accepted: the device accepts 2800 to 6500, not 9000"}));
  EXPECT_EQ(driver_.controls[V4L2_CID_EXPOSURE_ABSOLUTE].value, 75);
  EXPECT_EQ(driver_.controls[V4L2_CID_EXPOSURE_AUTO].value, V4L2_EXPOSURE_MANUAL);
  EXPECT_EQ(driver_.controls[V4L2_CID_EXPOSURE_AUTO_PRIORITY].value, 0);
  EXPECT_EQ(driver_.controls[V4L2_CID_AUTO_WHITE_BALANCE].value, 0);
}

TEST_F(V4l2, LeavesAloneWhatIsNotGiven) {
  driver_.controls = {{V4L2_CID_EXPOSURE_AUTO, {0, 3, 3}}, {V4L2_CID_AUTO_WHITE_BALANCE, {0, 1, 1}}};
  EXPECT_TRUE(open().remarks.empty());
  EXPECT_EQ(driver_.controls[V4L2_CID_EXPOSURE_AUTO].value, 3);
  EXPECT_EQ(driver_.controls[V4L2_CID_AUTO_WHITE_BALANCE].value, 1);
}

TEST_F(V4l2, LocksWhatTheAutomaticFound) {
  driver_.controls = {{V4L2_CID_EXPOSURE_AUTO, {0, 3, 3}},
                      {V4L2_CID_EXPOSURE_ABSOLUTE, {1, 5000, 123}},
                      {V4L2_CID_GAIN, {0, 255, 4}},
                      {V4L2_CID_AUTO_WHITE_BALANCE, {0, 1, 1}},
                      {V4L2_CID_WHITE_BALANCE_TEMPERATURE, {2800, 6500, 4000}}};
  const auto opened = open({.white_balance_k = 5000});
  driver_.controls[V4L2_CID_EXPOSURE_ABSOLUTE].value = 200;
  EXPECT_EQ(opened.device->lock(),
            (std::vector<std::string>{"'/dev/video0': exposure_ms is locked at 20",
                                      "'/dev/video0': gain cannot be locked: the device has no such control"}));
  EXPECT_EQ(driver_.controls[V4L2_CID_EXPOSURE_AUTO].value, V4L2_EXPOSURE_MANUAL);
  EXPECT_EQ(driver_.controls[V4L2_CID_EXPOSURE_ABSOLUTE].value, 200);
  EXPECT_EQ(driver_.controls[V4L2_CID_WHITE_BALANCE_TEMPERATURE].value, 5000);
}

TEST_F(V4l2, LosesDamagedImagesOnly) {
  auto opened = open();
  auto cut = jpeg(640, 480);
  cut.resize(cut.size() / 2);
  driver_.images = {{cut, 4990000},
                    {jpeg(640, 480), 4990000, V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_ERROR},
                    {{}, 4990000},
                    {jpeg(640, 480), 4990000}};
  for (int i = 0; i < 3; ++i) EXPECT_EQ(opened.device->grab(1000).kind, Grab::Kind::kDamaged) << i;
  EXPECT_EQ(opened.device->grab(1000).kind, Grab::Kind::kImage);
}

TEST_F(V4l2, IsGoneWhenUnpluggedOrSilent) {
  auto opened = open();
  driver_.present = false;
  const Grab unplugged = opened.device->grab(1000);
  EXPECT_EQ(unplugged.kind, Grab::Kind::kDisconnected);
  EXPECT_EQ(unplugged.reason, "is gone");
  driver_.present = true;
  opened = open();
  const int64_t begin = driver_.now_us;
  while (opened.device->grab(100000).kind == Grab::Kind::kNoImage) ASSERT_LT(driver_.now_us - begin, 3000000);
  EXPECT_GT(driver_.now_us - begin, 2000000);
}

}  // namespace
}  // namespace multireach
