#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace multireach {

/// A regular file as bytes in memory, read from disk when they are used.
class MappedFile {
 public:
  /// Throws InputError when the file cannot be opened or mapped.
  explicit MappedFile(const std::string& path);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  std::span<const uint8_t> bytes() const { return bytes_; }

 private:
  std::span<const uint8_t> bytes_;
};

}  // namespace multireach
