#include "tools/log/import/chunk.hpp"

#include <bzlib.h>
#include <fmt/format.h>
#include <lz4frame.h>
#include <zstd.h>

#include <memory>
#include <new>
#include <optional>

#include "runtime/files.hpp"

namespace multireach {
namespace {

constexpr uint64_t kLargestChunk = uint64_t{1} << 30;  // bytes

/// Each fills `out` and returns the number of bytes that the data hold, or a larger number where they hold more, or
/// nothing where they are damaged.
std::optional<size_t> lz4(std::span<const uint8_t> data, std::span<uint8_t> out) {
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION))) throw std::bad_alloc();
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> owner(context,
                                                                                   LZ4F_freeDecompressionContext);
  size_t read = 0, written = 0;
  while (true) {
    size_t into = out.size() - written, from = data.size() - read;
    const size_t hint = LZ4F_decompress(context, out.data() + written, &into, data.data() + read, &from, nullptr);
    if (LZ4F_isError(hint)) return std::nullopt;
    read += from;
    written += into;
    if (hint == 0) return written;
    if (from == 0 && into == 0) return written == out.size() ? out.size() + 1 : std::optional<size_t>();
  }
}

std::optional<size_t> zstd(std::span<const uint8_t> data, std::span<uint8_t> out) {
  const size_t size = ZSTD_decompress(out.data(), out.size(), data.data(), data.size());
  return ZSTD_isError(size) ? std::optional<size_t>() : size;
}

std::optional<size_t> bz2(std::span<const uint8_t> data, std::span<uint8_t> out) {
  auto size = static_cast<unsigned>(out.size());
  char* const source = const_cast<char*>(reinterpret_cast<const char*>(data.data()));
  const int fault = BZ2_bzBuffToBuffDecompress(reinterpret_cast<char*>(out.data()), &size, source,
                                               static_cast<unsigned>(data.size()), 0, 0);
  return fault == BZ_OK ? std::optional<size_t>(size) : std::nullopt;
}

}  // namespace

std::vector<uint8_t> decompressed(std::string_view compression, std::span<const uint8_t> data, uint64_t size,
                                  const std::string& name) {
  if (size > kLargestChunk || data.size() > kLargestChunk)
    throw InputError(fmt::format("{}: has {} bytes when decompressed; at most 1 GB are read", name, size));
  const auto decompress = compression == "lz4"    ? lz4
                          : compression == "zstd" ? zstd
                          : compression == "bz2"  ? bz2
                                                  : nullptr;
  if (!decompress)
    throw InputError(fmt::format("{}: has the compression '{}'; expected none, lz4, zstd or bz2", name, compression));
  std::vector<uint8_t> bytes(size + 1);  // one byte more than expected tells of too many
  const auto found = decompress(data, bytes);
  if (!found) throw InputError(fmt::format("{}: its {} data are damaged", name, compression));
  if (*found != size)
    throw InputError(fmt::format("{}: its {} data have {} bytes; expected {}", name, compression, *found, size));
  bytes.pop_back();
  return bytes;
}

}  // namespace multireach
