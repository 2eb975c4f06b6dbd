#include "vision/fiducial/tag_pose.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "numeric/cholesky.hpp"

namespace multireach::vision {
namespace {

constexpr int kCornerSteps = 12;
constexpr int kEdgeSteps = 4;
constexpr double kSurest = 1e-6;       // of the side: a tolerance of 0 counts as this, so that the system is regular
constexpr double kAmbiguous = 25;      // difference of chi2: the mirrored pose is worse by less than five sigma
constexpr double kCornerSigma = 0.25;  // pixels: the error of the detector's corners, where edges cannot be measured
constexpr double kSameTurn = 0.9998;   // cosine of half the angle between two poses that are one: 2.3 degrees

using Unknowns = Eigen::Matrix<double, kTagUnknowns, 1>;
using Information = Eigen::Matrix<double, kTagUnknowns, kTagUnknowns>;

/// A least-squares system.
struct System {
  Information information = Information::Zero();
  Unknowns gradient = Unknowns::Zero();
  double chi2 = 0;
  int rows = 0;

  void add(const TagRow& J, double residual, double variance) {
    information += J.transpose() * J / variance;
    gradient += J.transpose() * (residual / variance);
    chi2 += residual * residual / variance;
    ++rows;
  }
};

void add_size_prior(const TagPlacement& tag, const TagSize& size, System& system) {
  const double sigma = std::max(size.tolerance_m / size.side_m, kSurest);
  TagRow J = TagRow::Zero();
  J[kTagUnknowns - 1] = 1;
  system.add(J, 1 - tag.scale, sigma * sigma);
}

void move(TagPlacement& tag, const Unknowns& step) {
  tag.X_LT.translation() += step.head<3>();
  // A quaternion needs no trigonometric function; for the small steps near the end it is exact to second order.
  Eigen::Quaterniond turn(1, 0.5 * step[3], 0.5 * step[4], 0.5 * step[5]);
  tag.X_LT.linear() = (turn.normalized() * Eigen::Quaterniond(tag.X_LT.linear())).normalized().toRotationMatrix();
  tag.scale += step[6];
}

/// Pose of a plane from its four corners in one camera, by their homography (Zhang, PAMI 2000, Sect. 3.1).
std::optional<Eigen::Isometry3d> pose_from_homography(const TagObservation& observation, double side_m) {
  Eigen::Matrix<double, 8, 8> A;
  Eigen::Matrix<double, 8, 1> b;
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector2d p = side_m * tag_corner(k),
                          ray = observation.camera.model.ray(observation.corners[static_cast<size_t>(k)]);
    A.row(2 * k) << p.x(), p.y(), 1, 0, 0, 0, -ray.x() * p.x(), -ray.x() * p.y();
    A.row(2 * k + 1) << 0, 0, 0, p.x(), p.y(), 1, -ray.y() * p.x(), -ray.y() * p.y();
    b.segment<2>(2 * k) = ray;
  }
  const Eigen::Matrix<double, 8, 1> h = A.partialPivLu().solve(b);
  if (!h.allFinite()) return std::nullopt;
  const Eigen::Vector3d x(h[0], h[3], h[6]), y(h[1], h[4], h[7]), at(h[2], h[5], 1);
  const double scale = 2 / (x.norm() + y.norm());
  Eigen::Isometry3d X_CT = Eigen::Isometry3d::Identity();
  X_CT.linear().col(0) = x.normalized();
  X_CT.linear().col(2) = x.cross(y).normalized();
  X_CT.linear().col(1) = X_CT.linear().col(2).cross(X_CT.linear().col(0));
  X_CT.translation() = scale * at;
  return X_CT.matrix().allFinite() ? std::optional(X_CT) : std::nullopt;
}

/// The same tag mirrored about the line of sight to its centre: under a weak perspective it looks the same.
Eigen::Isometry3d mirrored(const Eigen::Isometry3d& X_CT) {
  const Eigen::Vector3d line_of_sight = X_CT.translation().normalized();
  const Eigen::Matrix3d along =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), line_of_sight).toRotationMatrix();
  const Eigen::DiagonalMatrix<double, 3> flip(1, 1, -1);
  Eigen::Isometry3d result = X_CT;
  result.linear() = along * flip * along.transpose() * X_CT.linear() * flip;
  return result;
}

/// Improves a pose by the corners in all images and returns chi2 of these; nothing when the pose is behind a camera.
std::optional<double> refine_by_corners(std::span<const TagObservation> observations, const TagSize& size,
                                        TagPlacement& tag) {
  const auto system_at = [&](const TagPlacement& at) {
    std::optional<System> system(System{});
    add_size_prior(at, {size.side_m, 0}, *system);
    for (const TagObservation& observation : observations) {
      for (int k = 0; k < 4; ++k) {
        Eigen::Vector2d pixel;
        Eigen::Matrix<double, 2, kTagUnknowns> J;
        if (!project(observation.camera, at, size.side_m * tag_corner(k), pixel, J)) return std::optional<System>();
        const Eigen::Vector2d r = observation.corners[static_cast<size_t>(k)] - pixel;
        for (int row = 0; row < 2; ++row) system->add(J.row(row), r[row], kCornerSigma * kCornerSigma);
      }
    }
    return system;
  };
  auto system = system_at(tag);
  double damping = 1e-3;
  for (int step = 0; step < kCornerSteps && system; ++step) {
    Information damped = system->information;
    damped.diagonal() *= 1 + damping;
    TagPlacement next = tag;
    move(next, cholesky_solve<kTagUnknowns>(damped, system->gradient));
    const auto there = system_at(next);
    const bool better = there && there->chi2 < system->chi2;
    damping *= better ? 0.1 : 10;
    if (!better) continue;
    tag = next;
    system = there;
  }
  return system ? std::optional(system->chi2) : std::nullopt;
}

