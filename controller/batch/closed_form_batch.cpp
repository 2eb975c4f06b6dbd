#include "controller/batch/closed_form_batch.hpp"

#include <limits>
#include <numbers>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "controller/batch/closed_form_batch.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "numeric/wide_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace multireach::controller {
namespace HWY_NAMESPACE {

using multireach::HWY_NAMESPACE::finite_arc_tangent;
using multireach::HWY_NAMESPACE::kWidth;
using multireach::HWY_NAMESPACE::Lanes;
using multireach::HWY_NAMESPACE::load;
using multireach::HWY_NAMESPACE::sine_and_cosine;

#include "controller/ik/closed_form.inl.hpp"

uint32_t nearest_postures_of(const ClosedFormArm& arm, IkQueries& queries) {
  uint32_t found = 0;
  for (int first = 0; first < kRowLanes; first += kWidth) {
    std::array<Lanes, 3> x_T;
    std::array<Lanes, 4> theta, posture;
    for (size_t k = 0; k < 3; ++k) x_T[k] = load(queries.x_T[k], first);
    for (size_t i = 0; i < 4; ++i) theta[i] = load(queries.theta[i], first);
    found |= bits_of(ClosedFormSearch<Lanes>(arm, x_T, theta).search(posture)) << first;
    for (size_t i = 0; i < 4; ++i) store(posture[i], queries.posture[i], first);
  }
  return found;
}

}  // namespace HWY_NAMESPACE
}  // namespace multireach::controller
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace multireach::controller {

HWY_EXPORT(nearest_postures_of);

uint32_t closed_form_batch(const ClosedFormIk& arm, IkQueries& queries) {
  return HWY_DYNAMIC_DISPATCH(nearest_postures_of)(arm.arm(), queries);
}

}  // namespace multireach::controller
#endif
