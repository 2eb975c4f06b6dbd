#pragma once

#include <cstdio>
#include <string>

#include "runtime/files.hpp"

namespace multireach {

/// One of several parts of a long computation, which other processes or computers may do: `index` of `count`, from 0.
struct Shard {
  int64_t index = 0, count = 1;

  /// The first item of this part of `items`; the part ends where the next one begins.
  int64_t begin(int64_t items) const { return items * index / count; }
  int64_t end(int64_t items) const { return items * (index + 1) / count; }
};

/// Reads "i/n" of the option --shard. Throws InputError.
inline Shard shard_from(const std::string& text) {
  long long index = 0, count = 0;
  int end = 0;
  if (std::sscanf(text.c_str(), "%lld/%lld%n", &index, &count, &end) != 2 || end != static_cast<int>(text.size()) ||
      count < 1 || count > 1000000 || index < 0 || index >= count) {
    throw InputError("--shard is '" + text + "'; expected i/n with 0 <= i < n, as 0/8");
  }
  return {index, count};
}

}  // namespace multireach
