#include "runtime/mapped_file.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include "runtime/files.hpp"

namespace multireach {

MappedFile::MappedFile(const std::string& path) {
  size_t size = 0;
  const int file = open_regular_file(path, size);
  void* const map = size > 0 ? mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file, 0) : nullptr;
  ::close(file);
  if (map == MAP_FAILED) throw InputError(path + ": cannot be read");
  bytes_ = {static_cast<const uint8_t*>(map), size};
}

MappedFile::~MappedFile() {
  if (!bytes_.empty()) munmap(const_cast<uint8_t*>(bytes_.data()), bytes_.size());
}

}  // namespace multireach
