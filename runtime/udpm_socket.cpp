#include "runtime/udpm_socket.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <regex>

#include "runtime/files.hpp"

namespace multireach {
namespace {

constexpr size_t kMaxPacket = 65536;
constexpr size_t kHeader = 8;            // "LC02" and the sender's number of the packet
constexpr size_t kMaxChannelName = 63;   // LCM_MAX_CHANNEL_NAME_LENGTH
constexpr int kReceiveBuffer = 4194304;  // bytes; the kernel may grant less
constexpr int kMaxPackets = 20000;       // in one drain, so that a flood cannot hold it up

std::optional<sockaddr_in> group_of(const std::string& url) {
  static const std::regex kUrl(R"(udpm://([0-9.]*)(?::([0-9]{1,5}))?(?:\?.*)?)");
  std::smatch parts;
  if (!std::regex_match(url, parts, kUrl)) return std::nullopt;
  const std::string address = parts[1].length() > 0 ? parts[1].str() : "239.255.76.67";
  const int port = parts[2].matched ? std::stoi(parts[2]) : 7667;
  sockaddr_in group{};
  group.sin_family = AF_INET;
  group.sin_port = htons(static_cast<uint16_t>(port));
  if (port > 65535 || inet_pton(AF_INET, address.c_str(), &group.sin_addr) != 1) return std::nullopt;
  return group;
}

}  // namespace

std::optional<UdpmMessage> udpm_message_in(std::span<const uint8_t> packet) {
  static constexpr std::string_view kMagic = "LC02";
  if (packet.size() < kHeader || !std::equal(kMagic.begin(), kMagic.end(), packet.begin())) return std::nullopt;
  const auto text = packet.subspan(kHeader);
  const auto end = std::ranges::find(text, uint8_t{0});
  const auto length = static_cast<size_t>(end - text.begin());
  if (end == text.end() || length > kMaxChannelName) return std::nullopt;
  return UdpmMessage{{reinterpret_cast<const char*>(text.data()), length}, text.subspan(length + 1)};
}

bool UdpmSocket::supports(const std::string& url) {
  return group_of(url).has_value();
}

UdpmSocket::UdpmSocket(const std::string& url) : packet_(kMaxPacket) {
  const auto group = group_of(url);
  if (!group) throw InputError("'" + url + "' is not udpm://ADDRESS:PORT");
  socket_ = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const int yes = 1;
  ip_mreq membership{};
  membership.imr_multiaddr = group->sin_addr;
  setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &kReceiveBuffer, sizeof kReceiveBuffer);
  // Bound to the group's address, the socket gets no packets of other groups on the same port.
  if (socket_ >= 0 && bind(socket_, reinterpret_cast<const sockaddr*>(&*group), sizeof *group) == 0 &&
      setsockopt(socket_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership) == 0) {
    return;
  }
  const std::string reason = std::strerror(errno);
  if (socket_ >= 0) ::close(socket_);
  throw InputError(
      "the multicast group of '" + url + "' cannot be joined (" + reason +
      "); without a network, multicast needs a route:  ip link set lo up; ip route add 224.0.0.0/4 dev lo");
}

UdpmSocket::~UdpmSocket() {
  ::close(socket_);
}

void UdpmSocket::drain(const Handler& handler) {
  for (int packets = 0; packets < kMaxPackets; ++packets) {
    const ssize_t got = recv(socket_, packet_.data(), packet_.size(), 0);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return;
    if (const auto message = udpm_message_in({packet_.data(), static_cast<size_t>(got)})) handler(*message);
  }
}

}  // namespace multireach
