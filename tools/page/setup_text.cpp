#include "tools/page/setup_text.hpp"

#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "runtime/files.hpp"
#include "runtime/program.hpp"

namespace multireach {
namespace {

using json = nlohmann::ordered_json;

json number(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

json joint_of(const RobotConfig& robot, int i) {
  static constexpr std::array kTypes{"revolute", "continuous", "prismatic"};
  const Joint& joint = robot.chain.joint(i);
  const JointVector& acceleration = robot.joint_acceleration_limits;
  return {{"name", joint.name},
          {"type", kTypes.at(static_cast<size_t>(joint.type))},
          {"lower", number(joint.lower)},
          {"upper", number(joint.upper)},
          {"velocity", number(joint.velocity)},
          {"acceleration", i < acceleration.size() ? number(acceleration[i]) : json(nullptr)}};
}

json camera_of(const char* name, const CameraModel& camera, const Eigen::Isometry3d& X_WC) {
  json rows = json::array();
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) rows.push_back(X_WC(row, column));
  }
  return {{"name", name},       {"width_px", camera.width}, {"height_px", camera.height}, {"fx_px", camera.fx},
          {"fy_px", camera.fy}, {"cx_px", camera.cx},       {"cy_px", camera.cy},         {"X_WC", rows}};
}

}  // namespace

std::string setup_text(const RobotConfig& robot, const StereoRig* rig) {
  json joints = json::array(), cameras = json::array();
  for (int i = 0; i < robot.chain.size(); ++i) joints.push_back(joint_of(robot, i));
  if (rig) {
    cameras.push_back(camera_of("left", rig->left, rig->X_WL));
    cameras.push_back(camera_of("right", rig->right, rig->X_WL * rig->X_RL.inverse()));
  }
  const auto controller = robot.section("controller");
  const bool radius = controller && controller->has("link_radius_m");
  const json setup{{"robot", std::filesystem::path(robot.file.file()).parent_path().filename().string()},
                   {"build", this_build()},
                   {"urdf", read_text_file(robot.urdf_path)},
                   {"base", robot.chain.base()},
                   {"tip", robot.chain.tip()},
                   {"reach_m", robot.chain.reach()},
                   {"link_radius_m", radius ? controller->number("link_radius_m", 0, 1e3) : 0.0},
                   {"joints", joints},
                   {"cameras", cameras}};
  return json{{"setup", setup}}.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace multireach
