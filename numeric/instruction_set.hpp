#pragma once

#include <string>
#include <vector>

namespace multireach {

/// The instruction set that SIMD code uses on this processor, e.g. "AVX3" (Highway's names).
std::string active_instruction_set();
/// All instruction sets that are compiled in and available on this processor, the widest first. Do not call this while
/// SIMD code runs in other threads.
std::vector<std::string> available_instruction_sets();
/// Selects an instruction set for all SIMD code of the process, for tests; "" selects the widest. Returns false, and
/// selects the widest, when it is not one of available_instruction_sets(). Do not call this while SIMD code runs in
/// other threads.
bool select_instruction_set(const std::string& name);

}  // namespace multireach
