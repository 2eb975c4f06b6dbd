#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace multireach::drivers::dynamixel {

/// Packets of Dynamixel's protocol 2.0: FF FF FD 00, id, length, instruction, parameters, CRC; little-endian.
inline constexpr uint8_t kBroadcast = 0xFE;

enum Instruction : uint8_t {
  kPing = 0x01,
  kRead = 0x02,
  kWrite = 0x03,
  kReboot = 0x08,
  kStatus = 0x55,
  kSyncRead = 0x82,
  kSyncWrite = 0x83,
};

struct Packet {
  uint8_t id = 0;
  uint8_t instruction = 0;
  std::vector<uint8_t> parameters;  ///< of a status: the error, then the data
};

/// CRC-16 with the polynomial 0x8005, not reflected, from 0.
uint16_t crc(std::span<const uint8_t> bytes);
/// The bytes of a packet, with stuffing.
std::vector<uint8_t> encode(const Packet& packet);

/// Appends `value` in `size` bytes, low byte first.
void put(std::vector<uint8_t>& bytes, int64_t value, int size);
/// The signed number in `size` bytes from `at`, low byte first.
int32_t get(std::span<const uint8_t> bytes, size_t at, int size);

/// Finds packets in a stream; skips what is none, and those with a wrong CRC.
class Stream {
 public:
  void add(std::span<const uint8_t> bytes) { buffer_.insert(buffer_.end(), bytes.begin(), bytes.end()); }
  void clear() { buffer_.clear(); }
  std::optional<Packet> next();
  /// Number of packets with a wrong CRC.
  int64_t corrupt() const { return corrupt_; }

 private:
  std::vector<uint8_t> buffer_;
  int64_t corrupt_ = 0;
};

}  // namespace multireach::drivers::dynamixel
