#include "numeric/instruction_set.hpp"

#include <hwy/highway.h>

namespace multireach {

std::vector<std::string> available_instruction_sets() {
  std::vector<std::string> names;
  const int64_t chosen = hwy::SupportedTargets();
  hwy::SetSupportedTargetsForTest(0);
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) names.emplace_back(hwy::TargetName(target));
  if (hwy::SupportedTargets() != chosen) hwy::SetSupportedTargetsForTest(chosen);
  return names;
}

std::string active_instruction_set() {
  const int64_t available = hwy::SupportedTargets() & HWY_TARGETS;
  return hwy::TargetName(available & -available);
}

bool select_instruction_set(const std::string& name) {
  hwy::SetSupportedTargetsForTest(0);
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    if (name != hwy::TargetName(target)) continue;
    hwy::SetSupportedTargetsForTest(target);
    return true;
  }
  return false;
}

}  // namespace multireach
