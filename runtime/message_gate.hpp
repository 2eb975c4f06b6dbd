#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/tagged_message.hpp"

namespace multireach {

/// Which messages must be signed where a program has a key.
struct KeyPolicy {
  enum class Rule {
    kSigned,    ///< sent signed; refused unless signed
    kOptional,  ///< sent signed; accepted unsigned too, but checked where signed
    kPlain,     ///< sent unsigned and accepted without a check
  };
  std::map<std::string, Rule, std::less<>> rules;
  int64_t max_age_us = 1000000;  ///< see MessageVerifier

  /// The default: this project's channels are signed, all others plain.
  KeyPolicy();
  /// The default, changed by a file. Throws InputError.
  static KeyPolicy load(const std::string& path);
  Rule rule_for(std::string_view channel) const;
};
/// The section of the reference page of configuration keys.
std::string key_policy_reference();

/// Messages refused for each Refusal.
using RefusalCounts = std::array<int64_t, kRefusalNames.size()>;
/// What NODE_STATUS says of them behind the node's state: "; refused: 3 unsigned, 1 altered", or "" for none.
std::string text_of(const RefusalCounts& counts);
/// The counts that such a state ends with.
RefusalCounts refusals_in(std::string_view state);

/// The place where all messages leave and enter a program. With a key, signs what leaves and refuses what enters
/// without a right signature, where the policy demands one. Without a key, messages leave as they are, and trailers of
/// signed messages are ignored.
class MessageGate {
 public:
  /// Without a key when `key_file` is "", with the default policy when `policy_file` is "". Throws InputError.
  MessageGate(const std::string& key_file, const std::string& policy_file);

  bool has_key() const { return signer_.has_value(); }
  /// Passes the bytes to be sent to `send`. Safe for concurrent use: messages leave in the order of their counters.
  template <class Send>
  void outgoing(std::string_view channel, std::span<const uint8_t> payload, Send&& send) {
    if (!signer_ || policy_.rule_for(channel) == KeyPolicy::Rule::kPlain) return send(payload);
    const std::lock_guard lock(sending_);
    send(sign(channel, payload));
  }
  /// The payload of a received message, a view into `bytes`; nothing when the message is refused. Counts it, and logs
  /// a sentence for the first refusal of its kind on its channel.
  std::optional<std::span<const uint8_t>> incoming(std::string_view channel, std::span<const uint8_t> bytes);

  const RefusalCounts& refused() const { return refused_; }
  int64_t total_refused() const;

 private:
  std::span<const uint8_t> sign(std::string_view channel, std::span<const uint8_t> payload);
  void refuse(std::string_view channel, Refusal refusal);

  KeyPolicy policy_;
  std::optional<MessageSigner> signer_;
  std::optional<MessageVerifier> verifier_;
  std::mutex sending_;
  std::vector<uint8_t> signed_;
  RefusalCounts refused_{};
  std::set<std::pair<std::string, Refusal>> said_;
};

}  // namespace multireach
