#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace multireach::drivers::rtde {

/// Packages of Universal Robots' Real-Time Data Exchange, protocol version 2: a big-endian 16-bit length of the whole
/// package, the type, and the payload.
enum class Type : uint8_t {
  kVersion = 'V',
  kController = 'v',  // asks for the version of the robot's software: four 32-bit numbers
  kText = 'M',
  kData = 'U',
  kSetupOutputs = 'O',
  kSetupInputs = 'I',
  kStart = 'S',
  kPause = 'P',
};

struct Package {
  Type type{};
  std::vector<uint8_t> payload;
};

/// Appends big-endian values.
class Writer {
 public:
  Writer& u8(uint8_t value);
  Writer& u16(uint16_t value);
  Writer& i32(int32_t value);
  Writer& real(double value);
  Writer& text(std::string_view value);
  const std::vector<uint8_t>& bytes() const { return bytes_; }

 private:
  Writer& big_endian(uint64_t value, int size);
  std::vector<uint8_t> bytes_;
};

/// Reads big-endian values; after the end, zeros, and complete() is false.
class Reader {
 public:
  explicit Reader(std::span<const uint8_t> bytes) : bytes_(bytes) {}
  uint8_t u8() { return static_cast<uint8_t>(big_endian(1)); }
  uint16_t u16() { return static_cast<uint16_t>(big_endian(2)); }
  int32_t i32() { return static_cast<int32_t>(static_cast<uint32_t>(big_endian(4))); }
  double real();
  std::string rest();
  /// Whether nothing was read beyond the end.
  bool complete() const { return !short_; }
  /// Whether everything was read.
  bool at_end() const { return !short_ && bytes_.empty(); }

 private:
  uint64_t big_endian(size_t size);
  std::span<const uint8_t> bytes_;
  bool short_ = false;
};

std::vector<uint8_t> encode(Type type, std::span<const uint8_t> payload);

std::vector<uint8_t> request_version();
std::vector<uint8_t> setup_outputs(double rate_hz, std::string_view names);
std::vector<uint8_t> setup_inputs(std::string_view names);
std::vector<uint8_t> start();

/// Cuts a stream of bytes into packages.
class Stream {
 public:
  void add(std::span<const uint8_t> bytes) { buffer_.insert(buffer_.end(), bytes.begin(), bytes.end()); }
  void clear() { buffer_.clear(); }
  /// The next whole package. A length that no package has makes the stream unusable: broken().
  std::optional<Package> next();
  bool broken() const;

 private:
  std::vector<uint8_t> buffer_;
};

}  // namespace multireach::drivers::rtde
