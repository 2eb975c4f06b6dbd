#include "tools/foxglove/scene.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <multireach/robot_state_t.hpp>

#include "kinematics/joint_frames.hpp"
#include "kinematics/urdf_document.hpp"
#include "runtime/channels.hpp"
#include "runtime/files.hpp"
#include "runtime/joint_fields.hpp"
#include "runtime/message.hpp"
#include "runtime/node.hpp"

namespace multireach {
namespace {

using json = nlohmann::ordered_json;

constexpr int64_t kPeriod = 33000;                // us, between two drawings of the arm
constexpr int64_t kRepeats = 1000000;             // us, between two drawings of the same obstacles
constexpr int64_t kTargetLifetime = 500'000'000;  // ns: as long as a target coasts
constexpr double kThin = 0.02;                    // of the arm's reach: the links' radius where robot.yaml has none
constexpr double kSigmas = 2;                     // the ellipsoid around a target, ...
constexpr double kSmallest = 0.005;               // m, ... and its smallest radius, to be seen
constexpr size_t kMostTargets = 100;              // a sender that invents names must not fill the memory
constexpr double kLetters = 14;                   // pixels

json vector(const Eigen::Vector3d& v) {
  return {{"x", v.x()}, {"y", v.y()}, {"z", v.z()}};
}
json quaternion(const Eigen::Quaterniond& q) {
  return {{"x", q.x()}, {"y", q.y()}, {"z", q.z()}, {"w", q.w()}};
}
json pose(const Eigen::Vector3d& position, const Eigen::Quaterniond& orientation) {
  return {{"position", vector(position)}, {"orientation", quaternion(orientation)}};
}
json colour(double red, double green, double blue, double opacity = 1) {
  return {{"r", red}, {"g", green}, {"b", blue}, {"a", opacity}};
}
json transform(int64_t utime, const std::string& parent, const std::string& child, const Eigen::Isometry3d& X) {
  return {{"timestamp", foxglove_time(utime)},
          {"parent_frame_id", parent},
          {"child_frame_id", child},
          {"translation", vector(X.translation())},
          {"rotation", quaternion(Eigen::Quaterniond(X.linear()))}};
}
json sphere(const Eigen::Vector3d& centre, const Eigen::Vector3d& diameters, const Eigen::Quaterniond& orientation,
            const json& colour) {
  return {{"pose", pose(centre, orientation)}, {"size", vector(diameters)}, {"color", colour}};
}
json ball(const Eigen::Vector3d& centre, double radius, const json& colour) {
  return sphere(centre, Eigen::Vector3d::Constant(2 * radius), Eigen::Quaterniond::Identity(), colour);
}
json cylinder(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius, const json& colour) {
  const Eigen::Vector3d axis = to - from;
  const auto turn = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), axis);
  return {{"pose", pose((from + to) / 2, turn)},
          {"size", vector({2 * radius, 2 * radius, axis.norm()})},
          {"bottom_scale", 1},
          {"top_scale", 1},
          {"color", colour}};
}

/// With all fields that Foxglove's schema requires. `lifetime_ns`: how long it is drawn without a newer one; 0 for
/// ever.
json entity(int64_t utime, const std::string& frame, const std::string& id, int64_t lifetime_ns = 0) {
  json empty = json::array();
  return {{"timestamp", foxglove_time(utime)},
          {"frame_id", frame},
          {"id", id},
          {"lifetime", {{"sec", 0}, {"nsec", lifetime_ns}}},
          {"frame_locked", true},
          {"metadata", empty},
          {"arrows", empty},
          {"cubes", empty},
          {"spheres", empty},
          {"cylinders", empty},
          {"lines", empty},
          {"triangles", empty},
          {"texts", empty},
          {"models", empty}};
}
FoxgloveMessage update(const json& deletions, const json& entities) {
  return {"/scene", "foxglove.SceneUpdate", {{"deletions", deletions}, {"entities", entities}}};
}
json deletion(int64_t utime, const std::string& id) {
  constexpr int kMatchingId = 0;
  return {{"timestamp", foxglove_time(utime)}, {"type", kMatchingId}, {"id", id}};
}

/// Names of the links that the joints of a chain from `base` move: their frames are those that a URDF layer of the 3-D
/// view draws. A joint above the base, which the chain passes from child to parent, has no such link.
std::map<std::string, std::string> links_of_joints(const std::string& urdf_path, const std::string& base) {
  const UrdfTree tree = urdf_tree(read_text_file(urdf_path));
  const auto above = tree.ancestry(base);
  std::map<std::string, std::string> links;
  for (const UrdfTree::Joint& joint : tree.joints) {
    if (std::ranges::find(above, joint.child) == above.end()) links[joint.name] = joint.child;
  }
  return links;
}

