#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tools/replay/recompute.hpp"

namespace multireach {

/// What came of computing a recorded run again.
struct Verification {
  struct Channel {
    int64_t messages = 0;
    int64_t equal = 0;  ///< computed again to the same bytes; of NODE_INPUTS and NODE_STATUS: whole
    int64_t different = 0;
    int64_t unchecked = 0;  ///< what they depend on is not in the log
    bool computed = false;  ///< a node in the log says that it made them; else they are inputs
  };
  struct Difference {
    std::string channel, node, field, recorded, computed;
    int64_t event = 0, sequence = -1, utime = 0;
    double after_s = 0;  ///< the begin of the log

    std::string sentence() const;
  };
  std::map<std::string, Channel> channels;
  std::optional<Difference> first;  ///< in the order of the log
  std::vector<std::string> notes;   ///< sentences about what was missing

  bool holds() const { return !first; }
  /// Whether not one message of a node could be computed again.
  bool nothing_checked() const;
};

/// Takes the log of a run and computes every message of vision, controller, bridge and simulated robot again, each from
/// the inputs that its node says to have taken in, in its order; compares bytes. Throws InputError when the log
/// cannot be read.
Verification verify(const std::string& log, const NodeConfigs& configs, const std::function<void(double)>& progress);

}  // namespace multireach
