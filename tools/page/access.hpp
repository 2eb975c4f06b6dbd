#pragma once

#include <string>
#include <string_view>

namespace multireach {

/// Who may talk to the server of the page. A page of another site that the user's browser has open reaches this
/// server's address, too: it is refused by `Host` (names that were made to point here) and `Origin`, and lacks the
/// token.
struct Access {
  std::string token{};  ///< of the page's address
  std::string host{};   ///< a further name of this computer that browsers may use; "" for none

  /// Whether a request with this header `Host` (a name or address, with or without port) is answered: addresses,
  /// localhost and `host` are.
  bool allows_host(std::string_view header) const;
  /// Whether a connection for messages is accepted: its page came from this server, and it knows the token. `query`:
  /// of the address, as "token=...". Headers are empty where they are missing.
  bool allows_messages(std::string_view host_header, std::string_view origin, std::string_view query) const;
  /// Whether a request that only reads is answered: it knows the token. Browsers send no `Origin` with it from the page
  /// itself, and let no other page read the answer.
  bool allows_reading(std::string_view host_header, std::string_view query) const;
};

/// 32 random hexadecimal digits.
std::string random_token();

}  // namespace multireach
