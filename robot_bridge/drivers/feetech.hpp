#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace multireach::drivers::feetech {

/// Packets of Feetech's STS series: FF FF, id, length, instruction (in an answer: the status bits), parameters,
/// checksum; little-endian.
inline constexpr uint8_t kBroadcast = 0xFE;

enum Instruction : uint8_t { kRead = 0x02, kWrite = 0x03, kSyncRead = 0x82, kSyncWrite = 0x83 };

struct Packet {
  uint8_t id = 0;
  uint8_t instruction = 0;  ///< of an answer: the status bits
  std::vector<uint8_t> parameters;
};

std::vector<uint8_t> encode(const Packet& packet);

/// A number whose sign is its bit 15.
uint16_t sign_magnitude(int value);
int from_sign_magnitude(uint16_t value);

/// Finds packets in a stream; skips what is none, and those with a wrong checksum.
class Stream {
 public:
  void add(std::span<const uint8_t> bytes) { buffer_.insert(buffer_.end(), bytes.begin(), bytes.end()); }
  void clear() { buffer_.clear(); }
  std::optional<Packet> next();
  int64_t corrupt() const { return corrupt_; }

 private:
  std::vector<uint8_t> buffer_;
  int64_t corrupt_ = 0;
};

}  // namespace multireach::drivers::feetech
