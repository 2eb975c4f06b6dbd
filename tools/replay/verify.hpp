#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tools/replay/recompute.hpp"

namespace multireach {

/// The result of computing a recorded run again.
struct Verification {
  struct Channel {
    int64_t messages = 0;
    int64_t equal = 0;  ///< computed again to the same bytes; for NODE_INPUTS and NODE_STATUS: intact
    int64_t different = 0;
    int64_t unchecked = 0;  ///< messages whose inputs are not in the log
    bool computed = false;  ///< sent by a node whose NODE_INPUTS is in the log; else they are inputs
  };
  struct Difference {
    std::string channel, node, field, recorded, computed;
    int64_t event = 0, sequence = -1, utime = 0;
    double after_s = 0;  ///< seconds after the start of the log

    std::string sentence() const;
  };
  std::map<std::string, Channel> channels;
  std::optional<Difference> first;  ///< first difference, in log order
  std::vector<std::string> notes;   ///< sentences about missing data

  bool holds() const { return !first; }
  /// Whether no message of any node could be computed again.
  bool nothing_checked() const;
};

/// Computes every message of vision, controller, bridge and simulated robot in a log again, from the inputs that each
/// node recorded in NODE_INPUTS, in their order, and compares the bytes. Throws InputError when the log cannot be read.
Verification verify(const std::string& log, const NodeConfigs& configs, const std::function<void(double)>& progress);

}  // namespace multireach
