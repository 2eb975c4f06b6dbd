#include "runtime/image_file.hpp"

#include <lodepng.h>

#include <algorithm>
#include <cctype>
#include <opencv2/imgproc.hpp>

#include "imaging/image_codec.hpp"
#include "imaging/jpeg_decoder.hpp"
#include "runtime/files.hpp"

namespace multireach {
namespace {

constexpr int64_t kMaxPixels = int64_t{1} << 28;

bool is_png(const std::vector<uint8_t>& bytes) {
  return bytes.size() > 8 && bytes[0] == 0x89 && bytes[1] == 'P' && bytes[2] == 'N' && bytes[3] == 'G';
}

[[noreturn]] void fail(const std::string& name, const std::string& what) {
  throw InputError(name + ": " + what);
}

void check_size(const std::string& name, int64_t width, int64_t height) {
  if (width * height > kMaxPixels) fail(name, "has more than 2^28 pixels");
}

cv::Mat decode_png(const std::vector<uint8_t>& bytes, const std::string& name) {
  unsigned width = 0, height = 0;
  lodepng::State state;
  unsigned fault = lodepng_inspect(&width, &height, &state, bytes.data(), bytes.size());
  if (fault == 0) check_size(name, width, height);
  std::vector<uint8_t> rgb;
  // What is encoded may have 16 bits in four channels, and a byte more in each row, of seven interlaced passes at most.
  lodepng::State decoder;
  decoder.info_raw.colortype = LCT_RGB;
  decoder.decoder.read_text_chunks = 0;  // each may hold much, too
  decoder.decoder.remember_unknown_chunks = 0;
  decoder.decoder.zlibsettings.max_output_size = (size_t{8} * width + 7) * (height + 7) + size_t{1 << 16};
  if (fault == 0) fault = lodepng::decode(rgb, width, height, decoder, bytes);
  if (fault != 0) fail(name, std::string("is not a PNG that can be read: ") + lodepng_error_text(fault));
  cv::Mat bgr;
  cv::cvtColor(cv::Mat(static_cast<int>(height), static_cast<int>(width), CV_8UC3, rgb.data()), bgr, cv::COLOR_RGB2BGR);
  return bgr;
}

/// Binary portable pixmap or greymap (netpbm's P6 and P5) with 8 bits a channel, as stereo datasets use it.
cv::Mat decode_pnm(const std::vector<uint8_t>& bytes, const std::string& name) {
  const bool colour = bytes[1] == '6';
  size_t at = 2;
  const auto number = [&]() -> int64_t {
    while (at < bytes.size() && (std::isspace(bytes[at]) != 0 || bytes[at] == '#')) {
      if (bytes[at] == '#') {
        while (at < bytes.size() && bytes[at] != '\n') ++at;
      } else {
        ++at;
      }
    }
    int64_t value = 0;
    size_t digits = 0;
    for (; at < bytes.size() && std::isdigit(bytes[at]) != 0 && digits < 9; ++at, ++digits)
      value = 10 * value + bytes[at] - '0';
    return digits > 0 ? value : -1;
  };
  const int64_t width = number(), height = number(), largest = number();
  if (width <= 0 || height <= 0 || largest != 255) fail(name, "is not a PPM or PGM with 8 bits a channel");
  check_size(name, width, height);
  const size_t size = static_cast<size_t>(width * height) * (colour ? 3 : 1);
  if (bytes.size() < at + 1 + size) fail(name, "is cut off");
  cv::Mat pixels(static_cast<int>(height), static_cast<int>(width), colour ? CV_8UC3 : CV_8UC1), bgr;
  std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(at) + 1, size, pixels.data);
  cv::cvtColor(pixels, bgr, colour ? cv::COLOR_RGB2BGR : cv::COLOR_GRAY2BGR);
  return bgr;
}

}  // namespace

cv::Mat decode_image(const std::vector<uint8_t>& bytes, const std::string& name) {
  if (is_png(bytes)) return decode_png(bytes, name);
  if (bytes.size() > 2 && bytes[0] == 'P' && (bytes[1] == '5' || bytes[1] == '6')) return decode_pnm(bytes, name);
  const auto size = jpeg_size(bytes);
  if (!size) fail(name, "is not an image that can be read (PNG, JPEG, PPM or PGM)");
  check_size(name, size->width, size->height);
  cv::Mat bgr;
  const EncodedImage image{.width = size->width, .height = size->height, .format = PixelFormat::kMjpeg, .data = bytes};
  if (!ImageCodec().decode(image, bgr)) fail(name, "is a JPEG that is damaged, or in CMYK instead of RGB");
  return bgr;
}

cv::Mat read_image(const std::string& path) {
  return decode_image(read_binary_file(path), path);
}

std::vector<uint8_t> encode_png(const cv::Mat& image) {
  const bool grey = image.channels() == 1;
  cv::Mat pixels = image;
  if (!grey) cv::cvtColor(image, pixels, cv::COLOR_BGR2RGB);
  if (!pixels.isContinuous()) pixels = pixels.clone();
  lodepng::State state;
  state.info_raw.colortype = state.info_png.color.colortype = grey ? LCT_GREY : LCT_RGB;
  // Noise does not repeat: a longer window takes twice the time, and makes the files of a camera 7 % smaller.
  state.encoder.zlibsettings.windowsize = 64;
  std::vector<uint8_t> png;
  const unsigned fault =
      lodepng::encode(png, pixels.data, static_cast<unsigned>(pixels.cols), static_cast<unsigned>(pixels.rows), state);
  if (fault != 0) throw InputError(std::string("a PNG cannot be made: ") + lodepng_error_text(fault));
  return png;
}

}  // namespace multireach
