#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace multireach {

/// What stands behind the payload of a signed message, big-endian: int64 sender, int64 counter, int64 time of sending
/// (wall clock, us), 8 bytes that identify the key, the tag, and a fixed mark. LCM's decoders ignore bytes behind the
/// payload. The tag is keyed BLAKE2b (RFC 7693) of a prefix, the channel's name and its length, the fields before the
/// tag, and the payload.
inline constexpr size_t kTagSize = 16, kTrailerSize = 56;

/// The payload of a message that may be signed: the bytes before the trailer, if there is one. Checks no tag.
std::span<const uint8_t> without_trailer(std::span<const uint8_t> bytes);

struct MessageKey {
  static constexpr size_t kSize = 32;
  std::array<uint8_t, kSize> bytes{};
};
/// A random key, of the operating system's generator.
MessageKey random_message_key();

/// Why a message is refused.
enum class Refusal {
  kUnsigned,  ///< no trailer
  kAltered,   ///< the tag does not belong to channel, payload and trailer
  kReplayed,  ///< not newer than another message of this sender on this channel, or not sent just now
  kOtherKey,  ///< signed with another key
};
inline constexpr std::array<std::string_view, 4> kRefusalNames{"unsigned", "altered", "replayed", "of another key"};

/// Signs the messages of one sender. Not safe for concurrent use.
class MessageSigner {
 public:
  /// `sender`: random.
  MessageSigner(const MessageKey& key, int64_t sender);
  /// Appends payload and trailer to `out`.
  void sign(std::string_view channel, std::span<const uint8_t> payload, int64_t now_utime, std::vector<uint8_t>& out);

 private:
  MessageKey key_;
  std::array<uint8_t, 8> key_id_;
  int64_t sender_, counter_ = 0;
};

/// Checks signed messages. A message is accepted once, in the order of its sender's counter on its channel, and only
/// within `max_age_us` of the time at which its sender sent it, by both clocks. Not safe for concurrent use.
class MessageVerifier {
 public:
  MessageVerifier(const MessageKey& key, int64_t max_age_us);
  /// The payload, a view into `bytes`, or why the message is refused.
  std::variant<std::span<const uint8_t>, Refusal> verify(std::string_view channel, std::span<const uint8_t> bytes,
                                                         int64_t now_utime);
  /// By how much `now_utime` was later than the time of sending of the last message that was refused as replayed; 0
  /// when its counter was the reason.
  int64_t age_us() const { return age_us_; }

 private:
  struct Sender {
    int64_t id, counter, utime;  // of its newest message
  };
  [[nodiscard]] bool accept_once(std::string_view channel, const Sender& message, int64_t now_utime);

  MessageKey key_;
  std::array<uint8_t, 8> key_id_;
  int64_t max_age_us_, age_us_ = 0;
  std::map<std::string, std::vector<Sender>, std::less<>> senders_;  // by channel
};

}  // namespace multireach
