#include "robot_bridge/sim/mujoco_arm.hpp"

#include <mujoco/mujoco.h>
#include <spdlog/spdlog.h>
#include <tinyxml2.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <stdexcept>

#include "kinematics/default_joint_position.hpp"
#include "kinematics/urdf_document.hpp"

namespace multireach {
namespace {

constexpr double kMaxForce = 1e4;  // N: more than the weight of a car; beyond it the simulation may diverge

/// Without these, MuJoCo writes into MUJOCO_LOG.TXT in the working folder.
void send_messages_to_the_log() {
  mju_user_warning = [](const char* text) { spdlog::warn("MuJoCo: {}", text); };
  // MuJoCo cannot continue after an error, and no exception may pass through it: it would end the program too.
  mju_user_error = [](const char* text) {
    spdlog::error("MuJoCo cannot continue: {}", text);
    std::exit(EXIT_FAILURE);
  };
}

/// An attribute as a number; nothing when it is absent or no number.
std::optional<double> number_in(const tinyxml2::XMLElement* element, const char* name) {
  double value = 0;
  if (!element || element->QueryDoubleAttribute(name, &value) != tinyxml2::XML_SUCCESS) return std::nullopt;
  return value;
}

/// Throws when the mass or inertia of a link is not physical: MuJoCo accepts NaN, and simulates nonsense.
void require_physical_inertia(const tinyxml2::XMLElement& link) {
  const auto* inertial = link.FirstChildElement("inertial");
  if (!inertial) return;
  const char* name = link.Attribute("name");
  const std::string quoted = std::string("link '") + (name ? name : "") + "'";
  const auto mass = number_in(inertial->FirstChildElement("mass"), "value");
  if (!mass || !std::isfinite(*mass) || *mass < 0) {
    throw std::invalid_argument(quoted + " has a mass that is not a number of 0 or more");
  }
  const auto* tensor = inertial->FirstChildElement("inertia");
  if (!tensor) return;
  Eigen::Matrix3d inertia;
  const auto set = [&](const char* key, int row, int column) {
    const auto value = number_in(tensor, key);
    if (!value || !std::isfinite(*value)) {
      throw std::invalid_argument(quoted + " has an inertia whose '" + key + "' is not a finite number");
    }
    inertia(row, column) = inertia(column, row) = *value;
  };
  set("ixx", 0, 0);
  set("iyy", 1, 1);
  set("izz", 2, 2);
  set("ixy", 0, 1);
  set("ixz", 0, 2);
  set("iyz", 1, 2);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(inertia, Eigen::EigenvaluesOnly);
  constexpr double kRounding = 1e-2;  // of the largest moment: published URDFs give two digits
  if (solver.eigenvalues()[0] < -kRounding * std::abs(solver.eigenvalues()[2])) {
    throw std::invalid_argument(quoted + " has an inertia with a negative principal moment");
  }
}

/// Prepares the URDF for MuJoCo: removes shapes (their mesh files need not exist) and adds compiler settings that keep
/// every link by its name. Reads the joints' effort and velocity limits, where they are positive.
std::string prepared(const std::string& urdf_xml, std::map<std::string, double>& effort,
                     std::map<std::string, double>& velocity) {
  tinyxml2::XMLDocument document;
  parse_urdf_document(urdf_xml, document);
  tinyxml2::XMLElement* robot = document.FirstChildElement("robot");
  for (auto* link = robot->FirstChildElement("link"); link; link = link->NextSiblingElement("link")) {
    require_physical_inertia(*link);
    for (const char* shape : {"visual", "collision"}) {
      while (auto* element = link->FirstChildElement(shape)) link->DeleteChild(element);
    }
  }
  for (auto* joint = robot->FirstChildElement("joint"); joint; joint = joint->NextSiblingElement("joint")) {
    const char* name = joint->Attribute("name");
    const auto* limit = joint->FirstChildElement("limit");
    if (!name || !limit) continue;
    if (limit->DoubleAttribute("effort") > 0) effort[name] = limit->DoubleAttribute("effort");
    if (limit->DoubleAttribute("velocity") > 0) velocity[name] = limit->DoubleAttribute("velocity");
  }
  while (auto* old = robot->FirstChildElement("mujoco")) robot->DeleteChild(old);
  auto* compiler = robot->InsertNewChildElement("mujoco")->InsertNewChildElement("compiler");
  compiler->SetAttribute("fusestatic", "false");
  compiler->SetAttribute("balanceinertia", "true");
  compiler->SetAttribute("boundmass", "0.001");
  compiler->SetAttribute("boundinertia", "0.000001");
  tinyxml2::XMLPrinter printer;
  document.Print(&printer);
  return printer.CStr();
}

/// The share, 0 to 1, of these torques that the drives can add to `bias`. Were each joint clamped by itself, the others
/// would get torques for accelerations that it does not reach, and throw it to and fro. A drive that the bias loads by
/// more than kLoaded counts as loaded so much: it is clamped by itself, and does not stop all others.
double feasible_share(const std::vector<double>& torques, const mjtNum* bias, const std::vector<double>& effort) {
  constexpr double kLoaded = 0.8;
  double share = 1;
  for (size_t i = 0; i < torques.size(); ++i) {
    const double load = std::min(torques[i] < 0 ? -bias[i] : bias[i], kLoaded * effort[i]),
                 wanted = std::abs(torques[i]);
    if (wanted > effort[i] - load) share = std::min(share, (effort[i] - load) / wanted);
  }
  return share;
}

mjModel* load(const std::string& xml) {
  constexpr char kName[] = "robot.urdf";
  auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), kName, static_cast<int>(xml.size()));
  std::copy(xml.begin(), xml.end(), static_cast<char*>(files->filedata[0]));
  char error[1000] = "";
  mjModel* model = mj_loadXML(kName, files.get(), error, sizeof error);
  mj_deleteVFS(files.get());
  if (!model) throw std::invalid_argument(std::string("cannot be loaded by MuJoCo: ") + error);
  return model;
}

}  // namespace

