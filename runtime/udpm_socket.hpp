#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace multireach {

/// The message in an LCM packet; nothing when it is damaged or one of several that hold a message. Views into the
/// packet.
struct UdpmMessage {
  std::string_view channel;
  std::span<const uint8_t> bytes;
};
std::optional<UdpmMessage> udpm_message_in(std::span<const uint8_t> packet);

/// Reads an LCM multicast group without LCM, for a program that needs no message at once: LCM's own receiving thread
/// wakes for every packet of the group. Messages wait in the kernel's buffer, which holds those of a tenth of a second
/// at least. Messages of more than one packet (64 kB) are ignored, and so are damaged packets.
class UdpmSocket {
 public:
  using Handler = std::function<void(const UdpmMessage&)>;

  /// Whether a URL names a multicast group: "udpm://ADDRESS:PORT?...", or a part of it, as LCM has it.
  static bool supports(const std::string& url);

  /// Joins the group. Throws InputError when that is not possible.
  explicit UdpmSocket(const std::string& url);
  ~UdpmSocket();
  UdpmSocket(const UdpmSocket&) = delete;
  UdpmSocket& operator=(const UdpmSocket&) = delete;

  /// Passes all messages that have arrived to `handler`, in the order of their arrival; returns without waiting.
  void drain(const Handler& handler);

 private:
  int socket_ = -1;
  std::vector<uint8_t> packet_;
};

}  // namespace multireach
