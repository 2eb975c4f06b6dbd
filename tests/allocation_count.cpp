#include "tests/allocation_count.hpp"

#include <cstdlib>
#include <new>

namespace {
thread_local multireach::testing::AllocationCount count;
}

namespace multireach::testing {
AllocationCount allocations() {
  return count;
}
}  // namespace multireach::testing

void* operator new(std::size_t size) {
  ++count.number;
  count.bytes += static_cast<int64_t>(size);
  if (void* memory = std::malloc(size ? size : 1)) return memory;
  throw std::bad_alloc();
}
void* operator new[](std::size_t size) {
  return operator new(size);
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++count.number;
  count.bytes += static_cast<int64_t>(size);
  return std::malloc(size ? size : 1);
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete[](void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
  std::free(memory);
}
