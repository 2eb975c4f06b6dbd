#include "tools/page/access.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <random>

namespace multireach {
namespace {

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return lower;
}

/// Takes as long for every text of that length, so that the time tells nothing about the token.
bool same_secret(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (size_t i = 0; i < a.size(); ++i) difference |= static_cast<unsigned char>(a[i] ^ b[i]);
  return difference == 0;
}

}  // namespace

bool Access::allows_host(std::string_view header) const {
  const size_t colon = header.rfind(':');
  const std::string name = lower_case(header.substr(0, colon));
  if (colon != std::string_view::npos) {
    const std::string_view port = header.substr(colon + 1);
    if (port.empty() || port.find_first_not_of("0123456789") != std::string_view::npos) return false;
  }
  in_addr address{};
  return name == "localhost" || inet_pton(AF_INET, name.c_str(), &address) == 1 ||
         (!host.empty() && name == lower_case(host));
}

bool Access::allows_messages(std::string_view host_header, std::string_view origin, std::string_view query) const {
  constexpr std::string_view kScheme = "http://";
  if (!origin.starts_with(kScheme)) return false;
  if (lower_case(origin.substr(kScheme.size())) != lower_case(host_header)) return false;
  return allows_reading(host_header, query);
}

bool Access::allows_reading(std::string_view host_header, std::string_view query) const {
  constexpr std::string_view kToken = "token=";
  if (!allows_host(host_header) || token.empty() || !query.starts_with(kToken)) return false;
  query.remove_prefix(kToken.size());
  return same_secret(query.substr(0, query.find('&')), token);
}

std::string random_token() {
  std::random_device random;
  std::string token;
  for (int i = 0; i < 4; ++i) token += fmt::format("{:08x}", random());
  return token;
}

}  // namespace multireach
