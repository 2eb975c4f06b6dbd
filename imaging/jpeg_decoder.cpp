#include "imaging/jpeg_decoder.hpp"

#include <algorithm>
#include <csetjmp>
#include <cstdio>

// jpeglib.h needs the types of cstdio.
#include <jpeglib.h>
#include <turbojpeg.h>

namespace multireach {
namespace {

/// Error handling of libjpeg. Its error functions must not return, and no exception may pass through C code, so errors
/// leave by longjmp.
struct Errors {
  jpeg_error_mgr manager{};  // must be the first member: leave() casts its address to Errors
  std::jmp_buf way_out{};
};

[[noreturn]] void leave(j_common_ptr decompressor) {
  std::longjmp(reinterpret_cast<Errors*>(decompressor->err)->way_out, 1);  // NOLINT(cert-err52-cpp): see Errors
}

void leave_at_warning(j_common_ptr decompressor, int level) {
  if (level < 0) leave(decompressor);  // the data are damaged
}

/// A decompressor for one image. Not reused, because it would keep tables of earlier images; creating one takes
/// microseconds.
class Decompression {
 public:
  Decompression() = default;
  ~Decompression() { jpeg_destroy_decompress(&library_); }
  Decompression(const Decompression&) = delete;
  Decompression& operator=(const Decompression&) = delete;

  /// Must not have local objects with destructors: errors leave it by longjmp.
  bool run(std::span<const uint8_t> data, cv::Size size, const cv::Rect& part, cv::Mat& bgr) {
    library_.err = jpeg_std_error(&errors_.manager);
    errors_.manager.error_exit = &leave;
    errors_.manager.emit_message = &leave_at_warning;
    if (setjmp(errors_.way_out) != 0) return false;  // NOLINT(cert-err52-cpp): see Errors
    jpeg_create_decompress(&library_);
    jpeg_mem_src(&library_, data.data(), data.size());
    jpeg_read_header(&library_, TRUE);
    if (static_cast<int>(library_.image_width) != size.width || static_cast<int>(library_.image_height) != size.height)
      return false;
    bgr.create(size, CV_8UC3);
    library_.out_color_space = JCS_EXT_BGR;
    library_.dct_method = JDCT_ISLOW;  // the accurate transform: identical with and without SIMD
    jpeg_start_decompress(&library_);
    read(part, bgr);
    if (part.br().y == size.height) jpeg_finish_decompress(&library_);
    return true;
  }

 private:
  void read(const cv::Rect& part, cv::Mat& bgr) {
    // Decode one more block on each side: chroma is interpolated from neighbours, and the part must equal that of the
    // whole image.
    const int block_width = 8 * library_.max_h_samp_factor, block_height = 8 * library_.max_v_samp_factor;
    const int left = std::max(0, (part.x / block_width - 1) * block_width);
    const int right = std::min(bgr.cols, ((part.br().x - 1) / block_width + 2) * block_width);
    const int top = std::max(0, (part.y / block_height - 1) * block_height);
    JDIMENSION first = static_cast<JDIMENSION>(left), width = static_cast<JDIMENSION>(right - left);
    if (left > 0 || right < bgr.cols) jpeg_crop_scanline(&library_, &first, &width);
    if (top > 0) jpeg_skip_scanlines(&library_, static_cast<JDIMENSION>(top));
    while (static_cast<int>(library_.output_scanline) < part.br().y) {
      JSAMPROW row = bgr.ptr(static_cast<int>(library_.output_scanline)) + 3 * static_cast<size_t>(first);
      jpeg_read_scanlines(&library_, &row, 1);
    }
  }

  jpeg_decompress_struct library_{};
  Errors errors_;
};

struct Header {
  cv::Size size;
  int subsampling = 0;  ///< one of TJSAMP
};

std::optional<Header> header_of(std::span<const uint8_t> data) {
  const tjhandle handle = tjInitDecompress();
  if (handle == nullptr) return std::nullopt;
  Header header;
  int colour_space = 0;
  const int fault = tjDecompressHeader3(handle, data.data(), data.size(), &header.size.width, &header.size.height,
                                        &header.subsampling, &colour_space);
  tjDestroy(handle);
  return fault == 0 && header.size.width > 0 && header.size.height > 0 ? std::optional(header) : std::nullopt;
}

}  // namespace

bool decode_jpeg(std::span<const uint8_t> data, cv::Size size, const cv::Rect& part, cv::Mat& bgr) {
  return Decompression().run(data, size, part, bgr);
}

std::optional<cv::Size> jpeg_size(std::span<const uint8_t> data) {
  const auto header = header_of(data);
  return header ? std::optional(header->size) : std::nullopt;
}

bool jpeg_chroma_subsampled(std::span<const uint8_t> data) {
  const auto header = header_of(data);
  return header && header->subsampling != TJSAMP_444 && header->subsampling != TJSAMP_GRAY;
}

}  // namespace multireach