/// The measured centre in an image: the predicted one, shifted as the four sides are on average.
Eigen::Vector2d measured_centre(const TagObservation& observation, const TagPlacement& tag, const TagEdges& edges) {
  Eigen::Vector2d pixel(0, 0), shifts(0, 0);
  Eigen::Matrix<double, 2, kTagUnknowns> J;
  project(observation.camera, tag, {0, 0}, pixel, J);
  Eigen::Matrix2d normals = Eigen::Matrix2d::Zero();
  for (const TagSide& side : edges.sides) {
    normals += side.normal * side.normal.transpose();
    shifts += side.normal * side.displacement_px[0];
  }
  return pixel + normals.inverse() * shifts;
}

/// Improves a pose by the edges in all images. Nothing, and the reason in `fit`, when they cannot be measured.
std::optional<TagPose> refine_by_edges(std::span<const TagObservation> observations, const TagSize& size,
                                       double sigma_px, TagPlacement tag, TagFit& fit) {
  TagPose pose;
  for (int step = 0; step <= kEdgeSteps; ++step) {
    System system;
    add_size_prior(tag, size, system);
    pose.measured_centre_px.clear();
    for (size_t k = 0; k < observations.size(); ++k) {
      const TagObservation& observation = observations[k];
      const TagEdges edges =
          measure_edges(observation.camera, tag, size.side_m, observation.bgr, observation.window, sigma_px);
      fit.fault = edges.fault;
      fit.faulty = k;
      if (edges.fault != EdgeFault::kNone) return std::nullopt;
      for (const TagSide& side : edges.sides) {
        for (size_t row = 0; row < 2; ++row) system.add(side.J[row], side.displacement_px[row], side.variance_px2[row]);
      }
      pose.measured_centre_px.push_back(measured_centre(observation, tag, edges));
    }
    pose.tag = tag;
    pose.chi2 = system.chi2;
    pose.degrees_of_freedom = system.rows - kTagUnknowns;
    if (step == kEdgeSteps) {
      const Information covariance = system.information.inverse();
      pose.covariance = covariance.topLeftCorner<6, 6>();
      if (!covariance.allFinite()) return std::nullopt;
    } else {
      move(tag, cholesky_solve<kTagUnknowns>(system.information, system.gradient));
    }
  }
  return pose;
}

bool is_one_pose(const TagPlacement& a, const TagPlacement& b) {
  const Eigen::Quaterniond first(a.X_LT.linear()), second(b.X_LT.linear());
  return std::abs(first.dot(second)) > kSameTurn;
}

/// One of the two poses that the corners allow, and, where its edges can be measured, what they make of it.
struct Candidate {
  TagPlacement by_corners;
  double corner_chi2 = 0;
  std::optional<TagPose> by_edges{};
};

/// Whether `other`, which is less likely than `best`, cannot be excluded.
bool is_possible(const Candidate& best, const Candidate& other) {
  if (!other.by_edges) {
    return !is_one_pose(best.by_corners, other.by_corners) && other.corner_chi2 - best.corner_chi2 < kAmbiguous;
  }
  return !is_one_pose(best.by_edges->tag, other.by_edges->tag) &&
         other.by_edges->chi2 - best.by_edges->chi2 < kAmbiguous;
}

}  // namespace

TagFit fit_tag(std::span<const TagObservation> observations, const TagSize& size, double sigma_px) {
  TagFit fit;
  const auto start = pose_from_homography(observations.front(), size.side_m);
  if (!start) return fit;
  std::vector<Candidate> candidates;
  for (const Eigen::Isometry3d& X_CT : {*start, mirrored(*start)}) {
    Candidate candidate{{observations.front().camera.X_CL.inverse() * X_CT, 1}};
    const auto chi2 = refine_by_corners(observations, size, candidate.by_corners);
    if (!chi2) continue;
    candidate.corner_chi2 = *chi2;
    TagFit attempt;
    candidate.by_edges = refine_by_edges(observations, size, sigma_px, candidate.by_corners, attempt);
    if (!candidate.by_edges && fit.fault == EdgeFault::kNone) fit = attempt;
    candidates.push_back(std::move(candidate));
  }
  const auto badness = [](const Candidate& c) { return c.by_edges ? c.by_edges->chi2 : HUGE_VAL; };
  std::ranges::stable_sort(candidates, {}, badness);
  if (candidates.empty() || !candidates.front().by_edges) return fit;
  fit.fault = EdgeFault::kNone;
  fit.best = candidates[0].by_edges;
  if (candidates.size() == 2 && is_possible(candidates[0], candidates[1]))
    fit.other = candidates[1].by_edges.value_or(TagPose{.tag = candidates[1].by_corners});
  return fit;
}

}  // namespace multireach::vision
