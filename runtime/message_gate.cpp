#include "runtime/message_gate.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <charconv>
#include <numeric>
#include <random>

#include "runtime/channels.hpp"
#include "runtime/config_keys.hpp"
#include "runtime/key_file.hpp"
#include "runtime/message_clock.hpp"

namespace multireach {
namespace {

constexpr std::string_view kRefusedText = "; refused: ";
constexpr size_t kMaxChannelName = 63;  // LCM_MAX_CHANNEL_NAME_LENGTH

ConfigKeys<KeyPolicy> policy_keys() {
  using Rule = KeyPolicy::Rule;
  ConfigKeys<KeyPolicy> keys("key policy",
                             "The file of `--key-policy`: which messages must be signed where a program has a `--key` "
                             "([keys](keys.md)). No channel may be in two lists.");
  keys.number(
      "max_age_s", "s", 0.001, 86400, [](auto& policy) -> auto& { return policy.max_age_us; },
      "A signed message is refused when its time of sending differs by more than this from the receiver's clock.", 1e6);
  const auto list = [&](const std::string& name, Rule rule, const std::string& initial, const std::string& meaning) {
    keys.other(name, "list of channels", "", initial, meaning, [=](const Config& config, KeyPolicy& policy) {
      if (!config.has(name)) return;
      for (const std::string& channel : config.texts(name)) {
        if (channel.empty() || channel.size() > kMaxChannelName)
          config.fail(name, "names of channels, of at most 63 characters");
        for (const std::string other : {"signed", "optional", "plain"}) {
          if (other == name || !config.has(other)) continue;
          const auto others = config.texts(other);
          if (std::ranges::find(others, channel) != others.end())
            config.fail(name, fmt::format("no channel that another list has; '{}' is also in '{}'", channel, other));
        }
        policy.rules[channel] = rule;
      }
    });
  };
  list("signed", Rule::kSigned, "all channels of multireach", "Sent signed, and refused unless signed.");
  list("optional", Rule::kOptional, "none",
       "Sent signed, but also accepted unsigned, as from plain LCM tools; a wrong signature is refused.");
  list("plain", Rule::kPlain, "all other channels", "Sent unsigned, and accepted without a check.");
  return keys;
}

/// A random number that identifies a sender.
int64_t random_sender() {
  std::random_device device;
  return static_cast<int64_t>(uint64_t{device()} << 32 | device());
}

}  // namespace

KeyPolicy::KeyPolicy() {
  for (const std::string_view channel : channel::kAll) rules.emplace(channel, Rule::kSigned);
}

KeyPolicy KeyPolicy::load(const std::string& path) {
  KeyPolicy policy;
  policy_keys().read(Config::load(path), policy);
  return policy;
}

KeyPolicy::Rule KeyPolicy::rule_for(std::string_view channel) const {
  const auto found = rules.find(channel);
  return found == rules.end() ? Rule::kPlain : found->second;
}

std::string key_policy_reference() {
  return policy_keys().reference();
}

std::string text_of(const RefusalCounts& counts) {
  std::string text;
  for (size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] == 0) continue;
    text += text.empty() ? kRefusedText : ", ";
    text += fmt::format("{} {}", counts[i], kRefusalNames[i]);
  }
  return text;
}

RefusalCounts refusals_in(std::string_view state) {
  RefusalCounts counts{};
  const size_t begin = state.rfind(kRefusedText);
  if (begin == std::string_view::npos) return counts;
  std::string_view rest = state.substr(begin + kRefusedText.size());
  while (!rest.empty()) {
    const std::string_view entry = rest.substr(0, rest.find(", "));
    rest.remove_prefix(std::min(rest.size(), entry.size() + 2));
    int64_t count = 0;
    const auto [end, error] = std::from_chars(entry.data(), entry.data() + entry.size(), count);
    const auto name = entry.substr(static_cast<size_t>(end - entry.data()));
    for (size_t i = 0; i < counts.size(); ++i) {
      if (error == std::errc() && count > 0 && name.starts_with(' ') && name.substr(1) == kRefusalNames[i])
        counts[i] = count;
    }
  }
  return counts;
}

MessageGate::MessageGate(const std::string& key_file, const std::string& policy_file) {
  if (key_file.empty()) {
    if (!policy_file.empty()) throw InputError("--key-policy: is only allowed with --key");
    return;
  }
  const MessageKey key = read_key_file(key_file);
  if (!policy_file.empty()) policy_ = KeyPolicy::load(policy_file);
  signer_.emplace(key, random_sender());
  verifier_.emplace(key, policy_.max_age_us);
}

std::span<const uint8_t> MessageGate::sign(std::string_view channel, std::span<const uint8_t> payload) {
  signed_.clear();
  signer_->sign(channel, payload, wall_us(), signed_);
  return signed_;
}

std::optional<std::span<const uint8_t>> MessageGate::incoming(std::string_view channel,
                                                              std::span<const uint8_t> bytes) {
  if (!verifier_) return without_trailer(bytes);
  const KeyPolicy::Rule rule = policy_.rule_for(channel);
  if (rule == KeyPolicy::Rule::kPlain) return without_trailer(bytes);
  const auto result = verifier_->verify(channel, bytes, wall_us());
  if (const auto* payload = std::get_if<std::span<const uint8_t>>(&result)) return *payload;
  const Refusal refusal = std::get<Refusal>(result);
  if (refusal == Refusal::kUnsigned && rule == KeyPolicy::Rule::kOptional) return bytes;
  refuse(channel, refusal);
  return std::nullopt;
}

int64_t MessageGate::total_refused() const {
  return std::accumulate(refused_.begin(), refused_.end(), int64_t{0});
}

void MessageGate::refuse(std::string_view channel, Refusal refusal) {
  const auto kind = static_cast<size_t>(refusal);
  ++refused_[kind];
  if (!said_.emplace(channel, refusal).second) return;
  std::string reason;
  if (const int64_t age = verifier_->age_us(); refusal == Refusal::kReplayed && age != 0) {
    reason = fmt::format(": sent {:.1f} s {} this computer's time; a recording, or the clocks of two computers differ",
                         static_cast<double>(age < 0 ? -age : age) * 1e-6, age < 0 ? "after" : "before");
  }
  spdlog::warn("a message on {} is refused and counted as {}{}", channel, kRefusalNames[kind], reason);
}

}  // namespace multireach