struct MujocoArm::Simulation {
  mjModel* model = nullptr;
  mjData* data = nullptr;
  int pushed_body = -1;
  Eigen::Vector3d push_force{0, 0, 0};

  ~Simulation() {
    if (data) mj_deleteData(data);
    if (model) mj_deleteModel(model);
  }
};

MujocoArm::MujocoArm(const std::string& urdf_xml, const MujocoArmOptions& options)
    : simulation_(std::make_unique<Simulation>()), options_(options) {
  send_messages_to_the_log();
  std::map<std::string, double> effort, velocity;
  mjModel* model = simulation_->model = load(prepared(urdf_xml, effort, velocity));
  const auto limit_of = [](const std::map<std::string, double>& limits, const std::string& joint) {
    const auto found = limits.find(joint);
    return found == limits.end() ? std::numeric_limits<double>::infinity() : found->second;
  };
  for (int joint = 0; joint < model->njnt; ++joint) {
    if (model->jnt_type[joint] != mjJNT_HINGE && model->jnt_type[joint] != mjJNT_SLIDE) {
      throw std::invalid_argument("has a floating or planar joint, which is not simulated");
    }
    joint_names_.emplace_back(mj_id2name(model, mjOBJ_JOINT, joint));
    const bool limited =
        options.limited.empty() || std::ranges::find(options.limited, joint_names_.back()) != options.limited.end();
    effort_.push_back(limited ? limit_of(effort, joint_names_.back()) : std::numeric_limits<double>::infinity());
    fastest_.push_back(limit_of(velocity, joint_names_.back()));
  }
  if (joint_names_.empty()) throw std::invalid_argument("has no joint to simulate");
  model->opt.timestep = options.step_s;
  model->opt.disableflags |= mjDSBL_WARMSTART;
  mju_zero(model->dof_damping, model->nv);
  mju_zero(model->dof_frictionloss, model->nv);
  mjData* data = simulation_->data = mj_makeData(model);
  for (int joint = 0; joint < model->njnt; ++joint) {
    const mjtNum* range = model->jnt_range + 2 * joint;
    if (model->jnt_limited[joint]) data->qpos[model->jnt_qposadr[joint]] = default_joint_position(range[0], range[1]);
  }
  for (const auto& [name, position] : options.start) {
    const int joint = mj_name2id(model, mjOBJ_JOINT, name.c_str());
    if (joint < 0) {
      std::string known;
      for (const std::string& other : joint_names_) known += (known.empty() ? "" : ", ") + other;
      throw StartPositionError("has no joint '" + name + "'; it has " + known);
    }
    const mjtNum* range = model->jnt_range + 2 * joint;
    if (!std::isfinite(position) || (model->jnt_limited[joint] && (position < range[0] || position > range[1]))) {
      throw StartPositionError("has joint '" + name + "' with limits from " + std::to_string(range[0]) + " to " +
                               std::to_string(range[1]) + ", not " + std::to_string(position));
    }
    data->qpos[model->jnt_qposadr[joint]] = position;
  }
  wanted_position_ = positions();
  wanted_velocity_.assign(joint_names_.size(), 0);
  torques_.assign(joint_names_.size(), 0);
}

