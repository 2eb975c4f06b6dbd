#pragma once

#include <fmt/format.h>

#include <bit>
#include <concepts>
#include <cstring>
#include <span>
#include <string>
#include <string_view>

#include "runtime/files.hpp"

namespace multireach {

/// Reads numbers and texts from the bytes of a third-party file, one after the other. Every length is checked against
/// what is left. Throws InputError that names the file, the byte, and what was expected.
class ByteReader {
 public:
  /// `offset`: position of the bytes, for errors; `place`: the file's name, and what these bytes are where the offset
  /// is not one of the file, as "run.bag: chunk at byte 13".
  ByteReader(std::string place, std::span<const uint8_t> bytes, uint64_t offset = 0)
      : place_(std::move(place)), bytes_(bytes), offset_(offset) {}

  void set_big_endian(bool big) { big_endian_ = big; }
  size_t left() const { return bytes_.size() - at_; }
  uint64_t position() const { return offset_ + at_; }
  const std::string& place() const { return place_; }

  template <std::integral Integer>
  Integer number(std::string_view what) {
    const auto raw = take(sizeof(Integer), what);
    std::make_unsigned_t<Integer> value = 0;
    for (size_t i = 0; i < raw.size(); ++i)
      value = static_cast<decltype(value)>(value | static_cast<uint64_t>(raw[i])
                                                       << 8 * (big_endian_ ? raw.size() - 1 - i : i));
    return static_cast<Integer>(value);
  }
  std::span<const uint8_t> take(uint64_t size, std::string_view what) {
    if (size > left()) fail(fmt::format("expected {} of {} bytes, but {} are left", what, size, left()));
    const auto part = bytes_.subspan(at_, size);
    at_ += size;
    return part;
  }
  /// A length of 32 bits, and as many bytes.
  std::span<const uint8_t> sized(std::string_view what) { return take(number<uint32_t>(what), what); }
  std::string_view text(std::string_view what) {
    const auto bytes = sized(what);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  /// Skips to the next multiple of `size` from the beginning of these bytes.
  void align(size_t size) { take((size - at_ % size) % size, "padding"); }
  [[noreturn]] void fail(const std::string& sentence) const {
    throw InputError(fmt::format("{}: byte {}: {}", place_, position(), sentence));
  }

 private:
  std::string place_;
  std::span<const uint8_t> bytes_;
  uint64_t offset_;
  size_t at_ = 0;
  bool big_endian_ = false;
};

}  // namespace multireach
