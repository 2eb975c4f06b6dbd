#pragma once

#include <functional>
#include <string>

#include "runtime/files.hpp"

namespace multireach::testing {

/// The sentence of the InputError that `action` throws; "" if it throws none.
inline std::string input_fault(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace multireach::testing
