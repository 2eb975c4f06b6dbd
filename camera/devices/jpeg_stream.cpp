#include "camera/devices/jpeg_stream.hpp"

#include <algorithm>
#include <array>
#include <cstring>

namespace multireach {
namespace {

constexpr uint8_t kPrefix = 0xff, kStartOfImage = 0xd8, kEndOfImage = 0xd9, kStartOfScan = 0xda;
constexpr size_t kMaxImageBytes = size_t{64} << 20;  // bytes; no camera image is larger

bool is_frame_header(uint8_t marker) {
  return marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
}
bool stands_alone(uint8_t marker) {
  return marker == 0x01 || (marker >= 0xd0 && marker <= 0xd7);
}

/// Position of the next marker after entropy-coded data: 0xff, except byte stuffing, restart markers and fill bytes.
size_t end_of_scan(std::span<const uint8_t> bytes, size_t at) {
  while (at + 1 < bytes.size()) {
    const void* found = std::memchr(&bytes[at], kPrefix, bytes.size() - at - 1);
    if (!found) break;
    at = static_cast<size_t>(static_cast<const uint8_t*>(found) - bytes.data());
    const uint8_t next = bytes[at + 1];
    if (next != 0 && next != kPrefix && !stands_alone(next)) return at;
    at += next == kPrefix ? 1 : 2;
  }
  return bytes.size();
}

}  // namespace

JpegExtent jpeg_extent(std::span<const uint8_t> bytes) {
  using Kind = JpegExtent::Kind;
  JpegExtent extent;
  const auto stop = [&](Kind kind, size_t at) {
    extent.kind = kind;
    extent.bytes = std::min(at, bytes.size());
    return extent;
  };
  constexpr std::array kBeginning{kPrefix, kStartOfImage, kPrefix};
  for (size_t i = 0; i < kBeginning.size(); ++i) {
    if (i == bytes.size()) return stop(Kind::kIncomplete, i);
    if (bytes[i] != kBeginning[i]) return stop(Kind::kBroken, i);
  }
  bool scanned = false;
  size_t at = 2;
  while (at + 1 < bytes.size()) {
    if (bytes[at] != kPrefix) return stop(Kind::kBroken, at);
    const uint8_t marker = bytes[at + 1];
    if (marker == kPrefix) {
      ++at;
      continue;
    }
    if (stands_alone(marker)) {
      at += 2;
      continue;
    }
    if (marker == kEndOfImage) return stop(scanned && extent.width > 0 ? Kind::kWhole : Kind::kBroken, at + 2);
    if (marker < 0xc0 || marker == kStartOfImage) return stop(Kind::kBroken, at);
    if (at + 3 >= bytes.size()) return stop(Kind::kIncomplete, at);
    const size_t length = static_cast<size_t>(bytes[at + 2]) << 8 | bytes[at + 3];
    if (length < 2) return stop(Kind::kBroken, at);
    if (at + 2 + length > bytes.size()) return stop(Kind::kIncomplete, at);
    if (is_frame_header(marker)) {
      if (length < 8) return stop(Kind::kBroken, at);
      extent.height = bytes[at + 5] << 8 | bytes[at + 6];
      extent.width = bytes[at + 7] << 8 | bytes[at + 8];
      if (extent.width == 0 || extent.height == 0) return stop(Kind::kBroken, at);
    }
    at += 2 + length;
    if (marker == kStartOfScan) {
      if (extent.width == 0) return stop(Kind::kBroken, at);
      scanned = true;
      at = end_of_scan(bytes, at);
    }
  }
  return stop(Kind::kIncomplete, at);
}

void JpegStream::put(std::span<const uint8_t> bytes) {
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
}

std::optional<JpegStream::Image> JpegStream::next() {
  constexpr std::array kBeginning{kPrefix, kStartOfImage, kPrefix};
  auto begin = bytes_.begin();
  while (true) {
    begin = std::search(begin, bytes_.end(), kBeginning.begin(), kBeginning.end());
    if (begin == bytes_.end()) {
      // The last two bytes may be the beginning of the next image's marker.
      bytes_.erase(bytes_.begin(), bytes_.end() - static_cast<std::ptrdiff_t>(std::min<size_t>(bytes_.size(), 2)));
      return std::nullopt;
    }
    const JpegExtent extent = jpeg_extent({begin, bytes_.end()});
    const auto end = begin + static_cast<std::ptrdiff_t>(extent.bytes);
    if (extent.kind == JpegExtent::Kind::kWhole) {
      Image image{extent.width, extent.height, {begin, end}};
      bytes_.erase(bytes_.begin(), end);
      return image;
    }
    if (extent.kind == JpegExtent::Kind::kIncomplete && static_cast<size_t>(bytes_.end() - begin) <= kMaxImageBytes) {
      bytes_.erase(bytes_.begin(), begin);
      return std::nullopt;
    }
    ++damaged_;
    begin += 2;
  }
}

}  // namespace multireach
