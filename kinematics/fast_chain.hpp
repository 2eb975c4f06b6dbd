#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <stdexcept>

#include "kinematics/chain.hpp"
#include "kinematics/lanes.hpp"
#include "kinematics/trigonometry.hpp"

namespace multireach {

/// The kinematics of a chain, prepared for speed. Every joint frame is turned so that its joint moves about or along z,
/// and every fixed rotation is split into turns about z, x, z (Euler); the turns about z join the joint angles. A
/// joint then costs two plane rotations and one translation. Unlike Denavit and Hartenberg's this form has no trouble
/// with axes that are nearly parallel. `N` is the number of joints, or 0 for any number up to kMaxJoints.
///
/// `Lanes` is double, or a type of several doubles side by side for as many postures at once.
template <int N, class Lanes>
class FastChain {
 public:
  static constexpr int kCapacity = N == 0 ? kMaxJoints : N;
  using PerJoint = std::array<Lanes, kCapacity>;

  /// What a posture means for the hand. Rows of the Jacobian: 0-2 the velocity of T's origin, 3-5 the angular velocity,
  /// both in W.
  struct Hand {
    std::array<Lanes, 3> position;                 ///< p_WT, m
    std::array<std::array<Lanes, 3>, 3> rotation;  ///< columns of R_WT; valid when asked for
    std::array<PerJoint, 6> jacobian;              ///< rows 3-5 are valid when asked for
  };

  /// Throws std::invalid_argument when the chain has not N joints. `tool` turns the hand's axes: the rotations that
  /// come out are R_WT * tool.
  explicit FastChain(const Chain& chain, const Eigen::Matrix3d& tool = Eigen::Matrix3d::Identity());

  int size() const { return N == 0 ? size_ : N; }

  /// K(theta) and its Jacobian; with `kRotation` also the rotation and the angular rows.
  template <bool kRotation>
  void hand(const PerJoint& theta, Hand& hand) const;

 private:
  /// The turn about x after a joint. Most arms have right angles only.
  enum class Tilt : uint8_t { kNone, kQuarter, kAny };
  struct Link {
    Lanes offset;                      // of the angle about z
    std::array<Lanes, 3> translation;  // to the next joint, in the frame after the turn
    Lanes sine, cosine;                // of the tilt
    Tilt tilt = Tilt::kNone;
    bool slides = false;
    std::array<bool, 3> translates{};  // which elements of the translation are not zero
  };
  static Lanes all(double value) { return Lanes{} + value; }

