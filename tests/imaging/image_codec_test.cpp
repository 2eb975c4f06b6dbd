#include "imaging/image_codec.hpp"

#include <gtest/gtest.h>
#include <turbojpeg.h>

#include <iostream>
#include <opencv2/imgproc.hpp>

#include "imaging/jpeg_decoder.hpp"
#include "numeric/random.hpp"

namespace multireach::vision {
namespace {

/// A picture with smooth colours, so that chroma subsampling loses little.
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
  // The other layouts are assembled here from the same luma and chroma.
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
  // A Bayer pattern is named by the colours of its first two rows; B is channel 0, G 1, R 2.
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

/// A picture with fine structure and sharp colour edges, so that wrong neighbouring pixels change the result.
cv::Mat busy_picture(int width, int height, uint64_t seed) {
  const CounterRandom random(seed);
  cv::Mat image(height, width, CV_8UC3);
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const auto patch = static_cast<uint64_t>(row / 3) * 1000 + static_cast<uint64_t>(column / 5);
      for (int k = 0; k < 3; ++k) {
        image.at<cv::Vec3b>(row, column)[k] = static_cast<uint8_t>(random.bits(3 * patch + static_cast<uint64_t>(k)));
      }
    }
  }
  return image;
}

std::vector<uint8_t> jpeg_of(const cv::Mat& bgr, int subsampling, int flags) {
  unsigned char* data = nullptr;
  unsigned long size = 0;
  tjhandle handle = tjInitCompress();
  EXPECT_EQ(tjCompress2(handle, bgr.data, bgr.cols, static_cast<int>(bgr.step), bgr.rows, TJPF_BGR, &data, &size,
                        subsampling, 85, flags),
            0);
  std::vector<uint8_t> jpeg(data, data + size);
  tjFree(data);
  tjDestroy(handle);
  return jpeg;
}

cv::Rect random_part(const CounterRandom& random, uint64_t k, cv::Size size) {
  const auto draw = [&](uint64_t at, int limit) { return static_cast<int>(random.uniform(4 * k + at, 0, limit)); };
  const int x = draw(0, size.width), y = draw(1, size.height);
  return {x, y, 1 + draw(2, size.width - x), 1 + draw(3, size.height - y)};
}

/// Decodes `number` random parts of an image and counts those that differ in any bit from the same part of `whole`.
int different_parts(const EncodedImage& image, const cv::Mat& whole, int number, uint64_t seed) {
  ImageCodec codec;
  const CounterRandom random(seed);
  int different = 0;
  for (int k = 0; k < number; ++k) {
    const cv::Rect part = random_part(random, static_cast<uint64_t>(k), whole.size());
    cv::Mat out(whole.size(), CV_8UC3, cv::Scalar(1, 2, 3));
    const bool read = codec.decode(image, part, out) && out.size() == whole.size();
    different += read && cv::norm(out(part), whole(part), cv::NORM_INF) == 0 ? 0 : 1;
  }
  return different;
}

TEST(ImageCodec, APartOfAJpegIsAsInTheWhole) {
  std::cout << "seeds 1 to 48\n";
  uint64_t seed = 1;
  for (const int subsampling : {TJSAMP_420, TJSAMP_422, TJSAMP_444, TJSAMP_440, TJSAMP_411, TJSAMP_GRAY}) {
    for (const int flags : {0, TJFLAG_PROGRESSIVE}) {
      for (const cv::Size size : {cv::Size(160, 120), cv::Size(131, 97), cv::Size(16, 300), cv::Size(5, 3)}) {
        const std::vector<uint8_t> jpeg = jpeg_of(busy_picture(size.width, size.height, seed), subsampling, flags);
        const EncodedImage image{
            .width = size.width, .height = size.height, .format = PixelFormat::kMjpeg, .data = jpeg};
        // Decode the whole image with the other interface of the library.
        cv::Mat whole(size, CV_8UC3);
        tjhandle handle = tjInitDecompress();
        ASSERT_EQ(tjDecompress2(handle, jpeg.data(), jpeg.size(), whole.data, size.width, static_cast<int>(whole.step),
                                size.height, TJPF_BGR, TJFLAG_ACCURATEDCT),
                  0);
        tjDestroy(handle);
        cv::Mat out;
        ASSERT_TRUE(ImageCodec().decode(image, out));
        EXPECT_EQ(cv::norm(out, whole, cv::NORM_INF), 0);
        EXPECT_EQ(different_parts(image, whole, 60, seed), 0) << "sampling " << subsampling << ", " << size;
        // The check must detect a difference.
        whole ^= cv::Scalar(1, 0, 0);
        EXPECT_EQ(different_parts(image, whole, 10, seed), 10);
        ++seed;
      }
    }
  }
}

