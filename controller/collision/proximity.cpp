#include "controller/collision/proximity.hpp"

#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/detail/gjk_solver_libccd.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <variant>

#include "kinematics/joint_frames.hpp"
#include "numeric/random.hpp"
#include "numeric/trigonometry.hpp"

namespace multireach::controller {
namespace {

using Solver = fcl::detail::GJKSolver_libccd<double>;
using Shape = std::variant<fcl::Sphered, fcl::Capsuled>;

/// Distance between two shapes and their nearest points. For shapes that overlap: the penetration depth (negative) and
/// the deepest points.
struct Gap {
  double distance;
  Eigen::Vector3d on_first, on_second;
  Eigen::Vector3d away;  // unit vector from the second to the first
};

Gap gap_of_balls(const Eigen::Vector3d& first, double first_radius, const Eigen::Vector3d& second,
                 double second_radius) {
  Eigen::Vector3d towards = second - first;
  const double apart = towards.norm();
  towards = apart > 1e-9 ? Eigen::Vector3d(towards / apart) : Eigen::Vector3d::UnitZ();
  return {apart - first_radius - second_radius, first + first_radius * towards, second - second_radius * towards,
          -towards};
}

}  // namespace

struct Proximity::Shapes {
  struct Link {
    bool exists = false;     // false for a link of length zero, which has no capsule
    double half_length = 0;  // of the capsule's axis
    Eigen::Isometry3d X_LK;  // the capsule in the link's frame
    fcl::Capsuled capsule{1, 1};
    Eigen::Isometry3d X_WK;  // at the current joint positions
    double bound = 0;        // radius of the bounding sphere
  };
  std::array<Link, kMaxJoints> links;  // link i moves with joint i
  std::array<Eigen::Vector3d, kMaxJoints> axis, origin;
  std::vector<Shape> obstacles;
  std::vector<double> obstacle_bounds;
  std::array<std::array<bool, kMaxJoints>, kMaxJoints> may_collide{};
  Solver solver;

  /// Distance between a link and an obstacle. FCL has no cheap penetration depth, so this measures from the capsule's
  /// axis (a very thin capsule) and subtracts the radius afterwards. That fails only when the axis itself is inside the
  /// obstacle.
  Gap gap(const Link& link, double radius, const Shape& shape, const Obstacle& obstacle) const {
    Gap found{};
    const fcl::Capsuled thin(kThin, 2 * link.half_length);
    const bool apart = obstacle.shape == Obstacle::Shape::kBox
                           ? box_gap(link, obstacle, found)
                           : std::visit(
                                 [&](const auto& other) {
                                   return solver.shapeDistance(thin, link.X_WK, other, obstacle.X_WO, &found.distance,
                                                               &found.on_first, &found.on_second);
                                 },
                                 shape);
    if (apart && found.distance > 0) {
      const Eigen::Vector3d towards = (found.on_second - found.on_first) / found.distance;
      found.on_first += (radius - kThin) * towards;
      found.away = -towards;
      found.distance -= radius - kThin;
      return found;
    }
    // The axis penetrates the obstacle: take the deepest of five points on it.
    double shallowest = -std::numeric_limits<double>::infinity();
    for (const double along : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
      const Eigen::Vector3d p = link.X_WK * Eigen::Vector3d(0, 0, along * link.half_length);
      Eigen::Vector3d away;
      const double distance = signed_distance(obstacle, p, away);
      if (-distance < shallowest) continue;
      shallowest = -distance;
      found = {distance - radius, p - radius * away, p - distance * away, away};
    }
    return found;
  }

  /// The distance between a link's axis and a box. FCL's general algorithm would allocate memory. The distance from a
  /// box is convex along the axis, so a golden-section search finds the minimum.
  static bool box_gap(const Link& link, const Obstacle& box, Gap& found) {
    const Eigen::Vector3d half = 0.5 * box.size, middle = box.X_WO.inverse(Eigen::Isometry) * link.X_WK.translation(),
                          along = box.X_WO.linear().transpose() * link.X_WK.linear().col(2);
    const auto squared = [&](double t) {
      const Eigen::Vector3d p = middle + t * along;
      return (p - p.cwiseMax(-half).cwiseMin(half)).squaredNorm();
    };
    constexpr double kRatio = 0.6180339887498949;
    double from = -link.half_length, to = link.half_length;
    double left = to - kRatio * (to - from), right = from + kRatio * (to - from);
    double at_left = squared(left), at_right = squared(right);
    for (int k = 0; k < 40; ++k) {
      if (at_left <= at_right) {
        to = right;
        right = left;
        at_right = at_left;
        left = to - kRatio * (to - from);
        at_left = squared(left);
      } else {
        from = left;
        left = right;
        at_left = at_right;
        right = from + kRatio * (to - from);
        at_right = squared(right);
      }
    }
    const Eigen::Vector3d p = middle + 0.5 * (from + to) * along, q = p.cwiseMax(-half).cwiseMin(half);
    const double distance = (p - q).norm();
    if (distance < kThin + 1e-9) return false;
    found.on_second = box.X_WO * q;
    found.on_first = box.X_WO * (p + kThin / distance * (q - p));
    found.distance = distance - kThin;
    return true;
  }

