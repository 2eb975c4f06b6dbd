#pragma once

#include "controller/guarded_settings.hpp"
#include "kinematics/fast_chain.hpp"

namespace multireach::controller {

/// What is the same for all arms of a batch.
struct GuardedPlan {
  FastLinks<0, double> arm;
  GuardedSettings settings;
};

}  // namespace multireach::controller
