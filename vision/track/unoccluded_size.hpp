#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace multireach::vision {

/// The size of an object that need not be a sphere, when all of it is seen. Where it looks smaller than in the last
/// half minute, it may have turned, or something occludes a part of it: its centre is then uncertain.
class UnoccludedSize {
 public:
  /// `radius_m`: of a disc of its area, at its distance. `utime`: when it was seen so, us. Changes nothing where it is
  /// suddenly larger.
  void update(double radius_m, int64_t utime);
  /// Covariance of the centre of the object that has this radius at a time, m^2, in any frame: of one that is about as
  /// long as wide, where what is not seen of its area is at one end.
  Eigen::Matrix3d occlusion_covariance(double radius_m, int64_t utime) const;

  /// Whether something that has this radius at a time is suddenly larger by more than a fifth: the object with
  /// something else beside it, or one that something occluded before. After ten seconds it counts as the object.
  bool is_suddenly_larger(double radius_m, int64_t utime) const;
  /// Covariance of the centre of the object in a blob that is larger because it shows something else at one end, m^2.
  Eigen::Matrix3d surplus_covariance(double radius_m) const;

  double radius_m() const { return radius_m_; }  ///< 0: not known
  int64_t utime() const { return utime_; }       ///< of the last update, us
  void set_state(double radius_m, int64_t utime) {
    radius_m_ = radius_m;
    utime_ = utime;
  }

 private:
  double updated(double radius_m, int64_t utime) const;

  double radius_m_ = 0;
  int64_t utime_ = 0;
};

}  // namespace multireach::vision
