#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "robot_bridge/drivers/wire.hpp"

namespace multireach::drivers {

/// A stream of bytes in both directions that is never waited for.
class Transport {
 public:
  virtual ~Transport() = default;
  /// Opens the stream, or goes on opening it; `now_us` paces the attempts. Returns whether it is open.
  virtual bool open(int64_t now_us) = 0;
  /// Appends what has arrived to `bytes`. Returns false when the stream has ended.
  [[nodiscard]] virtual bool receive(std::vector<uint8_t>& bytes) = 0;
  /// Returns false when the stream has ended or takes no more.
  [[nodiscard]] virtual bool send(std::span<const uint8_t> bytes) = 0;
  virtual void close() = 0;
};

using Transports = std::vector<std::unique_ptr<Transport>>;

/// What connects a driver to each of its links: null for kLcm. Throws InputError for a host without an address, a
/// baud that serial ports do not have, and a device that exists and is no serial port.
Transports client_transports(const std::vector<Link>& links);
/// What connects an emulator to the links: TCP ports are listened on, on this machine only; a serial device becomes a
/// pseudo-terminal, to which a symbolic link `address` is made. Throws InputError where that is impossible.
Transports emulator_transports(const std::vector<Link>& links);

}  // namespace multireach::drivers
