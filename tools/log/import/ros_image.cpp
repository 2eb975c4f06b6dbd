#include "tools/log/import/ros_image.hpp"

#include <array>
#include <optional>

namespace multireach {
namespace {

using Pixels = std::pair<std::string_view, PixelFormat>;

/// Encodings of sensor_msgs/image_encodings.h with 8 bits a channel.
constexpr std::array kEncodings{
    Pixels{"mono8", PixelFormat::kGray},
    Pixels{"8UC1", PixelFormat::kGray},
    Pixels{"rgb8", PixelFormat::kRgb},
    Pixels{"bgr8", PixelFormat::kBgr},
    Pixels{"8UC3", PixelFormat::kBgr},
    Pixels{"yuv422", PixelFormat::kUyvy},
    Pixels{"uyvy", PixelFormat::kUyvy},
    Pixels{"yuv422_yuy2", PixelFormat::kYuyv},
    Pixels{"yuyv", PixelFormat::kYuyv},
    Pixels{"bayer_rggb8", PixelFormat::kBayerRggb},
    Pixels{"bayer_bggr8", PixelFormat::kBayerBggr},
    Pixels{"bayer_gbrg8", PixelFormat::kBayerGbrg},
    Pixels{"bayer_grbg8", PixelFormat::kBayerGrbg},
};

/// Reads a message's fields in order. CDR aligns numbers to their size, from the end of its own header of four bytes.
class Fields {
 public:
  Fields(ByteReader message, RosEncoding encoding) : cdr_(encoding == RosEncoding::kCdr), bytes_(message) {
    if (!cdr_) return;
    const auto header = bytes_.take(4, "the header of CDR data");
    if (header[0] != 0 || header[1] > 1)
      bytes_.fail("the message's header is not one of plain CDR; expected the bytes 0, and 0 or 1");
    const size_t left = bytes_.left();
    const uint64_t at = bytes_.position();
    bytes_ = ByteReader(bytes_.place(), bytes_.take(left, "a message"), at);
    bytes_.set_big_endian(header[1] == 0);
  }

  template <class Integer>
  Integer number(std::string_view what) {
    if (cdr_) bytes_.align(sizeof(Integer));
    return bytes_.number<Integer>(what);
  }
  std::string_view text(std::string_view what) {
    const auto size = number<uint32_t>(what);
    const auto part = bytes_.take(size, what);
    std::string_view words(reinterpret_cast<const char*>(part.data()), part.size());
    // Strings of CDR end in a zero, which counts.
    if (cdr_ && words.ends_with('\0')) words.remove_suffix(1);
    return words;
  }
  std::span<const uint8_t> blob(std::string_view what) {
    const auto size = number<uint32_t>(what);
    return bytes_.take(size, what);
  }
  /// The header's time, microseconds.
  int64_t header() {
    if (!cdr_) number<uint32_t>("the header's number");
    const int64_t seconds =
        cdr_ ? int64_t{number<int32_t>("the time stamp")} : int64_t{number<uint32_t>("the time stamp")};
    const auto ns = number<uint32_t>("the time stamp");
    if (ns >= 1000000000) bytes_.fail(fmt::format("the time stamp has {} ns; expected less than a second", ns));
    return seconds * 1000000 + ns / 1000;
  }
  [[noreturn]] void fail(const std::string& sentence) const { bytes_.fail(sentence); }
  std::string name() const { return fmt::format("{}: byte {}", bytes_.place(), bytes_.position()); }

 private:
  bool cdr_;
  ByteReader bytes_;
};

/// rgba8 and bgra8 without their transparency.
std::vector<uint8_t> without_alpha(const EncodedImage& image, const Fields& fields) {
  const auto stride = static_cast<size_t>(image.row_stride), width = static_cast<size_t>(image.width);
  if (stride < 4 * width || image.data.size() < stride * static_cast<size_t>(image.height))
    fields.fail("the data are shorter than the image; expected 4 bytes for each pixel");
  std::vector<uint8_t> packed;
  packed.reserve(3 * width * static_cast<size_t>(image.height));
  for (int row = 0; row < image.height; ++row) {
    const uint8_t* const pixels = image.data.data() + static_cast<size_t>(row) * stride;
    for (size_t x = 0; x < width; ++x) packed.insert(packed.end(), pixels + 4 * x, pixels + 4 * x + 3);
  }
  return packed;
}

Frame raw_image(Fields& fields, int64_t utime, ImageStore& store) {
  constexpr uint32_t kLargest = 16384;
  const auto height = fields.number<uint32_t>("the height"), width = fields.number<uint32_t>("the width");
  if (width < 2 || width > kLargest || height < 2 || height > kLargest)
    fields.fail(fmt::format("the image has {} x {} pixels; expected 2 to {} on a side", width, height, kLargest));
  const std::string encoding(fields.text("the encoding"));
  fields.number<uint8_t>("is_bigendian");
  const auto step = fields.number<uint32_t>("the step");
  if (step > 16 * kLargest) fields.fail(fmt::format("a row has {} bytes; expected at most {}", step, 16 * kLargest));
  EncodedImage image{.width = static_cast<int>(width),
                     .height = static_cast<int>(height),
                     .row_stride = static_cast<int>(step),
                     .format = PixelFormat::kGray,
                     .data = fields.blob("the pixels")};
  if (encoding == "rgba8" || encoding == "bgra8") {
    const std::vector<uint8_t> packed = without_alpha(image, fields);
    image.row_stride = 0;
    image.format = encoding == "rgba8" ? PixelFormat::kRgb : PixelFormat::kBgr;
    image.data = packed;
    return store.raw_frame(image, fields.name(), utime);
  }
  std::string known = "rgba8, bgra8";
  for (const auto& [name, format] : kEncodings) {
    if (name == encoding) {
      image.format = format;
      return store.raw_frame(image, fields.name(), utime);
    }
    known.append(", ").append(name);
  }
  fields.fail("the encoding '" + encoding + "' is not supported; expected one of " + known);
}

}  // namespace

std::optional<RosType> ros_image_type(std::string_view name) {
  if (name == "sensor_msgs/Image" || name == "sensor_msgs/msg/Image") return RosType::kImage;
  if (name == "sensor_msgs/CompressedImage" || name == "sensor_msgs/msg/CompressedImage")
    return RosType::kCompressedImage;
  return std::nullopt;
}

int64_t ros_stamp(ByteReader message, RosEncoding encoding) {
  return Fields(std::move(message), encoding).header();
}

Frame ros_frame(ByteReader message, RosEncoding encoding, RosType type, ImageStore& store) {
  Fields fields(std::move(message), encoding);
  const int64_t utime = fields.header();
  fields.text("the frame's name");
  if (type == RosType::kImage) return raw_image(fields, utime, store);
  fields.text("the format");
  const auto data = fields.blob("the compressed image");
  return store.file_frame({data.begin(), data.end()}, fields.name(), utime);
}

}  // namespace multireach
