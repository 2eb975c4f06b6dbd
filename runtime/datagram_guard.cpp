#include "runtime/datagram_guard.hpp"

#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstddef>

namespace multireach {
namespace {

constexpr uint32_t kShortMagic = 0x4c433032;     // "LC02"
constexpr uint32_t kFragmentMagic = 0x4c433033;  // "LC03"
constexpr size_t kShortHeader = 8, kFragmentHeader = 20;
constexpr size_t kMaxChannel = 63;                    // characters, of LCM
constexpr uint64_t kMaxMessage = uint64_t{64} << 20;  // bytes: more than two raw images of any camera

std::atomic<int64_t> dropped{0};

uint64_t big_endian(std::span<const uint8_t> bytes) {
  uint64_t value = 0;
  for (const uint8_t byte : bytes) value = value << 8 | byte;
  return value;
}

/// Length of the channel's name at the beginning of `bytes` with its terminating zero; 0 if it has none.
size_t channel_length(std::span<const uint8_t> bytes) {
  const auto searched = bytes.first(std::min(bytes.size(), kMaxChannel + 1));
  const auto end = std::find(searched.begin(), searched.end(), 0);
  return end == searched.end() ? 0 : static_cast<size_t>(end - searched.begin()) + 1;
}

}  // namespace

bool acceptable_datagram(std::span<const uint8_t> datagram) {
  if (datagram.size() < kShortHeader) return true;
  const uint64_t magic = big_endian(datagram.first(4));
  if (magic == kShortMagic) return channel_length(datagram.subspan(kShortHeader)) > 0;
  if (magic != kFragmentMagic) return true;
  if (datagram.size() < kFragmentHeader) return false;
  const uint64_t message_size = big_endian(datagram.subspan(8, 4)), offset = big_endian(datagram.subspan(12, 4));
  const uint64_t fragment = big_endian(datagram.subspan(16, 2)), fragments = big_endian(datagram.subspan(18, 2));
  const auto content = datagram.subspan(kFragmentHeader);
  const size_t channel = fragment == 0 ? channel_length(content) : 0;
  if (fragment == 0 && channel == 0) return false;
  return fragment < fragments && message_size <= kMaxMessage && offset + content.size() - channel <= message_size;
}

int64_t dropped_datagrams() {
  return dropped.load(std::memory_order_relaxed);
}

}  // namespace multireach

/// Takes the place of the C library's function in this process. A datagram that is not acceptable is returned as one of
/// zero bytes, which LCM ignores.
extern "C" __attribute__((visibility("default"))) ssize_t recvmsg(int socket, msghdr* message, int flags) {
  const ssize_t size = syscall(SYS_recvmsg, socket, message, flags);
  if (size <= 0 || message->msg_iovlen != 1) return size;
  const iovec& buffer = message->msg_iov[0];
  const size_t length = std::min(static_cast<size_t>(size), buffer.iov_len);
  if (multireach::acceptable_datagram({static_cast<const uint8_t*>(buffer.iov_base), length})) return size;
  multireach::dropped.fetch_add(1, std::memory_order_relaxed);
  return 0;
}
