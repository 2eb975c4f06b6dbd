#include "tools/calibrate/hand_eye_output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "tools/calibrate/camera_file_texts.hpp"

namespace multireach {

std::string hand_eye_summary(const HandEye& result, const HandEyeOptions& options) {
  const auto sigmas = [](const auto& covariance, int from, double scale) {
    const Eigen::Vector3d s = scale * covariance.diagonal().template segment<3>(from).cwiseSqrt();
    return fmt::format("{:.3f}, {:.3f}, {:.3f}", s.x(), s.y(), s.z());
  };
  const Eigen::Vector3d t = 1e3 * result.X_WL.translation();
  std::string text = fmt::format(
      "positions used {} of {}, {:.2f} mm rms, chi2 per degree of freedom {:.2f}\n"
      "left camera    {:.2f}, {:.2f}, {:.2f} mm in W, sigma {} mm; rotation sigma {} degrees\n",
      std::ranges::count(result.outlier, false), result.outlier.size(), 1e3 * result.rms_m, result.chi2_per_dof, t.x(),
      t.y(), t.z(), sigmas(result.covariance, 3, 1e3), sigmas(result.covariance, 0, 180 / std::numbers::pi));
  if (options.estimate_offset) {
    const Eigen::Vector3d o = 1e3 * result.p_HT;
    text += fmt::format("target         {:.2f}, {:.2f}, {:.2f} mm in the hand's frame, sigma {} mm\n", o.x(), o.y(),
                        o.z(), sigmas(result.offset_covariance, 0, 1e3));
  }
  return text;
}

std::string hand_eye_text(const HandEye& result, const HandEyeOptions& options) {
  std::string comment = "# " + hand_eye_summary(result, options);
  for (size_t at = comment.find('\n'); at + 1 < comment.size(); at = comment.find('\n', at + 1))
    comment.insert(at + 1, "# ");
  return comment + "left_to_robot:   # X_WL: a point in the left camera's frame to the robot's base\n" +
         transform_text(result.X_WL, "  ");
}

}  // namespace multireach
