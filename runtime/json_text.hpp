#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace multireach {

/// JSON in one line. Bytes that are not UTF-8, e.g. of a file name, become U+FFFD: they would be an exception.
inline std::string json_text(const nlohmann::ordered_json& value) {
  return value.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace multireach
