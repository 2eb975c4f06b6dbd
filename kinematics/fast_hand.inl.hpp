// Include inside a namespace that has `sine_and_cosine` for Lanes; see numeric/sine_cosine.inl.hpp.

template <class Lanes, size_t kCapacity>
using PerJoint = std::array<Lanes, kCapacity>;

/// Pose and Jacobian of the end effector (the paper's hand). Rows of the Jacobian: 0-2 the velocity of T's origin, 3-5
/// the angular velocity, both in W.
template <class Lanes, size_t kCapacity>
struct FastHand {
  std::array<Lanes, 3> position;                       ///< p_WT, m
  std::array<std::array<Lanes, 3>, 3> rotation;        ///< columns of R_WT; valid only with kRotation
  std::array<PerJoint<Lanes, kCapacity>, 6> jacobian;  ///< rows 3-5 are valid only with kRotation
};

/// K(theta) and its Jacobian for the n joints of `arm` (a FastLinks); with `kRotation` also R_WT and the Jacobian's
/// angular rows.
template <bool kRotation, class Arm, class Lanes, size_t kCapacity>
inline void forward_kinematics(const Arm& arm, int n, const std::array<Lanes, kCapacity>& theta,
                               FastHand<Lanes, kCapacity>& hand) {
  PerJoint<Lanes, kCapacity> sine, cosine;
  for (int i = 0; i < n; ++i) {
    const auto& link = arm.links[i];
    sine_and_cosine(link.is_prismatic ? link.offset : theta[i] + link.offset, sine[i], cosine[i]);
  }
  std::array<Lanes, 3> x, y, z, p;
  for (int k = 0; k < 3; ++k) {
    x[k] = arm.base_rotation[0][k];
    y[k] = arm.base_rotation[1][k];
    z[k] = arm.base_rotation[2][k];
    p[k] = arm.base_position[k];
  }
  std::array<PerJoint<Lanes, kCapacity>, 3> axis, origin;
  for (int i = 0; i < n; ++i) {
    const auto& link = arm.links[i];
    for (int k = 0; k < 3; ++k) {
      axis[k][i] = z[k];
      origin[k][i] = p[k];
      const Lanes turned = cosine[i] * y[k] - sine[i] * x[k];
      x[k] = cosine[i] * x[k] + sine[i] * y[k];
      y[k] = turned;
    }
    if (link.translates[0]) {
      for (int k = 0; k < 3; ++k) p[k] += link.translation[0] * x[k];
    }
    if (link.translates[1]) {
      for (int k = 0; k < 3; ++k) p[k] += link.translation[1] * y[k];
    }
    if (link.translates[2]) {
      const Lanes along = link.is_prismatic ? theta[i] + link.translation[2] : link.translation[2];
      for (int k = 0; k < 3; ++k) p[k] += along * z[k];
    }
    if (link.tilt == Arm::Tilt::kQuarter) {  // the sine is 1, because tilts are between 0 and pi
      for (int k = 0; k < 3; ++k) {
        const Lanes tilted = z[k];
        z[k] = -y[k];
        y[k] = tilted;
      }
    } else if (link.tilt == Arm::Tilt::kAny) {
      for (int k = 0; k < 3; ++k) {
        const Lanes tilted = link.cosine * y[k] + link.sine * z[k];
        z[k] = link.cosine * z[k] - link.sine * y[k];
        y[k] = tilted;
      }
    }
  }
  hand.position = p;
  for (int i = 0; i < n; ++i) {
    if (arm.links[i].is_prismatic) {
      for (int k = 0; k < 3; ++k) hand.jacobian[k][i] = axis[k][i];
      continue;
    }
    const Lanes dx = p[0] - origin[0][i], dy = p[1] - origin[1][i], dz = p[2] - origin[2][i];
    hand.jacobian[0][i] = axis[1][i] * dz - axis[2][i] * dy;
    hand.jacobian[1][i] = axis[2][i] * dx - axis[0][i] * dz;
    hand.jacobian[2][i] = axis[0][i] * dy - axis[1][i] * dx;
  }
  if constexpr (kRotation) {
    for (int k = 0; k < 3; ++k) {
      for (int i = 0; i < n; ++i) hand.jacobian[3 + k][i] = arm.links[i].is_prismatic ? Lanes{} : axis[k][i];
      hand.rotation[0][k] = arm.tip_cosine * x[k] + arm.tip_sine * y[k];
      hand.rotation[1][k] = arm.tip_cosine * y[k] - arm.tip_sine * x[k];
      hand.rotation[2][k] = z[k];
    }
  }
}
