#include "runtime/channels.hpp"

#include <charconv>

namespace multireach::channel {

std::string image_url_for(std::string_view control_url) {
  constexpr std::string_view kUdp = "udpm://";
  constexpr int kDefaultPort = 7667;  // LCM's
  if (control_url == kControlUrl) return std::string(kImageUrl);
  if (!control_url.starts_with(kUdp)) return std::string(control_url);
  const std::string_view rest = control_url.substr(kUdp.size());
  const std::string_view group = rest.substr(0, rest.find('?')), options = rest.substr(group.size());
  const size_t colon = group.find(':');
  std::string_view address = group.substr(0, colon);
  if (address.empty()) address = "239.255.76.67";  // LCM's default group
  int port = kDefaultPort;
  if (colon != std::string_view::npos) std::from_chars(group.data() + colon + 1, group.data() + group.size(), port);
  return std::string(kUdp) + std::string(address) + ":" + std::to_string(port + 1) + std::string(options);
}

}  // namespace multireach::channel
