#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "controller/collision/body.hpp"
#include "controller/collision/obstacle.hpp"
#include "kinematics/chain.hpp"

namespace multireach::controller {

/// Two surfaces that must not come nearer to each other than the margin.
struct ProximityPair {
  std::array<double, kMaxJoints> gradient;  ///< d distance / d theta_i, m/rad
  double clearance;                         ///< distance minus the margin, m; negative when too near
};

/// Distances between an arm's links (capsules) and obstacles, and among the links. FCL computes all but
/// those to boxes.
class Proximity {
 public:
  static constexpr int kMaxObstacles = 64;
  static constexpr int kMaxPairs = 64;

  /// Throws std::invalid_argument for an invalid body. Ignores pairs of links that overlap in most joint
  /// configurations, because their capsules are too thick for the arm.
  Proximity(const Chain& chain, const Body& body);
  Proximity(const Proximity& other);
  Proximity& operator=(const Proximity& other) { return *this = Proximity(other); }
  Proximity(Proximity&&) noexcept;
  Proximity& operator=(Proximity&&) noexcept;
  ~Proximity();

  const Body& body() const { return body_; }
  /// Replaces all obstacles. Returns how many were refused: not is_valid(), or beyond kMaxObstacles.
  int set_obstacles(std::span<const Obstacle> obstacles);
  std::span<const Obstacle> obstacles() const { return obstacles_; }
  /// Whether there is nothing to avoid: no body, or neither obstacles nor self-collision.
  bool nothing_to_avoid() const;

  /// The nearest pairs within query_distance_m plus the margin at `theta`, at most kMaxPairs. Valid until the next
  /// call.
  std::span<const ProximityPair> near_pairs(const Eigen::Ref<const Eigen::VectorXd>& theta);
  /// The smallest clearance of all pairs at `theta`; query_distance_m when all are further apart.
  double clearance(const Eigen::Ref<const Eigen::VectorXd>& theta);
  /// How many distances of two shapes the last near_pairs() or clearance() computed: its work.
  int distances() const { return distances_; }
  /// Moves `p` out of all obstacles, far enough that the end effector's capsule fits there.
  Eigen::Vector3d outside_obstacles(Eigen::Vector3d p) const;

 private:
  struct Shapes;
  void update_link_poses(const Eigen::Ref<const Eigen::VectorXd>& theta);
  template <class Visit>
  void visit_pairs(Visit&& visit);

  Chain chain_;
  Body body_;
  std::unique_ptr<Shapes> shapes_;
  std::vector<Obstacle> obstacles_;
  std::vector<ProximityPair> pairs_;
  int distances_ = 0;
};

}  // namespace multireach::controller
