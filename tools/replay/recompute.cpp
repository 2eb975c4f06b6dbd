#include "tools/replay/recompute.hpp"

#include "controller/node/controller_node.hpp"
#include "robot_bridge/node/bridge_node.hpp"
#include "runtime/files.hpp"
#include "tools/replay/ideal_robot_node.hpp"

namespace multireach {
namespace {

/// So long may what a node sent be missing in a log, before it is taken to have ended.
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
  int64_t ticked = 0, sent = 0;
  const auto hand_on = [&] {
    bool known = false;
    for (const OutMessage& message : out) known = io.sent(message, result.certain) || known;
    sent += static_cast<int64_t>(out.size());
    out.clear();
    return known;
  };
  const auto tick = [&] {
    node->tick(out);
    ++ticked;
    return hand_on();
  };
  const int64_t per_input = node->sent_per_input();
  // Takes what was sent for an input in its place: whatever was missing before, it is certain what comes after.
  const auto adopt = [&] {
    std::vector<std::span<const uint8_t>> recorded;
    for (int64_t k = 0; k < per_input; ++k) recorded.push_back(io.recorded(sent + k));
    if (!node->adopt(recorded)) return false;
    for (int64_t k = 0; k < per_input; ++k) io.adopted(sent + k);
    sent += per_input;
    result.certain = true;
    return true;
  };
  const auto doubt = [&](int64_t inputs) {
    if (result.certain || !io.doubtful || node->name() != "vision") return;
    for (int64_t k = 0; k < inputs * per_input; ++k) io.doubtful(sent + k);
  };
  // What it took in before the log tells of it.
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
