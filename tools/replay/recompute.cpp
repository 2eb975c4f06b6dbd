#include "tools/replay/recompute.hpp"

#include "controller/node/controller_node.hpp"
#include "robot_bridge/node/bridge_node.hpp"
#include "runtime/files.hpp"
#include "tools/replay/ideal_robot_node.hpp"

namespace multireach {
namespace {

/// Longest gap in a node's recorded outputs before the run counts as ended.
constexpr int64_t kMaxOutputGap = 5000000;  // us

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
  node->set_run(run.sender_run);
  Outbox out;
  int64_t ticked = 0, sent = 0;  // sent: sequence numbers that it has used
  const auto forward_outputs = [&] {
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
    return forward_outputs();
  };
  const int64_t per_input = node->sent_per_input();
  // Restores the node's state from the recorded outputs for an input. Afterwards the state is certain, whatever was
  // missing before.
  const auto restore = [&] {
    std::vector<std::span<const uint8_t>> recorded;
    for (int64_t k = 0; k < per_input; ++k) recorded.push_back(io.recorded(sent + k));
    if (!node->restore_from_outputs(recorded)) return false;
    for (int64_t k = 0; k < per_input; ++k) io.restored(sent + k);
    sent += per_input;
    result.certain = true;
    return true;
  };
  const auto mark_uncomputable = [&](int64_t inputs) {
    if (result.certain || !io.uncomputable || node->name() != "vision") return;
    for (int64_t k = 0; k < inputs * per_input; ++k) io.uncomputable(sent + k);
  };
  // Inputs consumed before the first NODE_INPUTS in the log.
  result.inputs = result.missing = run.unlisted_inputs;
  result.certain = run.unlisted_inputs == 0;
  node->skip_inputs(run.unlisted_inputs, "");
  mark_uncomputable(run.unlisted_inputs);
  sent += run.unlisted_inputs * per_input;
  for (const auto& input : run.inputs) {
    ++result.inputs;
    while (input && ticked < input->ticks && node->next_tick()) tick();
    if (input && input->channel == kClockInput) {
      constexpr int64_t kMostSkipped = 1'000'000'000'000;  // 30 years: no more in a log that is not damaged
      node->skip_ticks(std::clamp<int64_t>(input->sequence, 0, kMostSkipped));
      continue;
    }
    const std::span<const uint8_t> bytes = input ? io.find(input->digest) : std::span<const uint8_t>();
    if ((bytes.empty() || !result.certain) && restore()) {
      ++result.restored;
    } else if (!bytes.empty()) {
      mark_uncomputable(1);
      node->receive(input->channel, bytes, out);
      forward_outputs();
    } else {
      ++result.missing;
      result.certain = false;
      node->skip_inputs(1, input ? std::string_view(input->channel) : "");
      mark_uncomputable(1);
      sent += per_input;
    }
  }
  const int64_t period = node->tick_period_us();
  for (int64_t unknown = 0; unknown < kMaxOutputGap && node->next_tick();) unknown = tick() ? 0 : unknown + period;
  return result;
}

}  // namespace multireach
