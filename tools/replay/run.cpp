#include "tools/replay/run.hpp"

#include "controller/node/controller_node.hpp"
#include "robot_bridge/node/bridge_node.hpp"
#include "robot_bridge/sim/robot_sim_node.hpp"
#include "runtime/channels.hpp"
#include "runtime/digest.hpp"
#include "tools/replay/ideal_robot_node.hpp"
#include "tools/replay/prefetching_vision_node.hpp"

namespace multireach {
namespace {

/// Digests all messages of the nodes and passes them to the sink.
class Recorder : public VirtualLoop::Observer {
 public:
  Recorder(const ReplaySink& sink, ReplayResult& result) : sink_(sink), result_(result) {}

  void sent(int64_t now_us, std::string_view channel, std::span<const uint8_t> bytes) override {
    auto at = result_.channels.find(channel);
    if (at == result_.channels.end()) at = result_.channels.emplace(channel, ReplayResult::Channel{}).first;
    ReplayResult::Channel& sum = at->second;
    ++sum.messages;
    const int64_t digest = digest_of(bytes);
    sum.digest = digest_of({sum.digest, digest});
    // NODE_INPUTS contains configuration digests, which change even with comments in the files.
    if (channel != channel::kNodeInputs)
      result_.digest = digest_of({result_.digest, now_us, digest_of(channel), digest});
    sink_(now_us, channel, bytes, false);
  }

 private:
  const ReplaySink& sink_;
  ReplayResult& result_;
};

}  // namespace

std::vector<std::unique_ptr<Node>> nodes_of(const ReplayOptions& options) {
  std::vector<std::unique_ptr<Node>> nodes;
  if (options.from == ReplayFrom::kImages) {
    if (options.threads > 1) {
      nodes.push_back(std::make_unique<PrefetchingVisionNode>(options));
    } else {
      nodes.push_back(std::make_unique<VisionNode>(*options.vision));
    }
  }
  nodes.push_back(std::make_unique<ControllerNode>(options.config));
  nodes.push_back(std::make_unique<BridgeNode>(options.config));
  if (options.robot == ReplayRobot::kIdeal) nodes.push_back(std::make_unique<IdealRobotNode>(options.config));
  if (options.robot == ReplayRobot::kSimulated) nodes.push_back(std::make_unique<RobotSimNode>(options.config));
  return nodes;
}

void add_all(VirtualLoop& loop, const std::vector<std::unique_ptr<Node>>& nodes, const ReplayOptions& options) {
  for (const auto& node : nodes) loop.add(*node, -options.config.state_period_us);
}

ReplayResult replay(const ReplayOptions& options, const ReplaySink& sink, const ReplayProgress& progress) {
  Session session(options.session, options.from, options.robot == ReplayRobot::kRecorded);
  ReplayResult result;
  Recorder recorder(sink, result);
  VirtualLoop loop(recorder);
  const auto nodes = nodes_of(options);
  add_all(loop, nodes, options);
  const auto until_us = static_cast<int64_t>(options.until_s * 1e6);
  int64_t last_us = 0;
  while (const auto input = session.next()) {
    if (input->at_us >= until_us) break;
    loop.advance(input->at_us);
    sink(input->at_us, input->channel, input->data, true);
    loop.deliver(input->at_us, input->channel, input->data);
    last_us = input->at_us;
    ++result.inputs;
    if (progress) {
      progress(static_cast<double>(session.log().position()) / static_cast<double>(session.log().size()));
    }
  }
  loop.advance(std::min(until_us, last_us + kDrainTime));
  result.span_s = static_cast<double>(last_us) * 1e-6;
  result.damaged_bytes = session.log().damaged_bytes();
  result.damaged_places = session.log().damaged_places();
  return result;
}

}  // namespace multireach
