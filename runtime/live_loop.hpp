#pragma once

#include "runtime/bus.hpp"
#include "runtime/lockstep.hpp"
#include "runtime/node.hpp"

namespace multireach {

struct LiveOptions : BusOptions {
  double speed = 1;        ///< seconds of message time per second
  double seconds = 0;      ///< end after this time; 0 for never
  bool real_time = false;  ///< ask for SCHED_FIFO and locked memory; without the right to, warn and go on
  /// Look for messages only this often, microseconds, and sleep between; 0: handle each when it arrives.
  int64_t drain_period_us = 0;
  bool lockstep = false;  ///< whether `multireach-replay play --lockstep` may drive the node
};

/// Runs a node on LCM until SIGINT or SIGTERM arrives, `seconds` have passed, or the node is finished. Subscribes to
/// its inputs, delivers messages before ticks, calls its ticks on time, and publishes its outputs and, once a second,
/// NODE_STATUS. Returns the program's exit code. Throws InputError when LCM cannot be started.
int run_live(Node& node, const LiveOptions& options);
/// Like above, for a node that can also be driven in lockstep by `multireach-replay play`. `make` creates a fresh node
/// when a lockstep replay starts and another when it has ended.
int run_live(const NodeFactory& make, const LiveOptions& options);

/// True once SIGINT, SIGTERM or SIGHUP has been received; needs `catch_signals` first.
bool interrupted();
void catch_signals();

}  // namespace multireach
