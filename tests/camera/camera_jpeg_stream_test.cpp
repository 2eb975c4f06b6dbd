#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "camera/devices/frame_converter.hpp"
#include "camera/devices/jpeg_stream.hpp"
#include "imaging/image_codec.hpp"
#include "numeric/random.hpp"

namespace multireach {
namespace {

using Bytes = std::vector<uint8_t>;

/// An image whose corners differ, as a JPEG whose entropy-coded data hold stuffed bytes.
cv::Mat picture(int width, int height) {
  cv::Mat bgr(height, width, CV_8UC3);
  const CounterRandom random(7);
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const auto noise = static_cast<int>(random.bits(static_cast<uint64_t>(row * width + column)) % 40);
      bgr.at<cv::Vec3b>(row, column) = {cv::saturate_cast<uint8_t>(255 * column / width),
                                        cv::saturate_cast<uint8_t>(255 * row / height), static_cast<uint8_t>(noise)};
    }
  }
  return bgr;
}
Bytes jpeg(int width, int height, int quality = 90) {
  return ImageCodec().encode_jpeg(picture(width, height), quality);
}
Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST(JpegExtent, TellsTheSizeAndTheEnd) {
  const Bytes image = jpeg(72, 40);
  const JpegExtent extent = jpeg_extent(image + Bytes{0, 0, 0});
  EXPECT_EQ(extent.kind, JpegExtent::Kind::kWhole);
  EXPECT_EQ(extent.bytes, image.size());
  EXPECT_EQ(extent.width, 72);
  EXPECT_EQ(extent.height, 40);
}

TEST(JpegExtent, EveryBeginningIsIncomplete) {
  const Bytes image = jpeg(72, 40);
  for (size_t size = 0; size < image.size(); ++size)
    ASSERT_EQ(jpeg_extent(std::span(image.data(), size)).kind, JpegExtent::Kind::kIncomplete) << size;
}

TEST(JpegExtent, RefusesOthers) {
  const auto kind = [](const Bytes& bytes) { return jpeg_extent(bytes).kind; };
  EXPECT_EQ(kind({'R', 'I', 'F', 'F'}), JpegExtent::Kind::kBroken);
  EXPECT_EQ(kind({0xff, 0xd8, 0xff, 0xd9}), JpegExtent::Kind::kBroken) << "no image in it";
  EXPECT_EQ(kind({0xff, 0xd8, 0xff, 0xe0, 0, 1}), JpegExtent::Kind::kBroken) << "a segment shorter than its length";
  EXPECT_EQ(kind({0xff, 0xd8, 0xff, 0xff, 0xff, 0xe0, 0}), JpegExtent::Kind::kIncomplete) << "filling is allowed";
  const Bytes image = jpeg(72, 40);
  EXPECT_EQ(kind(Bytes(image.begin(), image.begin() + 700) + image), JpegExtent::Kind::kBroken);
}

class Stream : public ::testing::Test {
 protected:
  /// Puts the bytes in pieces of `piece` and returns the images that come.
  std::vector<Bytes> images(const Bytes& bytes, size_t piece) {
    std::vector<Bytes> found;
    for (size_t at = 0; at < bytes.size(); at += piece) {
      stream_.put(std::span(bytes).subspan(at, std::min(piece, bytes.size() - at)));
      while (auto image = stream_.next()) found.push_back(std::move(image->data));
    }
    return found;
  }
  JpegStream stream_;
};

TEST_F(Stream, FindsImagesInPiecesOfAnySize) {
  const Bytes a = jpeg(72, 40), b = jpeg(64, 48, 40);
  for (const size_t piece : {1, 2, 3, 100, 4096, 1000000}) {
    stream_ = JpegStream();
    const auto found = images(a + b + a, piece);
    EXPECT_EQ(found, (std::vector<Bytes>{a, b, a})) << piece;
    EXPECT_EQ(stream_.damaged(), 0);
    EXPECT_EQ(stream_.pending(), 0U);
  }
}

