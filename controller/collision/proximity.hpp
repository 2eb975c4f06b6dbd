#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "controller/collision/body.hpp"
#include "controller/collision/obstacle.hpp"
#include "kinematics/chain.hpp"

namespace multireach::controller {

/// One pair of surfaces that must not come nearer than the margin.
struct NearPair {
  std::array<double, kMaxJoints> gradient;  ///< d distance / d theta_i, m/rad
  double clearance;                         ///< distance less the margin, m; negative when too near
};

/// The distances between an arm's links, as capsules, and obstacles, and among the links. Distances by FCL.
class Proximity {
 public:
  static constexpr int kMostObstacles = 64;
  static constexpr int kMostPairs = 64;

  /// Throws std::invalid_argument for a body that makes no sense. Pairs of links that overlap in most postures (their
  /// capsules are too thick for the arm) are not looked at.
  Proximity(const Chain& chain, const Body& body);
  Proximity(const Proximity& other);
  Proximity& operator=(const Proximity& other) { return *this = Proximity(other); }
  Proximity(Proximity&&) noexcept;
  Proximity& operator=(Proximity&&) noexcept;
  ~Proximity();

  const Body& body() const { return body_; }
  /// Replaces all obstacles. Returns how many were refused: not acceptable(), or beyond kMostObstacles.
  int set_obstacles(std::span<const Obstacle> obstacles);
  /// Nothing to keep away from: queries would find no pair.
  bool idle() const;

  /// The nearest pairs in sight at `theta`, at most kMostPairs. Valid until the next call.
  std::span<const NearPair> near_pairs(const Eigen::Ref<const Eigen::VectorXd>& theta);
  /// The smallest clearance of all pairs at `theta`, at most sight_m.
  double clearance(const Eigen::Ref<const Eigen::VectorXd>& theta);
  /// `p` moved out of all obstacles, so far that the hand's capsule can be there.
  Eigen::Vector3d outside_obstacles(Eigen::Vector3d p) const;

 private:
  struct Shapes;
  void place_links(const Eigen::Ref<const Eigen::VectorXd>& theta);
  template <class Visit>
  void visit_pairs(Visit&& visit);

  Chain chain_;
  Body body_;
  std::unique_ptr<Shapes> shapes_;
  std::vector<Obstacle> obstacles_;
  std::vector<NearPair> pairs_;
};

}  // namespace multireach::controller
