#pragma once

#include <Eigen/Core>
#include <multireach/obstacles_t.hpp>
#include <multireach/perturbation_t.hpp>
#include <multireach/target_t.hpp>
#include <string>
#include <vector>

namespace multireach {

/// A tracked target at rest at `p_WT` (m, in W), 1 mm sure in each direction, which no camera saw. `wxyz`: rotation
/// from its frame to W, or empty. Throws InputError for a quaternion without a direction.
target_t target_message(const std::string& name, const Eigen::Vector3d& p_WT, const std::vector<double>& wxyz,
                        int64_t utime, int64_t sequence, int64_t run);

/// One obstacle with its centre at `p_WO` (m, in W) and orientation `wxyz`. `size` in metres: radius of a sphere;
/// radius and length of a capsule; three lengths of a box. Throws InputError for another shape, a size that is not
/// positive, a wrong number of sizes, and a quaternion without a direction.
obstacle_t obstacle_message(const std::string& shape, const Eigen::Vector3d& p_WO, const std::vector<double>& size,
                            const std::vector<double>& wxyz);

/// Throws InputError where the URDF has no link of this name; the message lists its links.
void require_link(const std::string& urdf_path, const std::string& link);
/// A push with `force` (N, in W) at the origin of a link for `duration_s`.
perturbation_t perturbation_message(const std::string& link, const Eigen::Vector3d& force, double duration_s,
                                    int64_t utime);

}  // namespace multireach