TEST_F(Stream, SkipsWhatStandsBetween) {
  const Bytes a = jpeg(72, 40);
  const std::string part = "--boundary\r\nContent-Type: image/jpeg\r\nContent-Length: 1234\r\n\r\n";
  const Bytes header(part.begin(), part.end());
  EXPECT_EQ(images(header + a + header + a + header, 77), (std::vector<Bytes>{a, a}));
  EXPECT_EQ(stream_.damaged(), 0);
}

TEST_F(Stream, BeginsInTheMiddleAndOutlivesDamage) {
  const Bytes a = jpeg(72, 40), b = jpeg(64, 48);
  const Bytes tail(a.begin() + 300, a.end()), head(a.begin(), a.begin() + 900);
  EXPECT_EQ(images(tail + b + head + b + b, 333), (std::vector<Bytes>{b, b, b}));
  EXPECT_EQ(stream_.damaged(), 1) << "the one that was cut off";
}

TEST_F(Stream, AnImageInsideAnImageIsNone) {
  // A thumbnail in an APP1 segment, as photographs have.
  const Bytes thumbnail = jpeg(16, 16), a = jpeg(72, 40);
  const size_t length = thumbnail.size() + 2;
  Bytes photograph{0xff, 0xd8, 0xff, 0xe1, static_cast<uint8_t>(length >> 8), static_cast<uint8_t>(length & 0xff)};
  photograph = photograph + thumbnail + Bytes(a.begin() + 2, a.end());
  EXPECT_EQ(images(photograph, 50), (std::vector<Bytes>{photograph}));
}

TEST_F(Stream, AMegabyteOfGarbageDoesNoHarm) {
  constexpr uint64_t kSeed = 5;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  const CounterRandom random(kSeed);
  Bytes garbage;
  for (uint64_t k = 0; k < 1000000; ++k) {
    // Markers are much more frequent than chance would have it.
    const uint64_t r = random.bits(k);
    garbage.push_back(r % 8 == 0 ? 0xff : r % 8 == 1 ? 0xd8 : static_cast<uint8_t>(r >> 8));
  }
  for (const Bytes& image : images(garbage, 5000)) EXPECT_EQ(jpeg_extent(image).kind, JpegExtent::Kind::kWhole);
  EXPECT_LT(stream_.pending(), 1000000U);
  const Bytes a = jpeg(72, 40);
  // A segment that the garbage began may hold the first of them, up to its greatest length.
  Bytes many;
  while (many.size() < 70000) many = many + a;
  const auto found = images(many, 1000);
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found.back(), a);
}

/// The frames of an image; none when it is refused, with the reason in `refused_`.
class Maker : public ::testing::Test {
 protected:
  std::vector<Frame> frames(const FrameConversion& form, RawImage image) {
    FrameConverter converter(form);
    return frames(converter, std::move(image));
  }
  std::vector<Frame> frames(FrameConverter& converter, RawImage image) {
    auto made = converter.convert(std::move(image), 77);
    if (auto* reason = std::get_if<std::string>(&made)) {
      refused_ = *reason;
      return {};
    }
    return std::get<std::vector<Frame>>(std::move(made));
  }
  static RawImage raw(const Bytes& jpeg_bytes) {
    const JpegExtent extent = jpeg_extent(jpeg_bytes);
    return {.width = extent.width, .height = extent.height, .data = jpeg_bytes};
  }
  static cv::Mat decoded(const Frame& frame) {
    cv::Mat bgr;
    EXPECT_TRUE(ImageCodec().decode(
        {frame.width, frame.height, frame.row_stride, static_cast<PixelFormat>(frame.pixelformat), frame.data}, bgr));
    return bgr;
  }
  static cv::Mat decoded(const Bytes& jpeg_bytes) {
    const JpegExtent extent = jpeg_extent(jpeg_bytes);
    cv::Mat bgr;
    EXPECT_TRUE(ImageCodec().decode({extent.width, extent.height, 0, PixelFormat::kMjpeg, jpeg_bytes}, bgr));
    return bgr;
  }
  static cv::Mat turned(const cv::Mat& image) {
    cv::Mat result;
    cv::rotate(image, result, cv::ROTATE_180);
    return result;
  }
  static double furthest(const cv::Mat& a, const cv::Mat& b) { return cv::norm(a, b, cv::NORM_INF); }
  std::string refused_;
};

