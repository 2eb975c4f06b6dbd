#include "vision/image_codec.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace multireach::vision {
namespace {

/// Smooth colours, so that subsampled formats lose little.
cv::Mat picture(int width, int height) {
  cv::Mat image(height, width, CV_8UC3);
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      image.at<cv::Vec3b>(row, column) = {static_cast<uint8_t>(60 + column), static_cast<uint8_t>(90 + row),
                                          static_cast<uint8_t>(200 - column)};
    }
  }
  return image;
}

std::vector<uint8_t> bytes_of(const cv::Mat& mat) {
  const cv::Mat packed = mat.clone();
  return {packed.data, packed.data + packed.total() * packed.elemSize()};
}

double difference(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size()) return 1e9;
  return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(3 * a.total());
}

TEST(ImageCodec, ReadsEveryFormat) {
  const cv::Mat bgr = picture(64, 48);
  ImageCodec codec;
  const auto check = [&](PixelFormat format, const std::vector<uint8_t>& data, double tolerance, const char* name) {
    cv::Mat out;
    ASSERT_TRUE(codec.decode({.width = 64, .height = 48, .row_stride = 0, .format = format, .data = data}, out))
        << name;
    EXPECT_LT(difference(out, bgr), tolerance) << name;
  };
  cv::Mat rgb, gray, i420;
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  cv::cvtColor(bgr, i420, cv::COLOR_BGR2YUV_I420);
  check(PixelFormat::kBgr, bytes_of(bgr), 1e-9, "BGR");
  check(PixelFormat::kRgb, bytes_of(rgb), 1e-9, "RGB");
  check(PixelFormat::kI420, bytes_of(i420), 2, "I420");
  check(PixelFormat::kMjpeg, codec.encode_jpeg(bgr, 95), 2, "JPEG");
  // The other layouts of the same luma and chroma, by hand.
  const std::vector<uint8_t> yuv = bytes_of(i420);
  const size_t luma = 64 * 48, quarter = luma / 4;
  std::vector<uint8_t> nv12(yuv.begin(), yuv.begin() + static_cast<std::ptrdiff_t>(luma)), yuyv, uyvy;
  for (size_t i = 0; i < quarter; ++i) {
    nv12.push_back(yuv[luma + i]);
    nv12.push_back(yuv[luma + quarter + i]);
  }
  for (size_t row = 0; row < 48; ++row) {
    for (size_t pair = 0; pair < 32; ++pair) {
      const size_t chroma = luma + row / 2 * 32 + pair;
      const uint8_t y0 = yuv[row * 64 + 2 * pair], y1 = yuv[row * 64 + 2 * pair + 1], u = yuv[chroma],
                    v = yuv[chroma + quarter];
      yuyv.insert(yuyv.end(), {y0, u, y1, v});
      uyvy.insert(uyvy.end(), {u, y0, v, y1});
    }
  }
  check(PixelFormat::kNv12, nv12, 2, "NV12");
  check(PixelFormat::kYuyv, yuyv, 2.5, "YUYV");
  check(PixelFormat::kUyvy, uyvy, 2.5, "UYVY");
  // A Bayer pattern named by the colours of its first two rows; B is channel 0, G 1, R 2.
  const auto bayer = [&](int c00, int c01, int c10, int c11) {
    std::vector<uint8_t> data;
    for (int row = 0; row < 48; ++row) {
      for (int column = 0; column < 64; ++column) {
        const int channel = row % 2 ? (column % 2 ? c11 : c10) : (column % 2 ? c01 : c00);
        data.push_back(bgr.at<cv::Vec3b>(row, column)[channel]);
      }
    }
    return data;
  };
  check(PixelFormat::kBayerBggr, bayer(0, 1, 1, 2), 2, "BGGR");
  check(PixelFormat::kBayerGbrg, bayer(1, 0, 2, 1), 2, "GBRG");
  check(PixelFormat::kBayerGrbg, bayer(1, 2, 0, 1), 2, "GRBG");
  check(PixelFormat::kBayerRggb, bayer(2, 1, 1, 0), 2, "RGGB");
  cv::cvtColor(bgr, gray, cv::COLOR_BGR2GRAY);
  cv::Mat out, gray3;
  cv::cvtColor(gray, gray3, cv::COLOR_GRAY2BGR);
  ASSERT_TRUE(codec.decode(
      {.width = 64, .height = 48, .row_stride = 0, .format = PixelFormat::kGray, .data = bytes_of(gray)}, out));
  EXPECT_EQ(difference(out, gray3), 0);
}

TEST(ImageCodec, HonoursTheRowStride) {
  const cv::Mat bgr = picture(10, 6);
  std::vector<uint8_t> padded;
  for (int row = 0; row < 6; ++row) {
    padded.insert(padded.end(), bgr.ptr(row), bgr.ptr(row) + 30);
    padded.insert(padded.end(), 2, 255);
  }
  ImageCodec codec;
  cv::Mat out;
  ASSERT_TRUE(
      codec.decode({.width = 10, .height = 6, .row_stride = 32, .format = PixelFormat::kBgr, .data = padded}, out));
  EXPECT_EQ(difference(out, bgr), 0);
}

TEST(ImageCodec, RefusesWhatCannotBeRead) {
  ImageCodec codec;
  cv::Mat out;
  const cv::Mat bgr = picture(64, 48);
  std::vector<uint8_t> raw = bytes_of(bgr), jpeg = codec.encode_jpeg(bgr, 90);
  const auto reads = [&](const EncodedImage& image) { return codec.decode(image, out); };
  EXPECT_TRUE(reads({.width = 64, .height = 48, .row_stride = 0, .format = PixelFormat::kMjpeg, .data = jpeg}));
  EXPECT_FALSE(reads({.width = 64, .height = 49, .row_stride = 0, .format = PixelFormat::kBgr, .data = raw}))
      << "too short";
  EXPECT_FALSE(reads({.width = 64, .height = 48, .row_stride = 100, .format = PixelFormat::kBgr, .data = raw}))
      << "stride";
  EXPECT_FALSE(reads({.width = -64, .height = 48, .row_stride = 0, .format = PixelFormat::kBgr, .data = raw}));
  EXPECT_FALSE(reads({.width = 1 << 30, .height = 1 << 30, .row_stride = 0, .format = PixelFormat::kBgr, .data = raw}));
  EXPECT_FALSE(reads({.width = 64, .height = 48, .row_stride = 0, .format = static_cast<PixelFormat>(7), .data = raw}));
  EXPECT_FALSE(reads({.width = 63, .height = 48, .row_stride = 0, .format = PixelFormat::kYuyv, .data = raw}))
      << "odd width";
  EXPECT_FALSE(reads({.width = 32, .height = 48, .row_stride = 0, .format = PixelFormat::kMjpeg, .data = jpeg}))
      << "another size";
  const std::span<const uint8_t> half(jpeg.data(), jpeg.size() / 2);
  EXPECT_FALSE(reads({.width = 64, .height = 48, .row_stride = 0, .format = PixelFormat::kMjpeg, .data = half}))
      << "cut off";
  EXPECT_FALSE(reads({.width = 64, .height = 48, .row_stride = 0, .format = PixelFormat::kMjpeg, .data = {}}));
  EXPECT_FALSE(reads({.width = 64, .height = 48, .row_stride = 0, .format = PixelFormat::kMjpeg, .data = raw}))
      << "no JPEG";
}

}  // namespace
}  // namespace multireach::vision
