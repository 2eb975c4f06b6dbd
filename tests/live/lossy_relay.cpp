// Connects two network interfaces as a link would that delays every packet and loses some, the same ones (by their
// number) for the same seed. Ends on SIGTERM, and prints what passed. Linux only: packet sockets.
#include <arpa/inet.h>
#include <linux/if_packet.h>
#include <net/ethernet.h>
#include <net/if.h>
#include <poll.h>
#include <sched.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <stdexcept>
#include <string>
#include <vector>

#include "numeric/random.hpp"

namespace multireach {
namespace {

volatile std::sig_atomic_t ended = 0;

int64_t now_us() {
  using namespace std::chrono;
  return duration_cast<microseconds>(steady_clock::now().time_since_epoch()).count();
}

/// The kernel's side of a virtual cable: it receives what is sent there, and what it sends is received there.
class Port {
 public:
  explicit Port(const std::string& interface) : socket_(::socket(AF_PACKET, SOCK_RAW, 0)) {
    const int yes = 1;
    // With the header of virtual networks, checksums that the sender left to its hardware stay valid.
    if (setsockopt(socket_, SOL_PACKET, PACKET_VNET_HDR, &yes, sizeof yes) != 0 ||
        setsockopt(socket_, SOL_PACKET, PACKET_IGNORE_OUTGOING, &yes, sizeof yes) != 0)
      throw std::runtime_error("packet socket: " + std::string(std::strerror(errno)));
    sockaddr_ll address{};
    address.sll_family = AF_PACKET;
    address.sll_protocol = htons(ETH_P_ALL);
    address.sll_ifindex = static_cast<int>(if_nametoindex(interface.c_str()));
    if (bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
      throw std::runtime_error(interface + ": " + std::strerror(errno));
  }
  Port(const Port&) = delete;
  ~Port() { close(socket_); }

  int socket() const { return socket_; }
  /// The next packet; empty when there is none, also while the interface is down.
  std::vector<char> receive() {
    const ssize_t size = recv(socket_, buffer_.data(), buffer_.size(), MSG_DONTWAIT);
    return {buffer_.begin(), buffer_.begin() + std::max<ssize_t>(size, 0)};
  }
  void send(const std::vector<char>& packet) const {
    static_cast<void>(::send(socket_, packet.data(), packet.size(), MSG_DONTWAIT));
  }

 private:
  int socket_;
  std::vector<char> buffer_ = std::vector<char>(1 << 17);
};

/// One direction of the link.
struct Direction {
  Port &from, &to;
  CounterRandom random;
  std::deque<std::pair<int64_t, std::vector<char>>> waiting{};  // with the time when they leave
  uint64_t packets = 0, lost = 0;
  int64_t latest_us = 0;  // the longest time beyond the delay

  void receive(double loss, int64_t delay_us) {
    for (auto packet = from.receive(); !packet.empty(); packet = from.receive()) {
      if (random.uniform(packets++) < loss) {
        ++lost;
      } else {
        waiting.emplace_back(now_us() + delay_us, std::move(packet));
      }
    }
  }
  void send() {
    for (; !waiting.empty() && waiting.front().first <= now_us(); waiting.pop_front()) {
      latest_us = std::max(latest_us, now_us() - waiting.front().first);
      to.send(waiting.front().second);
    }
  }
};

int run(const std::array<std::string, 2>& interfaces, double loss, double delay_ms, uint64_t seed) {
  const sched_param priority{.sched_priority = 45};  // above the bridge's; where it is not allowed, without
  sched_setscheduler(0, SCHED_FIFO, &priority);
  std::signal(SIGTERM, [](int) { ended = 1; });
  Port a(interfaces[0]), b(interfaces[1]);
  std::array<Direction, 2> directions{
      {{.from = a, .to = b, .random = CounterRandom(seed, 0)}, {.from = b, .to = a, .random = CounterRandom(seed, 1)}}};
  std::array<pollfd, 2> sockets{{{a.socket(), POLLIN, 0}, {b.socket(), POLLIN, 0}}};
  while (!ended) {
    int64_t wait_us = 100000;
    for (const Direction& direction : directions) {
      if (!direction.waiting.empty()) wait_us = std::min(wait_us, direction.waiting.front().first - now_us());
    }
    const timespec wait{0, std::max<int64_t>(wait_us, 0) * 1000};
    ppoll(sockets.data(), sockets.size(), &wait, nullptr);
    for (Direction& direction : directions) direction.receive(loss, static_cast<int64_t>(delay_ms * 1e3));
    for (Direction& direction : directions) direction.send();
  }
  for (size_t i = 0; i < 2; ++i) {
    std::printf("from %s: packets %llu, lost %llu, late by up to %lld us\n", interfaces[i].c_str(),
                static_cast<unsigned long long>(directions[i].packets),
                static_cast<unsigned long long>(directions[i].lost), static_cast<long long>(directions[i].latest_us));
  }
  return 0;
}

}  // namespace
}  // namespace multireach

int main(int argc, char** argv) {
  if (argc != 6) {
    std::fprintf(stderr, "Usage: %s INTERFACE INTERFACE LOSS DELAY_MS SEED\n", argv[0]);
    return 2;
  }
  try {
    return multireach::run({argv[1], argv[2]}, std::atof(argv[3]), std::atof(argv[4]),
                           std::strtoull(argv[5], nullptr, 10));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", argv[0], error.what());
    return 1;
  }
}