  static constexpr double kThin = 1e-4;  // m: radius of the thin capsule that stands for an axis in FCL
};

Proximity::Proximity(const Chain& chain, const Body& body)
    : chain_(chain), body_(body), shapes_(std::make_unique<Shapes>()) {
  const auto sensible = [](double value) { return std::isfinite(value) && value >= 0; };
  if (!sensible(body.link_radius_m) || !sensible(body.margin_m) || !sensible(body.query_distance_m)) {
    throw std::invalid_argument(
        "the body's link_radius_m, margin_m and query_distance_m must be finite and not negative");
  }
  obstacles_.reserve(kMaxObstacles);
  shapes_->obstacles.reserve(kMaxObstacles);
  shapes_->obstacle_bounds.reserve(kMaxObstacles);
  pairs_.reserve(kMaxPairs);
  for (int i = 0; i < chain.size(); ++i) {
    Shapes::Link& link = shapes_->links[i];
    const Eigen::Vector3d along = chain.fixed(i + 1).translation();
    const double length = along.norm();
    link.exists = body.link_radius_m > 0 && length > 1e-6;
    if (!link.exists) continue;
    link.half_length = 0.5 * length;
    link.X_LK = Eigen::Isometry3d::Identity();
    link.X_LK.linear() = rotation_from_z(along);
    link.X_LK.translation() = 0.5 * along;
    link.bound = link.half_length + body.link_radius_m;
  }
  if (!body.self_collision || body.link_radius_m <= 0) return;
  // Exclude neighbouring links, which always touch, and pairs that overlap in most sampled configurations, e.g. links
  // separated by one short link.
  const CounterRandom random(1);
  constexpr int kSamples = 200;
  std::array<std::array<int, kMaxJoints>, kMaxJoints> overlaps{};
  JointVector theta(chain.size());
  uint64_t counter = 0;
  for (int k = 0; k < kSamples; ++k) {
    for (int i = 0; i < chain.size(); ++i) {
      theta[i] = random.uniform(counter++, chain.sample_lower(i), chain.sample_upper(i));
    }
    update_link_poses(theta);
    for (int i = 0; i < chain.size(); ++i) {
      for (int j = i + 1; j < chain.size(); ++j) {
        if (!shapes_->links[i].exists || !shapes_->links[j].exists) continue;
        shapes_->may_collide[i][j] = true;
      }
    }
    visit_pairs([&](int i, int j, const Gap& gap) {
      if (j >= 0 && gap.distance < body.margin_m) ++overlaps[i][j];
    });
  }
  for (int i = 0; i < chain.size(); ++i) {
    int next = i + 1;
    while (next < chain.size() && !shapes_->links[next].exists) ++next;
    for (int j = i + 1; j < chain.size(); ++j) {
      if (j == next || overlaps[i][j] > kSamples / 2) shapes_->may_collide[i][j] = false;
    }
  }
}

Proximity::Proximity(const Proximity& other)
    : chain_(other.chain_), body_(other.body_), shapes_(std::make_unique<Shapes>(*other.shapes_)) {
  obstacles_.reserve(kMaxObstacles);
  shapes_->obstacles.reserve(kMaxObstacles);
  shapes_->obstacle_bounds.reserve(kMaxObstacles);
  pairs_.reserve(kMaxPairs);
  obstacles_ = other.obstacles_;
}

Proximity::Proximity(Proximity&&) noexcept = default;
Proximity& Proximity::operator=(Proximity&&) noexcept = default;
Proximity::~Proximity() = default;

int Proximity::set_obstacles(std::span<const Obstacle> obstacles) {
  obstacles_.clear();
  shapes_->obstacles.clear();
  shapes_->obstacle_bounds.clear();
  int refused = 0;
  for (const Obstacle& obstacle : obstacles) {
    if (!is_valid(obstacle) || obstacles_.size() == kMaxObstacles) {
      ++refused;
      continue;
    }
    obstacles_.push_back(obstacle);
    const Eigen::Vector3d& size = obstacle.size;
    switch (obstacle.shape) {
      case Obstacle::Shape::kSphere:
        shapes_->obstacles.emplace_back(fcl::Sphered(size[0]));
        shapes_->obstacle_bounds.push_back(size[0]);
        break;
      case Obstacle::Shape::kCapsule:
        shapes_->obstacles.emplace_back(fcl::Capsuled(size[0], size[1]));
        shapes_->obstacle_bounds.push_back(size[0] + 0.5 * size[1]);
        break;
      case Obstacle::Shape::kBox:
        shapes_->obstacles.emplace_back(fcl::Sphered(0.5 * size.norm()));  // unused; keeps the indices aligned
        shapes_->obstacle_bounds.push_back(0.5 * size.norm());
        break;
    }
  }
  return refused;
}

bool Proximity::nothing_to_avoid() const {
  return body_.link_radius_m <= 0 || (obstacles_.empty() && !body_.self_collision);
}

void Proximity::update_link_poses(const Eigen::Ref<const Eigen::VectorXd>& theta) {
  visit_joints(chain_, theta,
               [&](int i, const Eigen::Vector3d& axis_W, const Eigen::Vector3d& p_WJ, const Eigen::Isometry3d& X_WL) {
                 shapes_->axis[i] = axis_W;
                 shapes_->origin[i] = p_WJ;
                 Shapes::Link& link = shapes_->links[i];
                 if (link.exists) link.X_WK = X_WL * link.X_LK;
               });
}

/// Calls visit(i, -1, gap) for link i and an obstacle, visit(i, j, gap) for links i and j, of all pairs within
/// query_distance_m plus the margin.
template <class Visit>
void Proximity::visit_pairs(Visit&& visit) {
  const double radius = body_.link_radius_m, range = body_.query_distance_m + body_.margin_m;
  distances_ = 0;
  for (int i = 0; i < chain_.size(); ++i) {
    const Shapes::Link& link = shapes_->links[i];
    if (!link.exists) continue;
    const Eigen::Vector3d centre = link.X_WK.translation();
    for (size_t k = 0; k < obstacles_.size(); ++k) {
      const double limit = range + link.bound + shapes_->obstacle_bounds[k];
      if ((obstacles_[k].X_WO.translation() - centre).squaredNorm() > limit * limit) continue;
      ++distances_;
      const Gap gap = shapes_->gap(link, radius, shapes_->obstacles[k], obstacles_[k]);
      if (gap.distance < range) visit(i, -1, gap);
    }
    for (int j = i + 1; j < chain_.size(); ++j) {
      if (!shapes_->may_collide[i][j]) continue;
      const Shapes::Link& other = shapes_->links[j];
      const double limit = range + link.bound + other.bound;
      if ((other.X_WK.translation() - centre).squaredNorm() > limit * limit) continue;
      ++distances_;
      double apart = 0;
      Eigen::Vector3d on_first, on_second;
      const fcl::Capsuled first(Shapes::kThin, 2 * link.half_length), second(Shapes::kThin, 2 * other.half_length);
      if (!shapes_->solver.shapeDistance(first, link.X_WK, second, other.X_WK, &apart, &on_first, &on_second)) {
        on_first = link.X_WK.translation();
        on_second = other.X_WK.translation();
      }
      const Gap gap = gap_of_balls(on_first, radius, on_second, radius);
      if (gap.distance < range) visit(i, j, gap);
    }
  }
}

std::span<const ProximityPair> Proximity::near_pairs(const Eigen::Ref<const Eigen::VectorXd>& theta) {
  pairs_.clear();
  update_link_poses(theta);
  visit_pairs([&](int i, int j, const Gap& gap) {
    ProximityPair pair;
    pair.clearance = gap.distance - body_.margin_m;
    if (pairs_.size() == kMaxPairs) {
      const auto farthest = std::ranges::max_element(pairs_, {}, &ProximityPair::clearance);
      if (farthest->clearance <= pair.clearance) return;
      *farthest = pairs_.back();
      pairs_.pop_back();
    }
    pair.gradient.fill(0);
    const auto add = [&](const Eigen::Vector3d& p, int last, double sign) {
      for (int k = 0; k <= last; ++k) {
        const bool is_prismatic = chain_.joint(k).type == Joint::Type::kPrismatic;
        const Eigen::Vector3d moves =
            is_prismatic ? shapes_->axis[k] : shapes_->axis[k].cross(p - shapes_->origin[k]).eval();
        pair.gradient[k] += sign * gap.away.dot(moves);
      }
    };
    add(gap.on_first, i, 1);
    if (j >= 0) add(gap.on_second, j, -1);
    pairs_.push_back(pair);
  });
  return pairs_;
}

double Proximity::clearance(const Eigen::Ref<const Eigen::VectorXd>& theta) {
  double least = body_.query_distance_m;
  update_link_poses(theta);
  visit_pairs([&](int, int, const Gap& gap) { least = std::min(least, gap.distance - body_.margin_m); });
  return least;
}

Eigen::Vector3d Proximity::outside_obstacles(Eigen::Vector3d p) const {
  if (body_.link_radius_m <= 0) return p;
  const double wanted = body_.link_radius_m + body_.margin_m + 1e-6;
  // At the centre of an obstacle the direction out is ambiguous: a tiny shift selects the one towards the arm.
  const Eigen::Vector3d home = 1e-7 * (chain_.fixed(0).translation() - p).stableNormalized();
  for (int round = 0; round < 8; ++round) {
    bool moved = false;
    for (const Obstacle& obstacle : obstacles_) {
      Eigen::Vector3d away;
      const double distance = signed_distance(obstacle, p, away);
      if (distance >= wanted) continue;
      if (round == 0) signed_distance(obstacle, p + home, away);
      p += (wanted + 1e-6 - distance) * away;
      moved = true;
    }
    if (!moved) break;
  }
  return p;
}

}  // namespace multireach::controller