TEST(JpegDecoder, TellsWhetherChromaIsSubsampled) {
  const cv::Mat bgr = picture(64, 48);
  for (const int subsampling : {TJSAMP_420, TJSAMP_422, TJSAMP_440, TJSAMP_411})
    EXPECT_TRUE(jpeg_chroma_subsampled(jpeg_of(bgr, subsampling, 0))) << subsampling;
  for (const int subsampling : {TJSAMP_444, TJSAMP_GRAY})
    EXPECT_FALSE(jpeg_chroma_subsampled(jpeg_of(bgr, subsampling, 0))) << subsampling;
  EXPECT_FALSE(jpeg_chroma_subsampled(bytes_of(bgr))) << "no JPEG";
}

TEST(ImageCodec, APartOfOtherFormatsIsAsInTheWhole) {
  const cv::Size size(34, 26);
  const std::vector<uint8_t> raw = bytes_of(busy_picture(3 * size.width, size.height, 5));
  ImageCodec codec;
  for (const PixelFormat format :
       {PixelFormat::kGray, PixelFormat::kRgb, PixelFormat::kBgr, PixelFormat::kYuyv, PixelFormat::kUyvy,
        PixelFormat::kI420, PixelFormat::kNv12, PixelFormat::kBayerBggr, PixelFormat::kBayerRggb}) {
    const EncodedImage image{.width = size.width, .height = size.height, .format = format, .data = raw};
    cv::Mat whole;
    ASSERT_TRUE(codec.decode(image, whole));
    EXPECT_EQ(different_parts(image, whole, 100, 6), 0) << static_cast<int>(format);
  }
}

TEST(ImageCodec, APartOutsideOfTheImageCannotBeRead) {
  const cv::Mat bgr = picture(64, 48);
  ImageCodec codec;
  const std::vector<uint8_t> jpeg = codec.encode_jpeg(bgr, 90), raw = bytes_of(bgr);
  for (const auto& [format, data] : {std::pair(PixelFormat::kMjpeg, &jpeg), std::pair(PixelFormat::kBgr, &raw)}) {
    const EncodedImage image{.width = 64, .height = 48, .format = format, .data = *data};
    cv::Mat out;
    EXPECT_FALSE(codec.decode(image, {64, 0, 5, 5}, out));
    EXPECT_FALSE(codec.decode(image, {3, 3, 0, 5}, out));
    EXPECT_TRUE(codec.decode(image, {-3, -3, 9, 100}, out)) << "what is inside counts";
  }
}

TEST(ImageCodec, DamageMattersWhereItIsRead) {
  const cv::Mat bgr = busy_picture(160, 120, 3);
  const std::vector<uint8_t> jpeg = jpeg_of(bgr, TJSAMP_420, 0);
  const std::span<const uint8_t> half(jpeg.data(), jpeg.size() / 2);
  const EncodedImage image{.width = 160, .height = 120, .format = PixelFormat::kMjpeg, .data = half};
  ImageCodec codec;
  cv::Mat out;
  EXPECT_FALSE(codec.decode(image, out));
  EXPECT_FALSE(codec.decode(image, {0, 100, 20, 10}, out));
  EXPECT_TRUE(codec.decode(image, {0, 0, 20, 10}, out));
  // Random bytes are changed: the decoder may refuse a part or the whole image, but must not fail in another way.
  const CounterRandom random(12);
  std::cout << "seed 12\n";
  int refused = 0;
  for (uint64_t k = 0; k < 2000; ++k) {
    std::vector<uint8_t> spoilt = jpeg;
    for (uint64_t byte = 0; byte < 3; ++byte) {
      spoilt[random.bits(8 * k + 2 * byte) % spoilt.size()] = static_cast<uint8_t>(random.bits(8 * k + 2 * byte + 1));
    }
    const cv::Rect part = random_part(random, k + 10000, bgr.size());
    const bool read =
        codec.decode({.width = 160, .height = 120, .format = PixelFormat::kMjpeg, .data = spoilt}, part, out);
    refused += read ? 0 : 1;
  }
  EXPECT_GT(refused, 100);
  EXPECT_TRUE(codec.decode({.width = 160, .height = 120, .format = PixelFormat::kMjpeg, .data = jpeg}, out))
      << "what came before must not matter";
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
