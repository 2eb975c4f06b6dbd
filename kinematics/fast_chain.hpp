#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <stdexcept>

#include "kinematics/chain.hpp"
#include "numeric/lanes.hpp"
#include "numeric/trigonometry.hpp"

namespace multireach {

#include "kinematics/fast_hand.inl.hpp"

/// A chain prepared for fast kinematics. Every joint frame is rotated so that its joint moves about or along z, and
/// every fixed rotation is split into Euler angles z-x-z; the rotations about z merge with the joint angles. A joint
/// then costs two plane rotations and one translation. Unlike Denavit-Hartenberg parameters, this form is well
/// conditioned for nearly parallel axes. `N` is the number of joints, or 0 for any number up to kMaxJoints. `Element`
/// is double, or a SIMD type with the same value in all lanes.
template <int N, class Element>
struct FastLinks {
  static constexpr int kCapacity = N == 0 ? kMaxJoints : N;
  /// Rotation about x after a joint: none, a quarter turn, or any angle. Most arms have right angles only.
  enum class Tilt : uint8_t { kNone, kQuarter, kAny };
  struct Link {
    Element offset;                      // added to the joint angle about z
    std::array<Element, 3> translation;  // to the next joint, in the frame after the rotation about z
    Element sine, cosine;                // of the tilt
    Tilt tilt = Tilt::kNone;
    bool is_prismatic = false;
    std::array<bool, 3> translates{};  // which elements of the translation may be non-zero
  };

  /// Throws std::invalid_argument when the chain does not have N joints. `tool` rotates the end effector's axes: the
  /// resulting rotations are R_WT * tool.
  explicit FastLinks(const Chain& chain, const Eigen::Matrix3d& tool = Eigen::Matrix3d::Identity());

  int size = 0;
  std::array<Link, kCapacity> links;
  std::array<std::array<Element, 3>, 3> base_rotation;  // columns
  std::array<Element, 3> base_position;
  Element tip_sine, tip_cosine;  // of the last rotation about z

 private:
  static Element all(double value) { return Element{} + value; }
};

/// Forward kinematics of a chain with N joints (0: any number). `Lanes` is double, or a SIMD type to compute one joint
/// configuration per lane.
template <int N, class Lanes>
class FastChain {
 public:
  static constexpr int kCapacity = FastLinks<N, Lanes>::kCapacity;
  using PerJoint = multireach::PerJoint<Lanes, kCapacity>;
  using Hand = FastHand<Lanes, kCapacity>;

  /// Throws like FastLinks.
  explicit FastChain(const Chain& chain, const Eigen::Matrix3d& tool = Eigen::Matrix3d::Identity())
      : links_(chain, tool) {}

  int size() const { return N == 0 ? links_.size : N; }

  /// K(theta) and its Jacobian; with `kRotation` also R_WT and the Jacobian's angular rows.
  template <bool kRotation>
  void forward_kinematics(const PerJoint& theta, Hand& hand) const {
    multireach::forward_kinematics<kRotation>(links_, size(), theta, hand);
  }

 private:
  FastLinks<N, Lanes> links_;
};

template <int N, class Element>
FastLinks<N, Element>::FastLinks(const Chain& chain, const Eigen::Matrix3d& tool) : size(chain.size()) {
  if (N != 0 && chain.size() != N) throw std::invalid_argument("the chain has another number of joints");
  constexpr double kExact = 1e-16;  // rad and m: smaller values count as zero
  const int n = chain.size();
  std::array<Eigen::Matrix3d, kCapacity> to_z;
  for (int i = 0; i < n; ++i) {
    to_z[i] = rotation_from_z(chain.joint(i).axis);
  }
  Eigen::Isometry3d first = chain.fixed(0);
  first.linear() = first.linear() * to_z[0];
  for (int k = 0; k < 3; ++k) {
    base_position[k] = all(first.translation()[k]);
    for (int column = 0; column < 3; ++column) base_rotation[column][k] = all(first.linear()(k, column));
  }
  double before = 0;  // second rotation about z of the previous transform
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
    Link& link = links[i];
    link.is_prismatic = chain.joint(i).type == Joint::Type::kPrismatic;
    link.offset = all(before + first_turn);
    link.tilt = tilt < kExact ? Tilt::kNone : std::abs(cosine) < kExact ? Tilt::kQuarter : Tilt::kAny;
    link.sine = all(sine);
    link.cosine = all(cosine);
    for (int k = 0; k < 3; ++k) {
      link.translation[k] = all(turned[k]);
      link.translates[k] = std::abs(turned[k]) > kExact || (link.is_prismatic && k == 2);
    }
    before = second_turn;
  }
  double sine, cosine;
  sine_and_cosine_of(before, sine, cosine);
  tip_sine = all(sine);
  tip_cosine = all(cosine);
}

}  // namespace multireach
