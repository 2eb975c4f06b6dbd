#include "runtime/tagged_message.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <optional>

#include "numeric/random.hpp"
#include "runtime/channels.hpp"
#include "tests/allocation_count.hpp"

namespace multireach {
namespace {

constexpr int64_t kNow = 1'800'000'000'000'000, kSender = 0x1122334455667788, kMaxAge = 1'000'000;
using Bytes = std::vector<uint8_t>;

MessageKey key(uint8_t first = 0) {
  MessageKey key;
  std::iota(key.bytes.begin(), key.bytes.end(), first);
  return key;
}

Bytes payload(size_t size) {
  Bytes bytes(size);
  for (size_t i = 0; i < size; ++i) bytes[i] = static_cast<uint8_t>(7 * i + 1);
  return bytes;
}

Bytes signed_by(MessageSigner& signer, std::string_view channel, const Bytes& bytes, int64_t utime = kNow) {
  Bytes out;
  signer.sign(channel, bytes, utime, out);
  return out;
}

/// The refusal, or nothing when the message is accepted with exactly this payload.
std::optional<Refusal> refusal_of(MessageVerifier& verifier, std::string_view channel, const Bytes& bytes,
                                  const Bytes& expected, int64_t now = kNow) {
  const auto result = verifier.verify(channel, bytes, now);
  if (const auto* refusal = std::get_if<Refusal>(&result)) return *refusal;
  EXPECT_TRUE(std::ranges::equal(std::get<std::span<const uint8_t>>(result), expected));
  return std::nullopt;
}

TEST(TaggedMessage, HasTheTrailerThatAnotherImplementationComputes) {
  MessageSigner signer(key(), kSender);
  const Bytes bytes = signed_by(signer, "TARGET", payload(20));
  ASSERT_EQ(bytes.size(), 20 + kTrailerSize);
  // Python: hashlib.blake2b(text, key=bytes(range(32)), digest_size=16), of b"multireach message 1" + b"TARGET" +
  // bytes([6]) + the 32 bytes of the fields + the payload; the key's identity of b"multireach key 1", 8 bytes.
  const Bytes expected{0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88, 0,    0,    0,    0,    0,    0,
                       0,    1,    0x00, 0x06, 0x65, 0x17, 0x28, 0x98, 0x80, 0x00, 0xb8, 0x5e, 0xfc, 0xa8,
                       0xb1, 0x38, 0x8f, 0xc5, 0xdb, 0xac, 0x25, 0xaa, 0x9a, 0xbb, 0x5f, 0xd9, 0x71, 0xee,
                       0xba, 0x7f, 0xde, 0xe7, 0x6a, 0x0c, 0x8d, 'm',  'r',  't',  'a',  'g',  0xc1, 0x01};
  EXPECT_EQ(Bytes(bytes.begin() + 20, bytes.end()), expected);
}

TEST(TaggedMessage, IsAcceptedOnceAndInOrder) {
  MessageSigner signer(key(), kSender);
  MessageVerifier verifier(key(), kMaxAge);
  const Bytes bytes = payload(100);
  std::vector<Bytes> sent;
  for (int i = 0; i < 3; ++i) sent.push_back(signed_by(signer, "TARGET", bytes));
  const Bytes other = signed_by(signer, "JOINT_SETPOINT", bytes), empty = signed_by(signer, "TARGET", {});
  EXPECT_EQ(refusal_of(verifier, "JOINT_SETPOINT", other, bytes), std::nullopt);
  EXPECT_EQ(refusal_of(verifier, "TARGET", sent[0], bytes), std::nullopt) << "each channel has its own order";
  EXPECT_EQ(refusal_of(verifier, "TARGET", sent[2], bytes), std::nullopt) << "one was lost";
  EXPECT_EQ(refusal_of(verifier, "TARGET", sent[2], bytes), Refusal::kReplayed);
  EXPECT_EQ(refusal_of(verifier, "TARGET", sent[1], bytes), Refusal::kReplayed);
  EXPECT_EQ(verifier.age_us(), 0);
  EXPECT_EQ(refusal_of(verifier, "TARGET", empty, {}), std::nullopt);
  MessageSigner restarted(key(), kSender + 1);
  EXPECT_EQ(refusal_of(verifier, "TARGET", signed_by(restarted, "TARGET", bytes), bytes), std::nullopt)
      << "another sender has a counter of its own";
}

TEST(TaggedMessage, OfAnEarlierTimeIsRefusedByAReceiverThatHasJustStarted) {
  MessageSigner signer(key(), kSender);
  MessageVerifier verifier(key(), kMaxAge);
  const Bytes bytes = payload(10), message = signed_by(signer, "TARGET", bytes);
  EXPECT_EQ(refusal_of(verifier, "TARGET", message, bytes, kNow + kMaxAge + 1), Refusal::kReplayed);
  EXPECT_EQ(verifier.age_us(), kMaxAge + 1);
  EXPECT_EQ(refusal_of(verifier, "TARGET", message, bytes, kNow - kMaxAge - 1), Refusal::kReplayed);
  EXPECT_EQ(verifier.age_us(), -kMaxAge - 1);
  EXPECT_EQ(refusal_of(verifier, "TARGET", message, bytes, kNow + kMaxAge), std::nullopt);
}

TEST(TaggedMessage, NoAlteredBitTruncationOtherChannelOrOtherKeyIsAccepted) {
  MessageSigner signer(key(), kSender), stranger(key(1), kSender);
  MessageVerifier verifier(key(), kMaxAge);
  const Bytes bytes = payload(60), message = signed_by(signer, "TARGET", bytes);
  const size_t key_begin = bytes.size() + 24, key_end = key_begin + 8, mark = message.size() - 8;
  for (size_t i = 0; i < message.size(); ++i) {
    const auto expected = i >= mark                       ? Refusal::kUnsigned
                          : i >= key_begin && i < key_end ? Refusal::kOtherKey
                                                          : Refusal::kAltered;
    for (int bit = 0; bit < 8; ++bit) {
      Bytes altered = message;
      altered[i] = static_cast<uint8_t>(altered[i] ^ 1 << bit);
      EXPECT_EQ(refusal_of(verifier, "TARGET", altered, bytes), expected) << "byte " << i << ", bit " << bit;
    }
  }
  for (size_t size = 0; size < message.size(); ++size)
    EXPECT_TRUE(refusal_of(verifier, "TARGET", Bytes(message.begin(), message.begin() + static_cast<int>(size)), bytes))
        << "truncated to " << size;
  for (const size_t removed : {size_t{0}, size_t{59}, size_t{60}, size_t{100}}) {
    Bytes shorter = message;
    shorter.erase(shorter.begin() + static_cast<int>(removed));
    EXPECT_TRUE(refusal_of(verifier, "TARGET", shorter, bytes));
  }
  EXPECT_EQ(refusal_of(verifier, "TARGETS", message, bytes), Refusal::kAltered);
  EXPECT_EQ(refusal_of(verifier, "JOINT_SETPOINT", message, bytes), Refusal::kAltered);
  EXPECT_EQ(refusal_of(verifier, "TARGET", bytes, bytes), Refusal::kUnsigned);
  EXPECT_EQ(refusal_of(verifier, "TARGET", signed_by(stranger, "TARGET", bytes), bytes), Refusal::kOtherKey);
  EXPECT_EQ(refusal_of(verifier, "TARGET", message, bytes), std::nullopt) << "none of these used up the counter";
}

TEST(TaggedMessage, RandomAlterationsAreRefused) {
  const char* number = std::getenv("MULTIREACH_ALTERED_MESSAGES");
  const uint64_t messages = number ? std::strtoull(number, nullptr, 10) : 5000;
  constexpr uint64_t kSeed = 7401;
  MessageSigner signer(key(), kSender);
  MessageVerifier verifier(key(), kMaxAge);
  std::array<int64_t, kRefusalNames.size()> refused{};
  for (uint64_t k = 0; k < messages && !HasFailure(); ++k) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", message " + std::to_string(k));
    const CounterRandom random(kSeed, k);
    uint64_t draw = 0;
    const auto below = [&](size_t bound) { return static_cast<size_t>(random.bits(draw++) % bound); };
    const Bytes bytes = payload(below(500));
    const std::string_view channel = channel::kAll[below(channel::kAll.size())];
    const Bytes message = signed_by(signer, channel, bytes);
    Bytes altered = message;
    std::string_view on = channel;
    switch (below(6)) {
      case 0:  // some bits
        for (size_t n = 1 + below(4); n > 0; --n) altered[below(altered.size())] ^= static_cast<uint8_t>(1 << below(8));
        break;
      case 1:  // random bytes in a row
        for (size_t at = below(altered.size()), n = 1 + below(32); n > 0 && at < altered.size(); --n)
          altered[at++] = static_cast<uint8_t>(below(256));
        break;
      case 2:
        altered.resize(below(altered.size()));
        break;
      case 3:
        altered.insert(altered.begin() + static_cast<int>(below(altered.size())), static_cast<uint8_t>(below(256)));
        break;
      case 4:
        on = channel::kAll[below(channel::kAll.size())];
        break;
      default: {  // the trailer of another message
        const Bytes other = signed_by(signer, channel, payload(below(500)));
        altered.resize(bytes.size());
        altered.insert(altered.end(), other.end() - static_cast<int>(kTrailerSize), other.end());
        if (other.size() == message.size()) altered = bytes;
      }
    }
    if (altered == message && on == channel) continue;
    const auto refusal = refusal_of(verifier, on, altered, bytes);
    ASSERT_TRUE(refusal);
    ++refused[static_cast<size_t>(*refusal)];
    if (k % 16 == 0) {
      EXPECT_EQ(refusal_of(verifier, channel, message, bytes), std::nullopt) << "the message itself";
    }
  }
  EXPECT_EQ(refused[static_cast<size_t>(Refusal::kReplayed)], 0) << "refused for another reason than the alteration";
  EXPECT_GT(refused[static_cast<size_t>(Refusal::kAltered)], static_cast<int64_t>(messages / 3));
}