MujocoArm::~MujocoArm() = default;

// With only hinge and slide joints, joint i has position coordinate i and velocity coordinate i.
std::vector<double> MujocoArm::positions() const {
  return {simulation_->data->qpos, simulation_->data->qpos + joint_names_.size()};
}

std::vector<double> MujocoArm::velocities() const {
  return {simulation_->data->qvel, simulation_->data->qvel + joint_names_.size()};
}

bool MujocoArm::command(const std::string& joint, double position, double velocity) {
  const auto found = std::ranges::find(joint_names_, joint);
  if (found == joint_names_.end()) return false;
  const auto i = static_cast<size_t>(found - joint_names_.begin());
  wanted_position_[i] = position;
  wanted_velocity_[i] = velocity;
  return true;
}

void MujocoArm::hold() {
  std::ranges::fill(wanted_velocity_, 0.0);
}

bool MujocoArm::push(const std::string& link, const Eigen::Vector3d& force_n) {
  const int body = mj_name2id(simulation_->model, mjOBJ_BODY, link.c_str());
  if (body < 0 || !(force_n.norm() < kMaxForce)) return false;
  release();
  simulation_->pushed_body = body;
  simulation_->push_force = force_n;
  return true;
}

void MujocoArm::release() {
  simulation_->pushed_body = -1;
  mju_zero(simulation_->data->xfrc_applied, 6 * simulation_->model->nbody);
}

bool MujocoArm::set_state(const std::vector<double>& positions, const std::vector<double>& velocities) {
  if (positions.size() != joint_names_.size() || velocities.size() != joint_names_.size()) return false;
  std::ranges::copy(positions, simulation_->data->qpos);
  std::ranges::copy(velocities, simulation_->data->qvel);
  return true;
}

void MujocoArm::step() {
  mjModel* model = simulation_->model;
  mjData* data = simulation_->data;
  mj_step1(model, data);
  if (const int body = simulation_->pushed_body; body >= 0) {
    // MuJoCo applies forces at the centre of mass: a force at the link's origin also gives a torque.
    const Eigen::Vector3d origin = Eigen::Map<Eigen::Vector3d>(data->xpos + 3 * body);
    const Eigen::Vector3d centre = Eigen::Map<Eigen::Vector3d>(data->xipos + 3 * body);
    Eigen::Map<Eigen::Vector3d>(data->xfrc_applied + 6 * body) = simulation_->push_force;
    Eigen::Map<Eigen::Vector3d>(data->xfrc_applied + 6 * body + 3) = (origin - centre).cross(simulation_->push_force);
  }
  const double w = options_.natural_frequency_rad_s, z = options_.damping_ratio;
  const auto n = joint_names_.size();
  std::vector<mjtNum> acceleration(n);
  for (size_t i = 0; i < n; ++i) {
    const double bias = data->qfrc_bias[i], speed = data->qvel[i];
    if (std::abs(bias) >= effort_[i]) continue;  // it falls; the others are not to follow its error
    acceleration[i] = w * w * (wanted_position_[i] - data->qpos[i]) + 2 * z * w * (wanted_velocity_[i] - speed);
    // Not beyond the speed limit with the next step.
    acceleration[i] =
        std::clamp(acceleration[i], (-fastest_[i] - speed) / options_.step_s, (fastest_[i] - speed) / options_.step_s);
  }
  mj_mulM(model, data, torques_.data(), acceleration.data());
  // What a push asks of one joint is no reason for the others to give way.
  const double share = simulation_->pushed_body >= 0 ? 1 : feasible_share(torques_, data->qfrc_bias, effort_);
  for (size_t i = 0; i < n; ++i) {
    torques_[i] = std::clamp(share * torques_[i] + data->qfrc_bias[i], -effort_[i], effort_[i]);
    data->qfrc_applied[i] = torques_[i];
  }
  mj_step2(model, data);
}

}  // namespace multireach
