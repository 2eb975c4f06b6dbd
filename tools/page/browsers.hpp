#pragma once

#include <string>
#include <vector>

#include "tools/page/outgoing_queue.hpp"

namespace multireach {

/// The browsers that show the page, as the node sees them. No call waits for a browser.
class Browsers {
 public:
  virtual ~Browsers() = default;
  virtual int count() const = 0;
  /// Whether one has come, or has lost frames, since the last call: the next frame must hold all messages.
  virtual bool take_needs_all() = 0;
  virtual void send(Outgoing::Kind kind, std::string bytes) = 0;
  /// What browsers have sent since the last call.
  virtual std::vector<std::string> take_requests() = 0;
};

}  // namespace multireach
