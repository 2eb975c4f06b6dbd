#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace multireach {

/// The bytes of a compressed part of a recording. `compression`: "lz4" (frames), "zstd" or "bz2"; `name` says in errors
/// which part it is. Throws InputError when the data are damaged, the compression is unknown, `size` is not the true
/// size, or it is more than 1 GiB.
std::vector<uint8_t> decompressed(std::string_view compression, std::span<const uint8_t> data, uint64_t size,
                                  const std::string& name);

}  // namespace multireach
