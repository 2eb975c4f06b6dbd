#include "tools/page/drake_feed.hpp"

#include <algorithm>
#include <drake/lcmt_viewer_draw.hpp>
#include <drake/lcmt_viewer_load_robot.hpp>
#include <multireach/obstacles_t.hpp>
#include <multireach/robot_state_t.hpp>
#include <multireach/target_t.hpp>

#include "kinematics/joint_frames.hpp"
#include "runtime/channels.hpp"
#include "runtime/joint_fields.hpp"
#include "runtime/message.hpp"

namespace multireach {
namespace {

using Geometry = drake::lcmt_viewer_geometry_data;

constexpr int64_t kDrawPeriod = 33000, kLoadPeriod = 5000000;  // us
constexpr double kThin = 0.02;          // of the arm's reach: the links' radius where robot.yaml has none
constexpr double kTargetRadius = 0.02;  // of the arm's reach
constexpr size_t kMostTargets = 100;    // a sender that invents names must not fill the memory
const Eigen::Vector4d kLink(0.56, 0.63, 0.72, 1), kHinge(0.35, 0.39, 0.44, 1), kTarget(0.8, 0.47, 0.65, 0.9),
    kObstacle(0.5, 0.42, 0, 0.55);

std::vector<float> floats(const auto& numbers) {
  std::vector<float> result;
  for (const double number : numbers) result.push_back(static_cast<float>(number));
  return result;
}
void put(float (&to)[4], const Eigen::Quaterniond& q) {
  const double numbers[]{q.w(), q.x(), q.y(), q.z()};
  std::ranges::transform(numbers, to, [](double number) { return static_cast<float>(number); });
}

}  // namespace

DrakeFeed::DrakeFeed(const RobotConfig& robot) : chain_(robot.chain), radius_m_(kThin * robot.chain.reach()) {
  const auto controller = robot.section("controller");
  if (controller && controller->has("link_radius_m")) {
    const double radius = controller->number("link_radius_m", 0, 1e3);
    if (radius > 0) radius_m_ = radius;
  }
  for (int i = -1; i < chain_.size(); ++i) {
    Link link{.name = i < 0 ? chain_.base() : chain_.joint(i).name, .shapes = {}};
    if (i >= 0) link.shapes.push_back({Geometry::SPHERE, Eigen::Isometry3d::Identity(), kHinge, {1.1 * radius_m_}});
    const Eigen::Vector3d along = chain_.fixed(i + 1).translation();
    if (along.norm() > 1e-6) {
      Eigen::Isometry3d X_LS(Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), along));
      X_LS.translation() = 0.5 * along;
      link.shapes.push_back({Geometry::CAPSULE, X_LS, kLink, {radius_m_, along.norm()}});
    }
    arm_.push_back(std::move(link));
  }
}

