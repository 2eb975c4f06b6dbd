#include "runtime/message_gate.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>

#include "runtime/channels.hpp"
#include "runtime/files.hpp"
#include "runtime/key_file.hpp"
#include "runtime/log_file.hpp"
#include "tests/input_fault.hpp"
#include "tests/temporary_folder.hpp"

namespace multireach {
namespace {

using Bytes = std::vector<uint8_t>;

class Keys : public ::testing::Test {
 protected:
  Keys() { write_key_file(path("key"), random_message_key()); }
  std::string path(const std::string& name) const { return folder_ / name; }
  std::string policy(const std::string& text) const {
    std::ofstream(path("policy.yaml")) << text;
    return path("policy.yaml");
  }
  static Bytes sent_by(MessageGate& gate, std::string_view channel, const Bytes& payload) {
    Bytes sent;
    gate.outgoing(channel, payload, [&](std::span<const uint8_t> bytes) { sent.assign(bytes.begin(), bytes.end()); });
    return sent;
  }
  static bool accepts(MessageGate& gate, std::string_view channel, const Bytes& bytes) {
    const auto payload = gate.incoming(channel, bytes);
    if (payload) {
      EXPECT_TRUE(std::ranges::equal(*payload, kPayload));
    }
    return payload.has_value();
  }

