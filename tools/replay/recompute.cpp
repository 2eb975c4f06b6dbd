#include "tools/replay/recompute.hpp"

#include "controller/node/controller_node.hpp"
#include "robot_bridge/node/bridge_node.hpp"
#include "runtime/files.hpp"
#include "tools/replay/ideal_robot_node.hpp"

namespace multireach {
namespace {

/// Longest gap in a node's recorded outputs before the run counts as ended.
constexpr int64_t kLongestLoss = 5000000;  // us

}  // namespace

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

Recomputed recompute(const RecordedRun& run, const NodeConfigs& configs, const Recomputation& io) {
  Recomputed result;
  const std::unique_ptr<Node> node = make_node(run.node, configs);
  if (!node) return result;
  Outbox out;
  int64_t ticked = 0, sent = 0;  // sent: sequence numbers that it has used
  const auto hand_on = [&] {
    bool known = false;
    for (const OutMessage& message : out) {
      known = io.sent(message, result.certain) || known;
      if (message.channel == out.front().channel) ++sent;
    }
    out.clear();
    return known;
  };
  const auto tick = [&] {
    node->tick(out);
    ++ticked;
    return hand_on();
  };
  const int64_t per_input = node->sent_per_input();
  // Restores the node's state from the recorded outputs for an input. Afterwards the state is certain, whatever was
  // missing before.
  const auto adopt = [&] {
    std::vector<std::span<const uint8_t>> recorded;
    for (int64_t k = 0; k < per_input; ++k) recorded.push_back(io.recorded(sent + k));
    if (!node->deserialize(recorded)) return false;
    for (int64_t k = 0; k < per_input; ++k) io.adopted(sent + k);
    sent += per_input;
    result.certain = true;
    return true;
  };
  const auto doubt = [&](int64_t inputs) {
    if (result.certain || !io.doubtful || node->name() != "vision") return;
    for (int64_t k = 0; k < inputs * per_input; ++k) io.doubtful(sent + k);
  };
  // Inputs consumed before the first NODE_INPUTS in the log.
  result.inputs = result.missing = run.untold;
  result.certain = run.untold == 0;
  node->skip(run.untold);
  doubt(run.untold);
  sent += run.untold * per_input;
  for (const auto& input : run.inputs) {
    ++result.inputs;
    while (input && ticked < input->ticks && node->next_tick()) tick();
    const std::span<const uint8_t> bytes = input ? io.find(input->digest) : std::span<const uint8_t>();
    if ((bytes.empty() || !result.certain) && adopt()) {
      ++result.adopted;
    } else if (!bytes.empty()) {
      doubt(1);
      node->receive(input->channel, bytes, out);
      hand_on();
    } else {
      ++result.missing;
      result.certain = false;
      node->skip(1);
      doubt(1);
      sent += per_input;
    }
  }
  const int64_t period = node->tick_period_us();
  for (int64_t unknown = 0; unknown < kLongestLoss && node->next_tick();) unknown = tick() ? 0 : unknown + period;
  return result;
}

}  // namespace multireach