void DrakeFeed::receive(std::string_view channel, std::span<const uint8_t> bytes) {
  if (channel == channel::kRobotState) {
    const auto state = decode<robot_state_t>(bytes);
    const auto theta = state ? from_fields(chain_, state->joint_name, state->joint_position) : std::nullopt;
    if (!theta || !theta->allFinite()) return;
    visit_joints(chain_, *theta,
                 [&](int i, const Eigen::Vector3d&, const Eigen::Vector3d&, const Eigen::Isometry3d& X) {
                   arm_[static_cast<size_t>(i) + 1].X_WL = X;
                 });
    moved_ = true;
  } else if (channel == channel::kTarget) {
    const auto target = decode<target_t>(bytes);
    if (!target) return;
    const Eigen::Vector3d p_WT = Eigen::Map<const Eigen::Vector3d>(target->position_m);
    const bool known = target->status == target_t::STATUS_TRACKED || target->status == target_t::STATUS_COASTING;
    if (!known || !p_WT.allFinite()) {
      changed_ = targets_.erase(target->name) > 0 || changed_;
      return;
    }
    auto found = targets_.find(target->name);
    if (found == targets_.end()) {
      if (targets_.size() >= kMostTargets) return;
      const Shape ball{Geometry::SPHERE, Eigen::Isometry3d::Identity(), kTarget, {kTargetRadius * chain_.reach()}};
      found = targets_.emplace(target->name, Link{.name = "target " + target->name, .shapes = {ball}}).first;
      changed_ = true;
    }
    found->second.X_WL.translation() = p_WT;
    moved_ = true;
  } else if (channel == channel::kObstacles) {
    const auto obstacles = decode<obstacles_t>(bytes);
    if (!obstacles) return;
    std::vector<Link> links;
    for (const obstacle_t& obstacle : obstacles->obstacles) {
      const Eigen::Vector3d centre = Eigen::Map<const Eigen::Vector3d>(obstacle.position_m),
                            size = Eigen::Map<const Eigen::Vector3d>(obstacle.size_m);
      const double* q = obstacle.orientation_wxyz;
      const Eigen::Quaterniond turn(q[0], q[1], q[2], q[3]);
      if (!centre.allFinite() || !size.allFinite() || !(std::abs(turn.norm() - 1) < 1e-3)) continue;
      if (obstacle.shape < obstacle_t::SPHERE || obstacle.shape > obstacle_t::BOX) continue;
      Shape shape{Geometry::SPHERE, Eigen::Isometry3d::Identity(), kObstacle, {size.x()}};
      if (obstacle.shape == obstacle_t::CAPSULE) shape.type = Geometry::CAPSULE, shape.size = {size.x(), size.y()};
      if (obstacle.shape == obstacle_t::BOX) shape.type = Geometry::BOX, shape.size = {size.x(), size.y(), size.z()};
      if (!std::ranges::all_of(shape.size, [](double length) { return length > 0; })) continue;
      Link link{.name = "obstacle " + std::to_string(links.size() + 1), .shapes = {std::move(shape)}};
      link.X_WL.linear() = turn.normalized().toRotationMatrix();
      link.X_WL.translation() = centre;
      links.push_back(std::move(link));
    }
    // Obstacles that only move are drawn where they are; others are loaded again.
    const auto alike = [](const Link& one, const Link& other) {
      return one.shapes[0].type == other.shapes[0].type && one.shapes[0].size == other.shapes[0].size;
    };
    changed_ = changed_ || !std::ranges::equal(links, obstacles_, alike);
    moved_ = true;
    obstacles_ = std::move(links);
  }
}

void DrakeFeed::tick(int64_t utime, Outbox& out) {
  if (changed_ || utime - loaded_us_ >= kLoadPeriod) {
    out.push_back({kLoad, load_message()});
    loaded_us_ = utime;
    changed_ = false;
    moved_ = true;  // what is loaded stands at the origin
    drawn_us_ = INT64_MIN / 2;
  }
  if (!moved_ || utime - drawn_us_ < kDrawPeriod) return;
  out.push_back({kDraw, draw_message(utime)});
  drawn_us_ = utime;
  moved_ = false;
}

std::vector<uint8_t> DrakeFeed::load_message() const {
  drake::lcmt_viewer_load_robot message;
  const auto add = [&](const Link& link) {
    drake::lcmt_viewer_link_data& data = message.link.emplace_back();
    data.name = link.name;
    data.robot_num = 0;
    for (const Shape& shape : link.shapes) {
      Geometry& geometry = data.geom.emplace_back();
      geometry.type = shape.type;
      for (int k = 0; k < 3; ++k) geometry.position[k] = static_cast<float>(shape.X_LS.translation()[k]);
      put(geometry.quaternion, Eigen::Quaterniond(shape.X_LS.linear()));
      for (int k = 0; k < 4; ++k) geometry.color[k] = static_cast<float>(shape.colour[k]);
      geometry.float_data = floats(shape.size);
      geometry.num_float_data = static_cast<int32_t>(geometry.float_data.size());
    }
    data.num_geom = static_cast<int32_t>(data.geom.size());
  };
  for (const Link& link : arm_) add(link);
  for (const auto& [name, link] : targets_) add(link);
  for (const Link& link : obstacles_) add(link);
  message.num_links = static_cast<int32_t>(message.link.size());
  return encode(message).value_or(std::vector<uint8_t>());
}

std::vector<uint8_t> DrakeFeed::draw_message(int64_t utime) const {
  drake::lcmt_viewer_draw message;
  message.timestamp = utime / 1000;
  const auto add = [&](const Link& link) {
    message.link_name.push_back(link.name);
    message.robot_num.push_back(0);
    message.position.push_back(floats(link.X_WL.translation()));
    float wxyz[4];
    put(wxyz, Eigen::Quaterniond(link.X_WL.linear()));
    message.quaternion.emplace_back(wxyz, wxyz + 4);
  };
  for (const Link& link : arm_) add(link);
  for (const auto& [name, link] : targets_) add(link);
  for (const Link& link : obstacles_) add(link);
  message.num_links = static_cast<int32_t>(message.link_name.size());
  return encode(message).value_or(std::vector<uint8_t>());
}

}  // namespace multireach