TEST(TaggedMessage, ForgetsOldSendersButAcceptsNoneOfTheirMessagesAgain) {
  MessageVerifier verifier(key(), kMaxAge);
  const Bytes bytes = payload(8);
  std::vector<Bytes> sent;
  for (int64_t i = 0; i < 1000; ++i) {
    MessageSigner signer(key(), i);
    const int64_t now = kNow + i * kMaxAge / 10;
    sent.push_back(signed_by(signer, "BRIDGE_REQUEST", bytes, now));
    EXPECT_EQ(refusal_of(verifier, "BRIDGE_REQUEST", sent.back(), bytes, now), std::nullopt);
    for (size_t before = sent.size() > 80 ? sent.size() - 80 : 0; before < sent.size(); ++before)
      EXPECT_EQ(refusal_of(verifier, "BRIDGE_REQUEST", sent[before], bytes, now), Refusal::kReplayed) << before;
  }
}

TEST(TaggedMessage, SigningAndCheckingAllocateNothing) {
  MessageSigner signer(key(), kSender);
  MessageVerifier verifier(key(), kMaxAge);
  const Bytes bytes = payload(500);
  Bytes out;
  int64_t accepted = 0, before = 0;
  for (int i = 0; i < 100; ++i) {
    if (i == 1) before = testing::allocations().number;
    out.clear();
    signer.sign("JOINT_COMMAND", bytes, kNow, out);
    accepted += verifier.verify("JOINT_COMMAND", out, kNow).index() == 0;
  }
  EXPECT_EQ(testing::allocations().number, before);
  EXPECT_EQ(accepted, 100);
}

TEST(TaggedMessage, OnlyBytesWithTheMarkHaveATrailer) {
  MessageSigner signer(key(), kSender);
  const Bytes bytes = payload(100), message = signed_by(signer, "TARGET", bytes);
  EXPECT_TRUE(std::ranges::equal(without_trailer(message), bytes));
  EXPECT_TRUE(std::ranges::equal(without_trailer(bytes), bytes));
  const std::span<const uint8_t> tail = std::span(message).last(kTrailerSize - 1);
  EXPECT_EQ(without_trailer(tail).size(), tail.size()) << "shorter than a trailer";
}

}  // namespace
}  // namespace multireach
