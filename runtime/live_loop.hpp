#pragma once

#include <string>

#include "runtime/lockstep.hpp"
#include "runtime/node.hpp"

namespace multireach {

struct LiveOptions {
  std::string control_url;
  std::string image_url;
  double speed = 1;    ///< seconds of message time per second
  double seconds = 0;  ///< end after this time; 0 for never
};

/// Runs a node on LCM until SIGINT, SIGTERM, `seconds` have passed, or the node is finished: subscribes to its inputs,
/// hands it messages before ticks, wakes it for its ticks, publishes what it returns, and NODE_STATUS once a second.
/// Returns the program's exit code. Throws InputError when LCM cannot be started.
int run_live(Node& node, const LiveOptions& options);
/// The same, for a node that also follows the steps of a replay in lockstep (`multireach-replay play`): it then begins
/// afresh, and once more when the replay has ended.
int run_live(const NodeMaker& make, const LiveOptions& options);

/// Set once SIGINT or SIGTERM has been received, after `catch_signals`.
bool interrupted();
void catch_signals();

}  // namespace multireach
