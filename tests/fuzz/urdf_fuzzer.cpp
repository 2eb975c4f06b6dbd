// Any text as a URDF: a chain, or one sentence.
#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "kinematics/urdf_chain.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace multireach;
  try {
    const Chain chain = chain_from_urdf({reinterpret_cast<const char*>(data), size}, "torso", "right_hand");
    for (int i = 0; i < chain.size(); ++i) {
      if (!(chain.velocity()[i] > 0) || !(chain.lower()[i] <= chain.upper()[i])) std::abort();
    }
    static_cast<void>(chain.position(chain.clamped(JointVector::Zero(chain.size()))));
  } catch (const std::invalid_argument&) {
  }
  return 0;
}
