#include "tools/publish/messages.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <stdexcept>

#include "kinematics/urdf_document.hpp"
#include "runtime/files.hpp"

namespace multireach {
namespace {

constexpr double kVariance = 1e-6;  // m^2

struct Shape {
  const char* name;
  int8_t shape;
  size_t sizes;
  const char* expected;
};

constexpr Shape kShapes[] = {{"sphere", obstacle_t::SPHERE, 1, "one size, the radius"},
                             {"capsule", obstacle_t::CAPSULE, 2, "two sizes, radius and length of the axis"},
                             {"box", obstacle_t::BOX, 3, "three sizes, the lengths along x, y and z"}};

Eigen::Vector4d unit_quaternion(const std::vector<double>& wxyz) {
  const Eigen::Map<const Eigen::Vector4d> quaternion(wxyz.data());
  if (!(quaternion.norm() > 1e-6)) throw InputError("--orientation: the quaternion is zero");
  return quaternion.normalized();
}

}  // namespace

target_t target_message(const std::string& name, const Eigen::Vector3d& p_WT, const std::vector<double>& wxyz,
                        int64_t utime, int64_t sequence, int64_t run) {
  target_t target{};
  target.utime = target.last_seen_utime = utime;
  target.sequence = sequence;
  target.run = run;
  target.left_frame_utime = target.right_frame_utime = target.pair_sequence = -1;
  target.status = target_t::STATUS_TRACKED;
  target.name = name;
  target.reason = "seen";
  Eigen::Map<Eigen::Vector3d>(target.position_m) = p_WT;
  for (int i = 0; i < 3; ++i) target.covariance_m2[i][i] = kVariance;
  if (wxyz.empty()) return target;
  target.has_orientation = true;
  Eigen::Map<Eigen::Vector4d>(target.orientation_wxyz) = unit_quaternion(wxyz);
  return target;
}

obstacle_t obstacle_message(const std::string& shape, const Eigen::Vector3d& p_WO, const std::vector<double>& size,
                            const std::vector<double>& wxyz) {
  const auto* kind = std::ranges::find(kShapes, shape, &Shape::name);
  if (kind == std::end(kShapes))
    throw InputError("obstacle: '" + shape + "' is no shape; expected sphere, capsule or box");
  const bool positive = std::ranges::all_of(size, [](double value) { return value > 0; });
  if (size.size() != kind->sizes || !positive)
    throw InputError("obstacle: a " + shape + " has " + kind->expected + ", in metres and positive");
  obstacle_t obstacle{};
  obstacle.name = shape;
  obstacle.shape = kind->shape;
  Eigen::Map<Eigen::Vector3d>(obstacle.position_m) = p_WO;
  Eigen::Map<Eigen::Vector4d>(obstacle.orientation_wxyz) = unit_quaternion(wxyz);
  std::ranges::copy(size, obstacle.size_m);
  return obstacle;
}

void require_link(const std::string& urdf_path, const std::string& link) {
  UrdfTree tree;
  try {
    tree = urdf_tree(read_text_file(urdf_path));
  } catch (const std::invalid_argument& fault) {
    throw InputError(urdf_path + ": " + fault.what());
  }
  if (std::ranges::find(tree.links, link) != tree.links.end()) return;
  std::string names;
  for (const std::string& name : tree.links) names += (names.empty() ? "" : ", ") + name;
  throw InputError("perturbation: " + urdf_path + " has no link '" + link + "'; it has " + names);
}

perturbation_t perturbation_message(const std::string& link, const Eigen::Vector3d& force, double duration_s,
                                    int64_t utime) {
  perturbation_t push{};
  push.utime = utime;
  push.duration_us = static_cast<int64_t>(duration_s * 1e6);
  push.link_name = link;
  Eigen::Map<Eigen::Vector3d>(push.force_n) = force;
  return push;
}

}  // namespace multireach