Eigen::Quaterniond rotation_of(const double (&wxyz)[4]) {
  const Eigen::Quaterniond q(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  return q.norm() > 1e-6 && q.coeffs().allFinite() ? q.normalized() : Eigen::Quaterniond::Identity();
}

}  // namespace

FoxgloveScene::FoxgloveScene(const RobotConfig& robot, const StereoRig* rig)
    : chain_(robot.chain), root_(robot.chain.base()), radius_m_(kThin * robot.chain.reach()) {
  auto links = links_of_joints(robot.urdf_path, root_);
  for (const Joint& joint : chain_.joints()) {
    const std::string link = links[joint.name];
    link_.push_back(link.empty() ? joint.name : link);
  }
  const auto controller = robot.section("controller");
  if (controller && controller->has("link_radius_m")) {
    const double radius = controller->number("link_radius_m", 0, 1e3);
    if (radius > 0) radius_m_ = radius;
  }
  if (!rig) return;
  cameras_ = {{"left", rig->left}, {"right", rig->right}};
  X_WC_ = {rig->X_WL, rig->X_WL * rig->X_RL.inverse()};
}

std::vector<FoxgloveMessage> FoxgloveScene::messages(std::string_view channel, std::span<const uint8_t> bytes,
                                                     int64_t utime) {
  if (!plausible_utime(utime)) return {};
  if (channel == channel::kRobotState) return arm(bytes, utime);
  if (channel == channel::kTarget) {
    if (const auto message = decode<target_t>(bytes)) return target(*message, utime);
  } else if (channel == channel::kObstacles) {
    if (const auto message = decode<obstacles_t>(bytes)) return obstacles(*message, utime);
  } else if (channel == channel::kStereoImages) {
    if (const auto message = decode<images_t>(bytes)) return calibrations(*message);
  }
  return {};
}

std::vector<FoxgloveMessage> FoxgloveScene::arm(std::span<const uint8_t> bytes, int64_t utime) {
  if (drawn_utime_ && utime >= *drawn_utime_ && utime - *drawn_utime_ < kPeriod) return {};
  const auto state = decode<robot_state_t>(bytes);
  if (!state) return {};
  const auto theta = from_fields(chain_, state->joint_name, state->joint_position);
  if (!theta || !theta->allFinite()) return {};
  drawn_utime_ = utime;
  json frames = json::array();
  json drawing = entity(utime, root_, "arm");
  const json housing = colour(0.75, 0.75, 0.78);
  Eigen::Isometry3d X_parent = Eigen::Isometry3d::Identity();
  std::string parent = root_;
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  const auto link_to = [&](const Eigen::Vector3d& p_W) {
    if ((p_W - last).norm() > 1e-4) drawing["cylinders"].push_back(cylinder(last, p_W, radius_m_, housing));
    last = p_W;
  };
  const Eigen::Isometry3d X_WT = visit_joints(
      chain_, *theta, [&](int i, const Eigen::Vector3d&, const Eigen::Vector3d&, const Eigen::Isometry3d& X_WL) {
        const std::string& link = link_[static_cast<size_t>(i)];
        frames.push_back(transform(utime, parent, link, X_parent.inverse() * X_WL));
        link_to(X_WL.translation());
        drawing["spheres"].push_back(ball(X_WL.translation(), radius_m_, colour(0.35, 0.4, 0.5)));
        X_parent = X_WL;
        parent = link;
      });
  link_to(X_WT.translation());
  drawing["spheres"].push_back(ball(X_WT.translation(), radius_m_, colour(0.1, 0.35, 0.8)));
  if (chain_.tip() != parent) frames.push_back(transform(utime, parent, chain_.tip(), X_parent.inverse() * X_WT));
  for (size_t k = 0; k < cameras_.size(); ++k) frames.push_back(transform(utime, root_, cameras_[k].first, X_WC_[k]));
  json drawings = json::array({drawing});
  if (!obstacles_.is_null() && (!repeated_utime_ || std::abs(utime - *repeated_utime_) >= kRepeats)) {
    repeated_utime_ = utime;
    obstacles_["timestamp"] = foxglove_time(utime);
    drawings.push_back(obstacles_);
  }
  return {{"/tf", "foxglove.FrameTransforms", {{"transforms", frames}}}, update(json::array(), drawings)};
}

