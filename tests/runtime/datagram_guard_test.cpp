#include "runtime/datagram_guard.hpp"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>
#include <vector>

#include "numeric/random.hpp"

namespace multireach {
namespace {

using Bytes = std::vector<uint8_t>;

void put(Bytes& bytes, uint64_t value, int size) {
  for (int k = size - 1; k >= 0; --k) bytes.push_back(static_cast<uint8_t>(value >> (8 * k)));
}

void put(Bytes& bytes, const std::string& text) {
  bytes.insert(bytes.end(), text.begin(), text.end());
}

Bytes short_message(const std::string& channel_and_payload) {
  Bytes bytes;
  put(bytes, "LC02");
  put(bytes, 7, 4);
  put(bytes, channel_and_payload);
  return bytes;
}

struct Fragment {
  uint64_t size = 1000, offset = 0, number = 0, total = 2;
  std::string content = std::string("TARGET\0", 7) + std::string(500, 'x');
};

Bytes fragment(const Fragment& f) {
  Bytes bytes;
  put(bytes, "LC03");
  put(bytes, 7, 4);
  put(bytes, f.size, 4);
  put(bytes, f.offset, 4);
  put(bytes, f.number, 2);
  put(bytes, f.total, 2);
  put(bytes, f.content);
  return bytes;
}

TEST(DatagramGuard, AcceptsWhatLcmSends) {
  EXPECT_TRUE(acceptable_datagram(short_message(std::string("TARGET\0payload", 14))));
  EXPECT_TRUE(acceptable_datagram(short_message(std::string(63, 'c') + std::string(1, '\0'))));
  EXPECT_TRUE(acceptable_datagram(fragment({})));
  EXPECT_TRUE(acceptable_datagram(fragment({.offset = 500, .number = 1, .content = std::string(500, 'x')})));
  EXPECT_TRUE(acceptable_datagram(Bytes{1, 2, 3})) << "LCM ignores it";
}

TEST(DatagramGuard, RefusesWhatLcmWouldReadOrWriteBeyond) {
  EXPECT_FALSE(acceptable_datagram(short_message("a name without an end")));
  EXPECT_FALSE(acceptable_datagram(short_message(std::string(64, 'c') + std::string(1, '\0'))));
  const std::string content(500, 'x');
  EXPECT_FALSE(acceptable_datagram(fragment({.content = content}))) << "no channel";
  EXPECT_FALSE(acceptable_datagram(fragment({.offset = 501, .number = 1, .content = content})));
  EXPECT_FALSE(acceptable_datagram(fragment({.offset = 0xffffff00, .number = 1, .content = content})))
      << "offset and size overflow 32 bits";
  EXPECT_FALSE(acceptable_datagram(fragment({.number = 2, .total = 2, .content = content})));
  EXPECT_FALSE(acceptable_datagram(fragment({.size = 0xffffffff})));
  Bytes cut = fragment({});
  cut.resize(19);
  EXPECT_FALSE(acceptable_datagram(cut));
}

/// The definition of recvmsg in this process is the guard's, so that LCM calls it.
TEST(DatagramGuard, StandsBeforeEverySocketOfTheProcess) {
  int sockets[2];
  ASSERT_EQ(socketpair(AF_UNIX, SOCK_DGRAM, 0, sockets), 0);
  Bytes buffer(65535);
  iovec vector{buffer.data(), buffer.size()};
  msghdr header{};
  header.msg_iov = &vector;
  header.msg_iovlen = 1;
  const auto received = [&](const Bytes& sent) {
    EXPECT_EQ(send(sockets[0], sent.data(), sent.size(), 0), static_cast<ssize_t>(sent.size()));
    return recvmsg(sockets[1], &header, 0);
  };
  const int64_t before = dropped_datagrams();
  EXPECT_EQ(received(fragment({})), static_cast<ssize_t>(fragment({}).size()));
  EXPECT_EQ(dropped_datagrams(), before);
  EXPECT_EQ(received(fragment({.offset = 0xffffff00, .number = 1})), 0);
  EXPECT_EQ(dropped_datagrams(), before + 1);
  close(sockets[0]);
  close(sockets[1]);
}

/// What is accepted never reaches beyond the message's size, computed in 64 bits here.
TEST(DatagramGuard, NoMutationPassesThatWritesBeyondTheMessage) {
  constexpr uint64_t kSeed = 5;
  const CounterRandom random(kSeed);
  int accepted = 0;
  for (uint64_t k = 0; k < 200000; ++k) {
    Bytes bytes = fragment({.number = k % 3 == 0 ? 1u : 0u});
    for (uint64_t m = 0; m < 1 + k % 4; ++m) {
      const uint64_t bits = random.bits(4 * k + m);
      bytes[8 + bits % 20] = static_cast<uint8_t>(bits >> 32);
    }
    bytes.erase(bytes.end() - static_cast<int64_t>(random.bits(1000000 + k) % 520), bytes.end());
    if (!acceptable_datagram(bytes) || bytes.size() < 20) continue;
    ++accepted;
    const auto field = [&](size_t begin, size_t size) {
      uint64_t value = 0;
      for (size_t i = begin; i < begin + size; ++i) value = 256 * value + bytes[i];
      return value;
    };
    size_t data = 20;
    if (field(16, 2) == 0) {
      while (data < bytes.size() && bytes[data] != 0) ++data;
      ASSERT_LT(data++, bytes.size());
    }
    ASSERT_LE(field(12, 4) + bytes.size() - data, field(8, 4)) << "seed " << kSeed << ", case " << k;
  }
  EXPECT_GT(accepted, 1000);
}

}  // namespace
}  // namespace multireach
