#pragma once

#include <cstdint>
#include <span>

namespace multireach {

/// Whether LCM's receiver can take this UDP datagram without reading or writing beyond it. The layout is that of LCM's
/// protocol page (UDP multicast protocol): "LC02", sequence, channel, payload; or "LC03", sequence, size of the
/// message, offset, number of this fragment and of all, then, in the first fragment, the channel, and the payload.
/// Other datagrams are acceptable: LCM ignores them.
[[nodiscard]] bool acceptable_datagram(std::span<const uint8_t> datagram);

/// Number of datagrams that were dropped before LCM saw them. LCM 1.3 computes the end of a fragment in 32 bits, and
/// looks for the end of a channel's name without a bound, so that one malformed datagram would end the process. This
/// file therefore defines `recvmsg`, which LCM calls for each datagram.
int64_t dropped_datagrams();

}  // namespace multireach
