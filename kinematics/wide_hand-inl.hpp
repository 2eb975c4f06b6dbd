// Kinematics of several joint configurations at once: FastHand and forward_kinematics for the Lanes of
// numeric/wide_lanes-inl.hpp. Include it by the same rules as that file.
#if defined(MULTIREACH_KINEMATICS_WIDE_HAND_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef MULTIREACH_KINEMATICS_WIDE_HAND_INL_HPP
#undef MULTIREACH_KINEMATICS_WIDE_HAND_INL_HPP
#else
#define MULTIREACH_KINEMATICS_WIDE_HAND_INL_HPP
#endif

#include "kinematics/fast_chain.hpp"
#include "numeric/wide_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace multireach {
namespace HWY_NAMESPACE {

#include "kinematics/fast_hand.inl.hpp"

}  // namespace HWY_NAMESPACE
}  // namespace multireach
HWY_AFTER_NAMESPACE();

#endif
