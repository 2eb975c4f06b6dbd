#pragma once

#include <multireach/bridge_request_t.hpp>

#include "runtime/channels.hpp"
#include "runtime/node.hpp"

namespace multireach {

/// The message that asks the bridge or the driver of this run to end its motion. Nothing where it cannot be encoded.
inline std::optional<OutMessage> stop_request(int64_t run) {
  bridge_request_t request{};
  request.kind = bridge_request_t::DISABLE;
  request.run = run;
  auto bytes = encode(request);
  if (!bytes) return std::nullopt;
  return OutMessage{channel::kBridgeRequest, std::move(*bytes)};
}

}  // namespace multireach
