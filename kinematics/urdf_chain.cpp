#include "kinematics/urdf_chain.hpp"

#include <console_bridge/console.h>
#include <tinyxml2.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <locale>
#include <map>
#include <sstream>
#include <stdexcept>
#include <tuple>

#include "kinematics/urdf_document.hpp"
#include "numeric/trigonometry.hpp"

namespace multireach {
namespace {

/// Redirects urdfdom's messages to `text` during its lifetime.
class CapturedComplaints : public console_bridge::OutputHandler {
 public:
  CapturedComplaints() { console_bridge::useOutputHandler(this); }
  ~CapturedComplaints() override { console_bridge::restorePreviousOutputHandler(); }
  CapturedComplaints(const CapturedComplaints&) = delete;
  CapturedComplaints& operator=(const CapturedComplaints&) = delete;
  void log(const std::string& line, console_bridge::LogLevel level, const char*, int) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_WARN) text += (text.empty() ? "" : "; ") + line;
  }
  std::string text;
};

/// Roll, pitch and yaw of each joint's origin, as written in the URDF. urdfdom provides only rotations computed with
/// the C library's sine, whose last bit depends on the processor.
std::map<std::string, Eigen::Vector3d> rpy_of_joints(const tinyxml2::XMLDocument& document) {
  std::map<std::string, Eigen::Vector3d> found;
  const tinyxml2::XMLElement* robot = document.FirstChildElement("robot");
  for (auto* joint = robot->FirstChildElement("joint"); joint; joint = joint->NextSiblingElement("joint")) {
    const auto* origin = joint->FirstChildElement("origin");
    const char* name = joint->Attribute("name");
    const char* text = origin ? origin->Attribute("rpy") : nullptr;
    if (!name || !text) continue;
    std::istringstream numbers(text);
    numbers.imbue(std::locale::classic());
    Eigen::Vector3d rpy;
    if (numbers >> rpy.x() >> rpy.y() >> rpy.z()) found[name] = rpy;
  }
  return found;
}

/// Which soft limits the URDF writes. urdfdom reads those that are not written as 0.
struct WrittenSoftLimits {
  bool lower = false, upper = false;
};

std::map<std::string, WrittenSoftLimits> soft_limits_of_joints(const tinyxml2::XMLDocument& document) {
  std::map<std::string, WrittenSoftLimits> found;
  const tinyxml2::XMLElement* robot = document.FirstChildElement("robot");
  for (auto* joint = robot->FirstChildElement("joint"); joint; joint = joint->NextSiblingElement("joint")) {
    const auto* safety = joint->FirstChildElement("safety_controller");
    const char* name = joint->Attribute("name");
    if (!name || !safety) continue;
    found[name] = {safety->Attribute("soft_lower_limit") != nullptr, safety->Attribute("soft_upper_limit") != nullptr};
  }
  return found;
}

/// Narrows the limits of a joint to the soft limits of its `safety_controller`. Two equal ones, as 0 and 0, are those
/// of a file that means none.
void narrow_to_soft_limits(const urdf::Joint& source, const WrittenSoftLimits& written, Joint& joint) {
  if (!source.safety || !joint.limited()) return;
  const double lower = source.safety->soft_lower_limit, upper = source.safety->soft_upper_limit;
  if (written.lower && written.upper && lower == upper) return;
  const std::string quoted = "joint '" + source.name + "'";
  if (!std::isfinite(lower) || !std::isfinite(upper))
    throw std::invalid_argument(quoted + " has a soft limit that is not a finite number");
  if (written.lower) joint.lower = std::max(joint.lower, lower);
  if (written.upper) joint.upper = std::min(joint.upper, upper);
  if (joint.lower > joint.upper) {
    throw std::invalid_argument(quoted + " has soft limits from " + std::to_string(lower) + " to " +
                                std::to_string(upper) + ", which leave nothing of its limits " +
                                std::to_string(source.limits->lower) + " to " + std::to_string(source.limits->upper));
  }
}

Eigen::Isometry3d isometry(const urdf::Joint& joint, const std::map<std::string, Eigen::Vector3d>& rpy) {
  const urdf::Pose& pose = joint.parent_to_joint_origin_transform;
  Eigen::Quaterniond rotation(pose.rotation.w, pose.rotation.x, pose.rotation.y, pose.rotation.z);
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = rotation.normalized().toRotationMatrix();
  if (const auto written = rpy.find(joint.name); written != rpy.end()) {
    const Eigen::Matrix3d R = rotation_from_rpy(written->second);
    if (R.isApprox(X.linear(), 1e-9)) X.linear() = R;
  }
  X.translation() = Eigen::Vector3d(pose.position.x, pose.position.y, pose.position.z);
  return X;
}

double positive_or_infinite(double limit) {
  return limit > 0 ? limit : std::numeric_limits<double>::infinity();
}

