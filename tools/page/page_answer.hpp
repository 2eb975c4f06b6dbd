#pragma once

#include <string>

namespace multireach {

/// An answer over HTTP.
struct PageAnswer {
  int status = 200;  ///< 200, 204 (without body) or 400 (the body is a sentence)
  std::string type = "application/json";
  std::string body{};
};

}  // namespace multireach
