#include "runtime/tagged_message.hpp"

#include <sodium.h>

#include <algorithm>
#include <stdexcept>

namespace multireach {
namespace {

constexpr size_t kFieldsSize = 32;  // sender, counter, time, key
constexpr std::array<uint8_t, 8> kMark{0x8d, 'm', 'r', 't', 'a', 'g', 0xc1, 0x01};
static_assert(kTrailerSize == kFieldsSize + kTagSize + kMark.size());
static_assert(MessageKey::kSize == crypto_generichash_KEYBYTES && kTagSize >= crypto_generichash_BYTES_MIN);
constexpr std::string_view kMessagePrefix = "multireach message 1", kKeyPrefix = "multireach key 1";
/// Senders remembered for a channel before those are forgotten whose messages are too old to be accepted again.
constexpr size_t kManySenders = 64;

using Tag = std::array<uint8_t, kTagSize>;

void append_number(std::vector<uint8_t>& to, int64_t number) {
  for (int shift = 56; shift >= 0; shift -= 8)
    to.push_back(static_cast<uint8_t>(static_cast<uint64_t>(number) >> shift));
}

int64_t number_at(std::span<const uint8_t> bytes) {
  uint64_t number = 0;
  for (const uint8_t byte : bytes.first<8>()) number = number << 8 | byte;
  return static_cast<int64_t>(number);
}

/// Keyed BLAKE2b of several parts.
class Hash {
 public:
  explicit Hash(const MessageKey& key) {
    crypto_generichash_init(&state_, key.bytes.data(), key.bytes.size(), kTagSize);
  }
  void add(std::span<const uint8_t> bytes) { crypto_generichash_update(&state_, bytes.data(), bytes.size()); }
  void add(std::string_view text) { add({reinterpret_cast<const uint8_t*>(text.data()), text.size()}); }
  Tag tag() {
    Tag tag;
    crypto_generichash_final(&state_, tag.data(), tag.size());
    return tag;
  }

 private:
  crypto_generichash_state state_;
};

Tag tag_of(const MessageKey& key, std::string_view channel, std::span<const uint8_t> fields,
           std::span<const uint8_t> payload) {
  Hash hash(key);
  hash.add(kMessagePrefix);
  hash.add(channel);
  const std::array<uint8_t, 1> length{static_cast<uint8_t>(channel.size())};  // at most 63
  hash.add(length);
  hash.add(fields);
  hash.add(payload);
  return hash.tag();
}

void start_sodium() {
  if (sodium_init() < 0) throw std::runtime_error("libsodium cannot be started");
}

std::array<uint8_t, 8> id_of(const MessageKey& key) {
  start_sodium();
  Hash hash(key);
  hash.add(kKeyPrefix);
  const Tag tag = hash.tag();
  std::array<uint8_t, 8> id;
  std::copy_n(tag.begin(), id.size(), id.begin());
  return id;
}

}  // namespace

std::span<const uint8_t> without_trailer(std::span<const uint8_t> bytes) {
  const bool tagged = bytes.size() >= kTrailerSize && std::ranges::equal(bytes.last<kMark.size()>(), kMark);
  return tagged ? bytes.first(bytes.size() - kTrailerSize) : bytes;
}

MessageKey random_message_key() {
  start_sodium();
  MessageKey key;
  randombytes_buf(key.bytes.data(), key.bytes.size());
  return key;
}

MessageSigner::MessageSigner(const MessageKey& key, int64_t sender) : key_(key), key_id_(id_of(key)), sender_(sender) {}

void MessageSigner::sign(std::string_view channel, std::span<const uint8_t> payload, int64_t now_utime,
                         std::vector<uint8_t>& out) {
  out.reserve(out.size() + payload.size() + kTrailerSize);
  out.insert(out.end(), payload.begin(), payload.end());
  append_number(out, sender_);
  append_number(out, ++counter_);
  append_number(out, now_utime);
  out.insert(out.end(), key_id_.begin(), key_id_.end());
  const Tag tag = tag_of(key_, channel, std::span(out).last(kFieldsSize), payload);
  out.insert(out.end(), tag.begin(), tag.end());
  out.insert(out.end(), kMark.begin(), kMark.end());
}

MessageVerifier::MessageVerifier(const MessageKey& key, int64_t max_age_us)
    : key_(key), key_id_(id_of(key)), max_age_us_(max_age_us) {}

std::variant<std::span<const uint8_t>, Refusal> MessageVerifier::verify(std::string_view channel,
                                                                        std::span<const uint8_t> bytes,
                                                                        int64_t now_utime) {
  const auto payload = without_trailer(bytes);
  if (payload.size() == bytes.size()) return Refusal::kUnsigned;
  const auto fields = bytes.subspan(payload.size(), kFieldsSize), tag = bytes.subspan(payload.size() + kFieldsSize);
  if (!std::ranges::equal(fields.last<8>(), key_id_)) return Refusal::kOtherKey;
  const Tag expected = tag_of(key_, channel, fields, payload);
  if (sodium_memcmp(expected.data(), tag.data(), expected.size()) != 0) return Refusal::kAltered;
  const Sender message{
      .id = number_at(fields), .counter = number_at(fields.subspan(8)), .utime = number_at(fields.subspan(16))};
  if (!accept_once(channel, message, now_utime)) return Refusal::kReplayed;
  return payload;
}

bool MessageVerifier::accept_once(std::string_view channel, const Sender& message, int64_t now_utime) {
  const auto age = [&](const Sender& sender) { return now_utime - sender.utime; };
  age_us_ = age(message);
  if (age_us_ > max_age_us_ || age_us_ < -max_age_us_) return false;
  age_us_ = 0;
  auto found = senders_.find(channel);
  if (found == senders_.end()) found = senders_.emplace(channel, std::vector<Sender>{}).first;
  std::vector<Sender>& senders = found->second;
  const auto known = std::ranges::find(senders, message.id, &Sender::id);
  if (known == senders.end()) {
    if (senders.size() >= kManySenders)
      std::erase_if(senders, [&](const Sender& sender) { return age(sender) > max_age_us_; });
    senders.push_back(message);
    return true;
  }
  if (message.counter <= known->counter) return false;
  *known = message;
  return true;
}

}  // namespace multireach
