#include "tools/replay/recompute.hpp"

#include "runtime/files.hpp"
#include "runtime/nodes/bridge_node.hpp"
#include "runtime/nodes/controller_node.hpp"
#include "tools/replay/ideal_robot_node.hpp"

namespace multireach {

std::unique_ptr<Node> make_node(const std::string& name, const NodeConfigs& configs) {
  if (name == "vision") {
    if (!configs.vision) throw InputError("to compute vision again, its file is needed: --vision");
    return std::make_unique<VisionNode>(*configs.vision);
  }
  if (name == "controller") return std::make_unique<ControllerNode>(configs.robot);
  if (name == "bridge") return std::make_unique<BridgeNode>(configs.robot);
  if (name == "ideal_robot") return std::make_unique<IdealRobotNode>(configs.robot);
  return nullptr;
}

Recomputed recompute(const RecordedRun& run, const NodeConfigs& configs, int64_t ticks, const FindMessage& find,
                     const ComputedSink& sink) {
  Recomputed result;
  const std::unique_ptr<Node> node = make_node(run.node, configs);
  if (!node) return result;
  Outbox out;
  int64_t ticked = 0;
  const auto hand_on = [&] {
    for (const OutMessage& message : out) sink(message, result.missing == 0);
    out.clear();
  };
  const auto tick_until = [&](int64_t until) {
    for (; ticked < until && node->next_tick(); ++ticked) {
      node->tick(out);
      hand_on();
    }
  };
  for (const auto& input : run.inputs) {
    ++result.inputs;
    const std::span<const uint8_t> bytes = input ? find(input->digest) : std::span<const uint8_t>();
    if (input) tick_until(input->ticks);
    if (bytes.empty()) {
      ++result.missing;
      continue;
    }
    node->receive(input->channel, bytes, out);
    hand_on();
  }
  tick_until(ticks);
  return result;
}

}  // namespace multireach