/// Converts a moving URDF joint. `reversed`: the chain passes it from child to parent.
Joint joint_from(const urdf::Joint& source, bool reversed) {
  const std::string quoted = "joint '" + source.name + "'";
  if (source.mimic)
    throw std::invalid_argument(quoted + " mimics joint '" + source.mimic->joint_name +
                                "'; a mimic joint cannot be driven");
  Joint joint;
  joint.name = source.name;
  switch (source.type) {
    case urdf::Joint::REVOLUTE:
      joint.type = Joint::Type::kRevolute;
      break;
    case urdf::Joint::CONTINUOUS:
      joint.type = Joint::Type::kContinuous;
      break;
    case urdf::Joint::PRISMATIC:
      joint.type = Joint::Type::kPrismatic;
      break;
    case urdf::Joint::FLOATING:
      throw std::invalid_argument(quoted +
                                  " is floating; a chain may have revolute, continuous, prismatic and fixed joints");
    case urdf::Joint::PLANAR:
      throw std::invalid_argument(quoted +
                                  " is planar; a chain may have revolute, continuous, prismatic and fixed joints");
    default:
      throw std::invalid_argument(quoted + " is of a type that is not supported");
  }
  joint.axis = Eigen::Vector3d(source.axis.x, source.axis.y, source.axis.z);
  const double length = joint.axis.norm();
  if (!std::isfinite(length) || length < 1e-6) throw std::invalid_argument(quoted + " has an axis of no length");
  joint.axis /= reversed ? -length : length;
  const double infinity = std::numeric_limits<double>::infinity();
  joint.velocity = joint.effort = infinity;
  if (source.limits) {
    joint.velocity = source.limits->velocity;
    if (!(joint.velocity > 0)) {
      throw std::invalid_argument(quoted + " has the velocity limit " + std::to_string(joint.velocity) +
                                  "; it must be positive");
    }
    joint.effort = positive_or_infinite(source.limits->effort);
  }
  if (!joint.limited()) {
    joint.lower = -infinity;
    joint.upper = infinity;
    return joint;
  }
  if (!source.limits) throw std::invalid_argument(quoted + " has no limits");
  joint.lower = source.limits->lower;
  joint.upper = source.limits->upper;
  if (!std::isfinite(joint.lower) || !std::isfinite(joint.upper))
    throw std::invalid_argument(quoted + " has a limit that is not a finite number");
  if (joint.lower > joint.upper) throw std::invalid_argument(quoted + " has its lower limit above its upper limit");
  if (joint.lower == joint.upper) {  // also where neither is written
    throw std::invalid_argument(quoted + " has the limits " + std::to_string(joint.lower) + " and " +
                                std::to_string(joint.upper) +
                                ": it cannot move; give its lower and upper limit, or the type fixed");
  }
  return joint;
}

/// The links from `link` to the root of the URDF tree, `link` first.
std::vector<urdf::LinkConstSharedPtr> ancestry(urdf::LinkConstSharedPtr link) {
  std::vector<urdf::LinkConstSharedPtr> links;
  for (; link; link = link->getParent()) links.push_back(link);
  return links;
}

}  // namespace

Chain chain_from_urdf(std::string_view urdf_xml, const std::string& base, const std::string& tip) {
  tinyxml2::XMLDocument document;
  parse_urdf_document(urdf_xml, document);
  // urdfdom gets the text as tinyxml2 understood it, so that both read the same elements.
  tinyxml2::XMLPrinter checked;
  document.Print(&checked);
  CapturedComplaints complaints;
  const urdf::ModelInterfaceSharedPtr model = urdf::parseURDF(checked.CStr());
  if (!model) {
    throw std::invalid_argument("is not a valid URDF" + (complaints.text.empty() ? "" : ": " + complaints.text));
  }
  const urdf::LinkConstSharedPtr base_link = model->getLink(base), tip_link = model->getLink(tip);
  for (const auto& [link, name, option] : {std::tuple(base_link, base, "base"), std::tuple(tip_link, tip, "tip")}) {
    if (link) continue;
    std::string names;
    for (const auto& [known, ignored] : model->links_) {
      if (!names.empty()) names += ", ";
      names += known;
    }
    throw UnknownLinkError(option, name, names);
  }
  const auto rpy = rpy_of_joints(document);
  const auto soft_limits = soft_limits_of_joints(document);
  const auto joint_of = [&](const urdf::Joint& source, bool reversed) {
    Joint joint = joint_from(source, reversed);
    const auto written = soft_limits.find(source.name);
    if (written != soft_limits.end()) narrow_to_soft_limits(source, written->second, joint);
    return joint;
  };
  std::vector<urdf::LinkConstSharedPtr> up = ancestry(base_link), down = ancestry(tip_link);
  while (up.size() > 1 && down.size() > 1 && up[up.size() - 2] == down[down.size() - 2]) {
    up.pop_back();
    down.pop_back();
  }
  // Now both lists end at the lowest common ancestor of the base and the tip.
  std::vector<Joint> joints;
  std::vector<Eigen::Isometry3d> fixed{Eigen::Isometry3d::Identity()};
  for (size_t i = 0; i + 1 < up.size(); ++i) {
    const urdf::Joint& source = *up[i]->parent_joint;
    if (source.type != urdf::Joint::FIXED) {
      joints.push_back(joint_of(source, true));
      fixed.push_back(Eigen::Isometry3d::Identity());
    }
    fixed.back() = fixed.back() * isometry(source, rpy).inverse();
  }
  for (size_t i = down.size() - 1; i-- > 0;) {
    const urdf::Joint& source = *down[i]->parent_joint;
    fixed.back() = fixed.back() * isometry(source, rpy);
    if (source.type == urdf::Joint::FIXED) continue;
    joints.push_back(joint_of(source, false));
    fixed.push_back(Eigen::Isometry3d::Identity());
  }
  return Chain(std::move(joints), std::move(fixed), base, tip);
}

}  // namespace multireach