  int size_ = 0;
  std::array<Link, kCapacity> links_;
  std::array<std::array<Lanes, 3>, 3> base_rotation_;  // columns
  std::array<Lanes, 3> base_position_;
  Lanes tip_sine_, tip_cosine_;  // of the last turn about z
};

template <int N, class Lanes>
FastChain<N, Lanes>::FastChain(const Chain& chain, const Eigen::Matrix3d& tool) : size_(chain.size()) {
  if (N != 0 && chain.size() != N) throw std::invalid_argument("the chain has another number of joints");
  constexpr double kExact = 1e-16;  // rad and m: what is smaller than the last digit of 1 is taken as zero
  const int n = chain.size();
  std::array<Eigen::Matrix3d, kCapacity> to_z;
  for (int i = 0; i < n; ++i) {
    to_z[i] = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), chain.joint(i).axis).toRotationMatrix();
  }
  Eigen::Isometry3d first = chain.fixed(0);
  first.linear() = first.linear() * to_z[0];
  for (int k = 0; k < 3; ++k) {
    base_position_[k] = all(first.translation()[k]);
    for (int column = 0; column < 3; ++column) base_rotation_[column][k] = all(first.linear()(k, column));
  }
  double before = 0;  // the turn about z left over from the transform before
  for (int i = 0; i < n; ++i) {
    const Eigen::Matrix3d after = i + 1 < n ? to_z[i + 1] : tool;
    const Eigen::Matrix3d R = to_z[i].transpose() * chain.fixed(i + 1).linear() * after;
    const Eigen::Vector3d t = to_z[i].transpose() * chain.fixed(i + 1).translation();
    // R = Rz(first_turn) Rx(tilt) Rz(second_turn).
    const double tilt_sine = std::sqrt(R(0, 2) * R(0, 2) + R(1, 2) * R(1, 2));
    const double first_turn = tilt_sine > kExact ? arc_tangent(R(0, 2), -R(1, 2)) : 0;
    const double tilt = arc_tangent(tilt_sine, R(2, 2));
    const Eigen::Matrix3d rest =
        (rotation_about(Eigen::Vector3d::UnitZ(), first_turn) * rotation_about(Eigen::Vector3d::UnitX(), tilt))
            .transpose() *
        R;
    const double second_turn = arc_tangent(rest(1, 0), rest(0, 0));
    const Eigen::Vector3d turned = rotation_about(Eigen::Vector3d::UnitZ(), -first_turn) * t;
    double sine, cosine;
    sine_and_cosine_of(tilt, sine, cosine);
    Link& link = links_[i];
    link.slides = chain.joint(i).type == Joint::Type::kPrismatic;
    link.offset = all(before + first_turn);
    link.tilt = tilt < kExact ? Tilt::kNone : std::abs(cosine) < kExact ? Tilt::kQuarter : Tilt::kAny;
    link.sine = all(sine);
    link.cosine = all(cosine);
    for (int k = 0; k < 3; ++k) {
      link.translation[k] = all(turned[k]);
      link.translates[k] = std::abs(turned[k]) > kExact || (link.slides && k == 2);
    }
    before = second_turn;
  }
  double sine, cosine;
  sine_and_cosine_of(before, sine, cosine);
  tip_sine_ = all(sine);
  tip_cosine_ = all(cosine);
}

template <int N, class Lanes>
template <bool kRotation>
inline void FastChain<N, Lanes>::hand(const PerJoint& theta, Hand& hand) const {
  const int n = size();
  PerJoint sine, cosine;
  for (int i = 0; i < n; ++i) {
    const Link& link = links_[i];
    sine_and_cosine(link.slides ? link.offset : theta[i] + link.offset, sine[i], cosine[i]);
  }
  std::array<Lanes, 3> x = base_rotation_[0], y = base_rotation_[1], z = base_rotation_[2], p = base_position_;
  std::array<PerJoint, 3> axis, origin;
  for (int i = 0; i < n; ++i) {
    const Link& link = links_[i];
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
      const Lanes along = link.slides ? theta[i] + link.translation[2] : link.translation[2];
      for (int k = 0; k < 3; ++k) p[k] += along * z[k];
    }
    if (link.tilt == Tilt::kQuarter) {  // the sine is 1: angles are between 0 and pi
      for (int k = 0; k < 3; ++k) {
        const Lanes tilted = z[k];
        z[k] = -y[k];
        y[k] = tilted;
      }
    } else if (link.tilt == Tilt::kAny) {
      for (int k = 0; k < 3; ++k) {
        const Lanes tilted = link.cosine * y[k] + link.sine * z[k];
        z[k] = link.cosine * z[k] - link.sine * y[k];
        y[k] = tilted;
      }
    }
  }
  hand.position = p;
  for (int i = 0; i < n; ++i) {
    if (links_[i].slides) {
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
      for (int i = 0; i < n; ++i) hand.jacobian[3 + k][i] = links_[i].slides ? Lanes{} : axis[k][i];
      hand.rotation[0][k] = tip_cosine_ * x[k] + tip_sine_ * y[k];
      hand.rotation[1][k] = tip_cosine_ * y[k] - tip_sine_ * x[k];
      hand.rotation[2][k] = z[k];
    }
  }
}

}  // namespace multireach
