#pragma once

#include <cstdint>

namespace multireach::testing {

/// Heap allocations through operator new by this thread, since the program's start.
struct AllocationCount {
  int64_t number = 0;
  int64_t bytes = 0;
};
AllocationCount allocations();

}  // namespace multireach::testing