  static inline const Bytes kPayload{1, 2, 3, 4, 5, 6, 7, 8};
  const testing::TemporaryFolder folder_;
};

TEST_F(Keys, AFileIsOneLineThatIsReadAgainAndNeverReplaced) {
  struct stat status {};
  ASSERT_EQ(stat(path("key").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600U);
  const MessageKey key = read_key_file(path("key"));
  EXPECT_EQ(text_of(key) + "\n", read_text_file(path("key")));
  EXPECT_EQ(key_in("  " + text_of(key) + "\r\n", "text").bytes, key.bytes);
  EXPECT_NE(random_message_key().bytes, key.bytes);
  EXPECT_EQ(testing::input_fault([&] { write_key_file(path("key"), key); }),
            path("key") + ": exists already and is not replaced");
  EXPECT_EQ(read_key_file(path("key")).bytes, key.bytes);
  EXPECT_EQ(testing::input_fault([&] { write_key_file(path("none/key"), key); }),
            path("none/key") + ": cannot be created (No such file or directory)");
  MessageKey counted;
  for (size_t i = 0; i < counted.bytes.size(); ++i) counted.bytes[i] = static_cast<uint8_t>(i);
  // The checksum: the first four bytes of BLAKE2b-128 of the text before it, by Python's hashlib.
  EXPECT_EQ(text_of(counted),
            "multireach-key-1:000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f:b072c462");
}

TEST_F(Keys, AFileThatOthersMayReadIsRefused) {
  for (const mode_t mode : {0640U, 0604U, 0620U, 0610U}) {
    ASSERT_EQ(chmod(path("key").c_str(), mode), 0);
    EXPECT_EQ(testing::input_fault([&] { MessageGate(path("key"), ""); }),
              path("key") + ": other users can access this key; to make it private:  chmod 600 " + path("key"));
  }
  ASSERT_EQ(chmod(path("key").c_str(), 0400), 0);
  EXPECT_EQ(testing::input_fault([&] { MessageGate(path("key"), ""); }), "");
  EXPECT_EQ(testing::input_fault([&] { MessageGate(path("none"), ""); }),
            path("none") + ": cannot be opened (No such file or directory)");
}

TEST_F(Keys, EveryMistakeInTheLineIsFound) {
  const std::string text = text_of(read_key_file(path("key")));
  for (size_t i = 0; i < text.size(); ++i) {
    std::string wrong = text;
    wrong[i] = wrong[i] == 'a' ? 'b' : 'a';
    EXPECT_FALSE(testing::input_fault([&] { key_in(wrong, "text"); }).empty()) << wrong;
    EXPECT_FALSE(testing::input_fault([&] { key_in(text.substr(0, i), "text"); }).empty()) << i;
  }
  EXPECT_EQ(testing::input_fault([&] { key_in(text + "0", "text"); }),
            "text: the key is damaged: its checksum does not match; copy the whole line again");
  EXPECT_EQ(testing::input_fault([&] { key_in("no key", "text"); }),
            "text: holds no key; expected one line that multireach-key made");
}

TEST_F(Keys, WithoutOneMessagesLeaveUnchangedAndSignedOnesAreRead) {
  MessageGate with(path("key"), ""), without("", "");
  EXPECT_FALSE(without.has_key());
  EXPECT_EQ(sent_by(without, channel::kTarget, kPayload), kPayload);
  EXPECT_TRUE(accepts(without, channel::kTarget, kPayload));
  EXPECT_TRUE(accepts(without, channel::kTarget, sent_by(with, channel::kTarget, kPayload)));
  EXPECT_EQ(without.total_refused(), 0);
  EXPECT_EQ(testing::input_fault([&] { MessageGate("", policy("max_age_s: 2")); }),
            "--key-policy: is only allowed with --key");
}

TEST_F(Keys, SignAllChannelsOfThisProjectAndNoOthers) {
  MessageGate sender(path("key"), ""), receiver(path("key"), "");
  for (const std::string_view channel : channel::kAll) {
    EXPECT_FALSE(accepts(receiver, channel, kPayload)) << channel;
    EXPECT_TRUE(accepts(receiver, channel, sent_by(sender, channel, kPayload))) << channel;
  }
  EXPECT_EQ(receiver.refused(), (RefusalCounts{channel::kAll.size(), 0, 0, 0}));
  for (const std::string_view channel : {"IIWA_COMMAND", "PANDA_STATUS", "MINE"}) {
    EXPECT_EQ(sent_by(sender, channel, kPayload), kPayload);
    EXPECT_TRUE(accepts(receiver, channel, kPayload));
  }
}

TEST_F(Keys, APolicySaysForEachChannelWhatMustBeSigned) {
  const std::string file = policy("signed: [MINE]\noptional: [TARGET]\nplain: [OBSTACLES]\nmax_age_s: 60\n");
  MessageGate sender(path("key"), file), receiver(path("key"), file);
  EXPECT_FALSE(accepts(receiver, "MINE", kPayload));
  EXPECT_TRUE(accepts(receiver, "MINE", sent_by(sender, "MINE", kPayload)));
  EXPECT_TRUE(accepts(receiver, "TARGET", kPayload));
  Bytes target = sent_by(sender, "TARGET", kPayload);
  EXPECT_TRUE(accepts(receiver, "TARGET", target));
  EXPECT_FALSE(accepts(receiver, "TARGET", target)) << "a signed one is checked";
  EXPECT_EQ(sent_by(sender, "OBSTACLES", kPayload), kPayload);
  EXPECT_TRUE(accepts(receiver, "OBSTACLES", kPayload));
  EXPECT_FALSE(accepts(receiver, "JOINT_SETPOINT", kPayload)) << "as by default";
  EXPECT_EQ(text_of(receiver.refused()), "; refused: 2 unsigned, 1 replayed");
}

TEST_F(Keys, MistakesInAPolicyAreNamed) {
  EXPECT_EQ(testing::input_fault([&] { KeyPolicy::load(policy("plain: [TARGET]\noptional: [X, TARGET]")); }),
            path("policy.yaml") +
                ":2: key 'optional' expected no channel that another list has; "
                "'TARGET' is also in 'plain'");
  EXPECT_NE(testing::input_fault([&] { KeyPolicy::load(policy("plane: [TARGET]")); }).find("key 'plane' is not known"),
            std::string::npos);
  EXPECT_NE(testing::input_fault([&] { KeyPolicy::load(policy("max_age_s: 0")); }).find("number from 0.001 to 86400"),
            std::string::npos);
  EXPECT_NE(testing::input_fault([&] {
              KeyPolicy::load(policy("plain: [" + std::string(64, 'X') + "]"));
            }).find("63 characters"),
            std::string::npos);
}

TEST_F(Keys, TheStateInNodeStatusNamesTheRefusals) {
  const RefusalCounts counts{12, 0, 3, 1};
  const std::string state = "holding" + text_of(counts);
  EXPECT_EQ(state, "holding; refused: 12 unsigned, 3 replayed, 1 of another key");
  EXPECT_EQ(refusals_in(state), counts);
  EXPECT_EQ(text_of(RefusalCounts{}), "");
  for (const std::string other : {"", "holding", "; refused: ", "; refused: x unsigned", "; refused: -1 altered",
                                  "; refused: 5", "; refused: 99999999999999999999 altered"})
    EXPECT_EQ(refusals_in(other), RefusalCounts{}) << other;
}

TEST_F(Keys, LogsHoldWhatWasSentAndReadersSeeThePayload) {
  MessageGate gate(path("key"), "");
  const Bytes sent = sent_by(gate, "TARGET", kPayload);
  LogWriter writer(path("log"));
  writer.write(1000, "TARGET", sent);
  writer.write(2000, "TARGET", kPayload);
  writer.close();
  LogReader reader(path("log"));
  const auto first = reader.next(), second = reader.next();
  ASSERT_TRUE(first && second);
  EXPECT_TRUE(std::ranges::equal(first->data, kPayload));
  EXPECT_TRUE(std::ranges::equal(first->recorded, sent));
  EXPECT_TRUE(std::ranges::equal(second->data, kPayload));
  EXPECT_TRUE(std::ranges::equal(second->recorded, kPayload));
}

}  // namespace
}  // namespace multireach
