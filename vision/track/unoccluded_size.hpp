#pragma once

#include <Eigen/Core>

namespace multireach::vision {

/// The size of a tracked object that need not be a sphere, when all of it is seen. Where it looks smaller than before,
/// it may have turned, or something occludes a part of it: its centre is then uncertain.
class UnoccludedSize {
 public:
  /// `radius_m`: of a disc of its area, at its distance. `elapsed_s`: since the last one.
  void update(double radius_m, double elapsed_s);
  /// Covariance of the centre of the object that now has this radius, m^2, in any frame: of one that is about as long
  /// as wide, where what is not seen of its area is at one end.
  Eigen::Matrix3d occlusion_covariance(double radius_m) const;

  double radius_m() const { return radius_m_; }  ///< 0: not known
  void set_radius_m(double radius_m) { radius_m_ = radius_m; }

 private:
  double radius_m_ = 0;
};

}  // namespace multireach::vision