TEST_F(Maker, SendsJpegAsItCame) {
  const Bytes image = jpeg(96, 64);
  const auto made = frames({}, raw(image));
  ASSERT_EQ(made.size(), 1U);
  EXPECT_EQ(made[0].data, image);
  EXPECT_EQ(made[0].utime, 77);
  EXPECT_EQ(made[0].pixelformat, static_cast<int32_t>(PixelFormat::kMjpeg));
}

TEST_F(Maker, DividesAndTurnsOnBlocksWithoutLoss) {
  const Bytes image = jpeg(192, 64);
  const cv::Mat whole = decoded(image);
  auto made = frames({.side_by_side = true}, raw(image));
  ASSERT_EQ(made.size(), 2U);
  // Blocks are the same; only the chroma of the columns next to the cut is interpolated from other neighbours.
  EXPECT_EQ(furthest(decoded(made[0]).colRange(0, 94), whole.colRange(0, 94)), 0);
  EXPECT_EQ(furthest(decoded(made[1]).colRange(2, 96), whole.colRange(98, 192)), 0);
  made = frames({.side_by_side = true, .rotate_180 = true}, raw(image));
  ASSERT_EQ(made.size(), 2U);
  EXPECT_LE(furthest(decoded(made[0]).colRange(0, 94), turned(whole).colRange(0, 94)), 4);
  EXPECT_LE(furthest(decoded(made[1]).colRange(2, 96), turned(whole).colRange(98, 192)), 4);
  made = frames({.rotate_180 = true}, raw(image));
  ASSERT_EQ(made.size(), 1U);
  EXPECT_LE(furthest(decoded(made[0]), turned(whole)), 4);
}

TEST_F(Maker, DividesAndTurnsWhatDoesNotEndOnBlocks) {
  const Bytes image = jpeg(200, 50, 95);
  const cv::Mat whole = decoded(image);
  const auto made = frames({.jpeg_quality = 0, .side_by_side = true, .rotate_180 = true}, raw(image));
  ASSERT_EQ(made.size(), 2U);
  EXPECT_EQ(furthest(decoded(made[0]), turned(whole).colRange(0, 100)), 0);
  EXPECT_EQ(furthest(decoded(made[1]), turned(whole).colRange(100, 200)), 0);
}

TEST_F(Maker, EncodesOrSendsRawWhatIsNotJpeg) {
  const cv::Mat bgr = picture(96, 64);
  RawImage image{.width = 96, .height = 64, .row_stride = 288, .format = PixelFormat::kBgr};
  image.data.assign(bgr.data, bgr.data + bgr.total() * 3);
  auto made = frames({.jpeg_quality = 0}, image);
  ASSERT_EQ(made.size(), 1U);
  EXPECT_EQ(made[0].data, image.data);
  EXPECT_EQ(made[0].row_stride, 288);
  made = frames({.jpeg_quality = 95}, image);
  ASSERT_EQ(made.size(), 1U);
  EXPECT_EQ(made[0].data, ImageCodec().encode_jpeg(bgr, 95));
}

TEST_F(Maker, RefusesOtherSizesAndDamage) {
  FrameConverter converter({});
  EXPECT_EQ(frames(converter, raw(jpeg(96, 64))).size(), 1U);
  EXPECT_TRUE(frames(converter, raw(jpeg(64, 64))).empty());
  EXPECT_EQ(refused_, "gives images of 64 x 64 pixels, not 96 x 64");
  EXPECT_EQ(frames(converter, raw(jpeg(96, 64))).size(), 1U);
  EXPECT_TRUE(frames({.width = 640, .height = 480}, raw(jpeg(96, 64))).empty());
  EXPECT_EQ(refused_, "gives images of 96 x 64 pixels, not 640 x 480");
  EXPECT_TRUE(frames({.side_by_side = true}, raw(jpeg(95, 64))).empty());
  EXPECT_NE(refused_.find("95 pixels wide"), std::string::npos);
  RawImage cut = raw(jpeg(192, 64));
  cut.data.resize(cut.data.size() / 2);
  EXPECT_TRUE(frames({.side_by_side = true}, cut).empty());
  EXPECT_EQ(refused_, "gave an image that cannot be decoded");
}

}  // namespace
}  // namespace multireach
