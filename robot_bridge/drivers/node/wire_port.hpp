#pragma once

#include "robot_bridge/drivers/node/transport.hpp"
#include "robot_bridge/drivers/wire.hpp"
#include "runtime/node.hpp"

namespace multireach::drivers {

/// Connects one side of a protocol to its transports, and to LCM for links of that kind.
class WirePort {
 public:
  WirePort(WireEnd& end, Transports transports)
      : end_(&end), links_(end.links()), transports_(std::move(transports)), up_(links_.size(), false) {}

  /// Appends the LCM channels that the side listens to.
  void append_inputs(std::vector<std::string_view>& channels) const;
  /// Passes an LCM message on. Returns false when it is of no link.
  bool receive(std::string_view channel, std::span<const uint8_t> bytes, const Time& now, Outbox& out);
  /// Opens what is closed, passes on what has arrived, and ticks.
  void tick(const Time& now, Outbox& out);
  /// Sends what a call of the side returned, and empties it.
  void send(WireOutbox& wire, const Time& now, Outbox& out);

 private:
  void lose(size_t link, const Time& now, Outbox& out);

  WireEnd* end_;
  std::vector<Link> links_;
  Transports transports_;
  std::vector<bool> up_;
  std::vector<uint8_t> buffer_;
};

}  // namespace multireach::drivers
