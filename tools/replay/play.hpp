#pragma once

#include <string>

#include "runtime/live_loop.hpp"
#include "tools/replay/run.hpp"

namespace multireach {

struct PlayOptions {
  ReplayOptions replay;
  std::string control_url, image_url;
  double speed = 0;  ///< seconds of the session per second at most; 0 for as fast as the nodes answer
};

struct PlayResult {
  int64_t frames = 0;
  double span_s = 0, took_s = 0;
  int64_t again = 0;    ///< messages that were sent again because a node had not received them
  std::string failure;  ///< a sentence, when the nodes did not answer or sent other bytes
};

/// Plays a session to live processes in lockstep: vision, controller and bridge, and the simulated robot when the
/// replay has one. Sends a frame, tells each process which messages to take between which of its ticks, and sends the
/// next frame when all have answered; so they send the same bytes as `replay` computes, at any speed and whatever the
/// network loses. The processes begin afresh. Throws InputError when LCM cannot be started or the session cannot be
/// read.
PlayResult play(const PlayOptions& options, const ReplayProgress& progress);

}  // namespace multireach
