#include "runtime/udpm_socket.hpp"

#include <gtest/gtest.h>

#include "runtime/files.hpp"

namespace multireach {
namespace {

std::optional<UdpmMessage> message_in(const std::string& packet) {
  return udpm_message_in({reinterpret_cast<const uint8_t*>(packet.data()), packet.size()});
}

TEST(UdpmSocket, FindsChannelAndBytesOfAPacket) {
  using namespace std::string_literals;
  const std::string packet = "LC02\0\0\0\7TARGET\0\1\0\3"s;
  const auto message = message_in(packet);
  ASSERT_TRUE(message);
  EXPECT_EQ(message->channel, "TARGET");
  EXPECT_EQ(std::vector<uint8_t>(message->bytes.begin(), message->bytes.end()), (std::vector<uint8_t>{1, 0, 3}));
  const std::string empty = "LC02\0\0\0\7TARGET\0"s;
  EXPECT_TRUE(message_in(empty)) << "a message may be empty";
  for (size_t size = 0; size < empty.size(); ++size) EXPECT_FALSE(message_in(empty.substr(0, size))) << size;
  EXPECT_FALSE(message_in("LC03\0\0\0\7TARGET\0\1"s)) << "a part of a larger message";
  EXPECT_TRUE(message_in("LC02\0\0\0\7"s + std::string(63, 'x') + "\0"s));
  EXPECT_FALSE(message_in("LC02\0\0\0\7"s + std::string(64, 'x') + "\0"s)) << "LCM has no such channel";
}

TEST(UdpmSocket, KnowsWhichUrlsAreMulticastGroups) {
  for (const char* url : {"udpm://239.255.76.67:7667?ttl=0", "udpm://239.255.76.67:7667", "udpm://", "udpm://?ttl=1",
                          "udpm://239.1.2.3:99?recv_buf_size=4194304&ttl=0"})
    EXPECT_TRUE(UdpmSocket::supports(url)) << url;
  for (const char* url : {"", "memq://", "file://run.lcm", "tcpq://localhost:7700", "udpm://239.255.76.67:70000",
                          "udpm://239.255.76:7667", "udpm://host:7667"}) {
    EXPECT_FALSE(UdpmSocket::supports(url)) << url;
    EXPECT_THROW(UdpmSocket{url}, InputError) << url;
  }
}

}  // namespace
}  // namespace multireach
