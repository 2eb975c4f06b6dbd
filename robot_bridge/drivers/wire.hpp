#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace multireach::drivers {

/// The time that each call of a driver or an emulator receives.
struct Time {
  int64_t us = 0;       ///< since any origin, monotonic, microseconds; for all time-outs
  int64_t wall_us = 0;  ///< since 1970, microseconds; only for protocols that carry it
};

/// One connection of a driver to its robot.
struct Link {
  enum class Kind {
    kLcm,     ///< whole messages: of channel `receive` in, on channel `send` out
    kTcp,     ///< bytes, to port `number` of the host `address`
    kSerial,  ///< bytes, through the device `address` at `number` baud
  };
  Kind kind = Kind::kLcm;
  std::string receive{}, send{};  ///< channels, for kLcm
  std::string address{};          ///< host or device
  int number = 0;                 ///< port or baud
};

/// Bytes to send on a link, or the wish to close it; it is then opened again.
struct WireBytes {
  size_t link = 0;
  std::vector<uint8_t> bytes;
  bool close = false;
};
using WireOutbox = std::vector<WireBytes>;

/// One side of a robot's protocol: bytes and times in, bytes out. It has no socket, so the same object runs live and in
/// a test in virtual time.
class WireEnd {
 public:
  virtual ~WireEnd() = default;

  /// The links, which stay the same; other functions number them in this order.
  virtual std::vector<Link> links() const = 0;
  /// A TCP or serial link was opened, or lost.
  virtual void link_changed(size_t /*link*/, bool /*up*/, const Time&, WireOutbox&) {}
  /// Bytes have arrived: a whole message for kLcm, any part of the stream otherwise.
  virtual void receive(size_t link, std::span<const uint8_t> bytes, const Time& now, WireOutbox& out) = 0;
  /// Called once in each millisecond, where the process keeps up with the clock.
  virtual void tick(const Time& now, WireOutbox& out) = 0;
};

}  // namespace multireach::drivers