std::vector<FoxgloveMessage> FoxgloveScene::target(const target_t& target, int64_t utime) {
  const std::string id = "target " + target.name;
  const bool seen = target.status == target_t::STATUS_TRACKED,
             known = seen || target.status == target_t::STATUS_COASTING;
  const Eigen::Vector3d p_WT = Eigen::Map<const Eigen::Vector3d>(target.position_m);
  if (!known || !p_WT.allFinite()) {
    if (targets_.erase(id) == 0) return {};
    return {update(json::array({deletion(utime, id)}), json::array())};
  }
  if (targets_.size() >= kMostTargets && !targets_.contains(id)) return {};
  targets_.insert(id);
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> covariance(&target.covariance_m2[0][0]);
  Eigen::Vector3d radii = Eigen::Vector3d::Constant(kSmallest);
  Eigen::Quaterniond axes = Eigen::Quaterniond::Identity();
  if (covariance.allFinite()) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
    Eigen::Matrix3d R = solver.eigenvectors();
    if (R.determinant() < 0) R.col(0) *= -1;
    axes = Eigen::Quaterniond(R);
    radii = (kSigmas * solver.eigenvalues().cwiseMax(0).cwiseSqrt()).cwiseMax(kSmallest);
  }
  const json tint = seen ? colour(0.9, 0.45, 0, 0.9) : colour(0.5, 0.5, 0.5, 0.6);
  json drawing = entity(utime, root_, id, kTargetLifetime);
  drawing["spheres"].push_back(sphere(p_WT, 2 * radii, axes, tint));
  drawing["texts"].push_back(
      {{"pose", pose(p_WT + radii.maxCoeff() * Eigen::Vector3d::UnitZ(), Eigen::Quaterniond::Identity())},
       {"billboard", true},
       {"font_size", kLetters},
       {"scale_invariant", true},
       {"color", tint},
       {"text", target.name + (seen ? "" : " (expected)")}});
  return {update(json::array(), json::array({drawing}))};
}

std::vector<FoxgloveMessage> FoxgloveScene::obstacles(const obstacles_t& obstacles, int64_t utime) {
  json drawing = entity(utime, root_, "obstacles");
  const json tint = colour(0.6, 0.2, 0.2, 0.7);
  for (const obstacle_t& obstacle : obstacles.obstacles) {
    const Eigen::Vector3d centre = Eigen::Map<const Eigen::Vector3d>(obstacle.position_m),
                          size = Eigen::Map<const Eigen::Vector3d>(obstacle.size_m);
    if (!centre.allFinite() || !size.allFinite()) continue;
    const Eigen::Quaterniond turn = rotation_of(obstacle.orientation_wxyz);
    if (obstacle.shape == obstacle_t::BOX) {
      drawing["cubes"].push_back({{"pose", pose(centre, turn)}, {"size", vector(size)}, {"color", tint}});
      continue;
    }
    const Eigen::Vector3d half = obstacle.shape == obstacle_t::CAPSULE
                                     ? (turn * Eigen::Vector3d(0, 0, size.y() / 2)).eval()
                                     : Eigen::Vector3d::Zero().eval();
    drawing["spheres"].push_back(ball(centre + half, size.x(), tint));
    if (half.isZero(0)) continue;
    drawing["spheres"].push_back(ball(centre - half, size.x(), tint));
    drawing["cylinders"].push_back(cylinder(centre - half, centre + half, size.x(), tint));
  }
  obstacles_ = drawing;
  repeated_utime_ = utime;
  return {update(json::array(), json::array({drawing}))};
}

std::vector<FoxgloveMessage> FoxgloveScene::calibrations(const images_t& images) const {
  std::vector<FoxgloveMessage> all;
  if (!drawn_utime_) return all;  // the log may be of another robot, which has other cameras
  for (size_t i = 0; i < images.images.size(); ++i) {
    const std::string side = image_side(images, i);
    for (const auto& [name, camera] : cameras_) {
      if (name != side) continue;
      const bool pinhole = std::ranges::all_of(camera.distortion, [](double k) { return k == 0; });
      all.push_back({std::string(channel::kStereoImages) + "/" + side + "/calibration",
                     "foxglove.CameraCalibration",
                     {{"timestamp", foxglove_time(images.images[i].utime)},
                      {"frame_id", side},
                      {"width", camera.width},
                      {"height", camera.height},
                      {"distortion_model", pinhole ? "" : "rational_polynomial"},
                      {"D", pinhole ? json::array() : json(camera.distortion)},
                      {"K", {camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1}},
                      {"R", {1, 0, 0, 0, 1, 0, 0, 0, 1}},
                      {"P", {camera.fx, 0, camera.cx, 0, 0, camera.fy, camera.cy, 0, 0, 0, 1, 0}}}});
    }
  }
  return all;
}

}  // namespace multireach
