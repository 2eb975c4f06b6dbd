#pragma once

#include <string>

#include "runtime/live_loop.hpp"
#include "tools/replay/run.hpp"

namespace multireach {

struct PlayOptions {
  ReplayOptions replay;
  BusOptions bus;
  double speed = 0;  ///< largest speed, session seconds per second; 0: as fast as the nodes answer
};

struct PlayResult {
  int64_t frames = 0;
  double span_s = 0, took_s = 0;
  int64_t resent = 0;   ///< messages resent because a node had not received them
  std::string failure;  ///< a sentence when a node did not answer or sent different bytes
};

/// Plays a session to live processes in lockstep: vision, controller and bridge, and the simulated robot if the replay
/// uses it. For each frame, sends the messages and tells each process which to consume between which of its ticks, then
/// waits until all have answered. So the processes send the same bytes as `replay` computes, at any speed and despite
/// message loss. The processes start with fresh nodes. Throws InputError when LCM cannot be started or the session
/// cannot be read.
PlayResult play(const PlayOptions& options, const ReplayProgress& progress);

}  // namespace multireach
