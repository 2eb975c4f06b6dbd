#include "tools/calibrate/calibration_errors.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <stdexcept>
#include <vector>

#include "imaging/rig_errors.hpp"

namespace multireach {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using RigCovariance = Eigen::Matrix<double, RigErrors::kCount, RigErrors::kCount>;

constexpr int kPose = 6;

int coefficients_of(Lens lens) {
  return lens == Lens::kRadtan ? 4 : lens == Lens::kRational ? 8 : 5;
}

Eigen::Matrix3d cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// How the images of a board's corners (rows: x and y in the left image, then in the right one, corner by corner)
/// depend on the cameras and on the board.
struct ViewJacobian {
  MatrixXd by_cameras;   ///< fx fy cx cy k... of the left camera, of the right one, rotation and position of the latter
  MatrixXd by_position;  ///< 4 x 3 for each corner: by its position in the left camera's frame
  MatrixXd by_pose;      ///< by rotation and translation of the board in the left camera's frame
  VectorXd residuals;
  std::vector<Eigen::Vector3d> p_L;
};

/// Derivatives of the images of points (in the camera's frame) by the point and by fx, fy, cx, cy, k...
struct Projected {
  MatrixXd by_point, by_camera;
};

Projected project(const CameraModel& camera, const std::vector<Eigen::Vector3d>& points, int coefficients) {
  std::vector<cv::Point3d> p_C;
  for (const Eigen::Vector3d& p : points) p_C.emplace_back(p.x(), p.y(), p.z());
  const cv::Matx33d K(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  cv::Mat J;
  std::vector<cv::Point2d> pixels;
  cv::projectPoints(p_C, cv::Vec3d(0, 0, 0), cv::Vec3d(0, 0, 0), K, cv::Mat(camera.distortion, true), pixels, J);
  MatrixXd all;
  cv::cv2eigen(J, all);  // rotation, translation, focal lengths, principal point, distortion
  return {all.middleCols<3>(3), all.middleCols(6, 4 + coefficients)};
}

ViewJacobian jacobian_of(const StereoRig& rig, const PairFit& fit, const Board& board, int coefficients) {
  ViewJacobian view;
  std::vector<Eigen::Vector3d> p_R;
  for (const cv::Point3f& corner : board.corners()) {
    view.p_L.push_back(fit.X_LB * Eigen::Vector3d(corner.x, corner.y, corner.z));
    p_R.push_back(rig.X_RL * view.p_L.back());
  }
  const Projected left = project(rig.left, view.p_L, coefficients), right = project(rig.right, p_R, coefficients);
  const auto count = static_cast<Eigen::Index>(p_R.size());
  const Eigen::Index camera = 4 + coefficients;
  view.by_cameras = MatrixXd::Zero(4 * count, 2 * camera + kPose);
  view.by_position.resize(4 * count, 3);
  view.by_pose.resize(4 * count, kPose);
  view.residuals.resize(4 * count);
  const Eigen::Matrix3d R_RL = rig.X_RL.linear();
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto at = static_cast<size_t>(k);
    const Eigen::Matrix<double, 2, 3> right_by_point = right.by_point.middleRows<2>(2 * k);
    view.by_cameras.block(4 * k, 0, 2, camera) = left.by_camera.middleRows<2>(2 * k);
    view.by_cameras.block(4 * k + 2, camera, 2, camera) = right.by_camera.middleRows<2>(2 * k);
    view.by_cameras.block<2, 3>(4 * k + 2, 2 * camera) = -right_by_point * cross(p_R[at]);
    view.by_cameras.block<2, 3>(4 * k + 2, 2 * camera + 3) = -right_by_point * R_RL;
    view.by_position.middleRows<4>(4 * k) << left.by_point.middleRows<2>(2 * k), right_by_point * R_RL;
    Eigen::Matrix<double, 3, kPose> by_pose;
    by_pose << -cross(view.p_L[at]), Eigen::Matrix3d::Identity();
    view.by_pose.middleRows<4>(4 * k) = view.by_position.middleRows<4>(4 * k) * by_pose;
    view.residuals.segment<4>(4 * k) << fit.left_residuals[at].x, fit.left_residuals[at].y, fit.right_residuals[at].x,
        fit.right_residuals[at].y;
  }
  return view;
}

/// Removes from the columns of `J` what a change of the board's pose explains.
MatrixXd without_pose(const ViewJacobian& view, const MatrixXd& J) {
  const MatrixXd& A = view.by_pose;
  return J - A * (A.transpose() * A).ldlt().solve(A.transpose() * J);
}

/// The linear map from the errors of all parameters of the cameras to RigErrors: least squares, in pixels, over the
/// images of the corners. A common rotation of everything is fitted as well: it is an error of the camera pose.
/// Vertical disparities count although they hardly move positions: without them, the rotation about x would be
/// undetermined.
MatrixXd map_to_rig_errors(const StereoRig& rig, const std::vector<ViewJacobian>& views) {
  constexpr int kRotation = 3, kUnknowns = RigErrors::kCount + kRotation;
  MatrixXd normal = MatrixXd::Zero(kUnknowns, kUnknowns);
  MatrixXd right_side = MatrixXd::Zero(kUnknowns, views.front().by_cameras.cols());
  for (const ViewJacobian& view : views) {
    for (size_t k = 0; k < view.p_L.size(); ++k) {
      const auto row = 4 * static_cast<Eigen::Index>(k);
      Eigen::Matrix<double, 4, kUnknowns> effective;
      effective << d_pixels_d_errors(rig, view.p_L[k]), view.by_position.middleRows<4>(row) * cross(view.p_L[k]);
      normal += effective.transpose() * effective;
      right_side += effective.transpose() * view.by_cameras.middleRows<4>(row);
    }
  }
  return normal.ldlt().solve(right_side).topRows<RigErrors::kCount>();
}

/// How much these errors move positions: the sum over all corners of the squared movement, in pixels.
RigCovariance weight_of_positions(const StereoRig& rig, const std::vector<ViewJacobian>& views) {
  RigCovariance weight = RigCovariance::Zero();
  for (const ViewJacobian& view : views) {
    for (size_t k = 0; k < view.p_L.size(); ++k) {
      const Eigen::Matrix<double, 4, RigErrors::kCount> moved =
          view.by_position.middleRows<4>(4 * static_cast<Eigen::Index>(k)) * d_position_d_errors(rig, view.p_L[k]);
      weight += moved.transpose() * moved;
    }
  }
  return weight;
}

/// A view's part in the normal equations of the cameras' parameters.
struct ViewEquations {
  MatrixXd information;
  VectorXd gradient;
};

/// Covariance of what `map` takes from the parameters, by how much the views contradict each other, whatever the cause.
/// Of each view, the residuals are enlarged by what the fit has adapted to them, so that the result is unbiased for
/// independent residuals of variance 1 (the estimator CR2 of Bell and McCaffrey, Survey Methodology 28, 2002). `root`:
/// L with information^-1 = L L^T.
RigCovariance covariance_by_views(const std::vector<ViewEquations>& views, const MatrixXd& root, const MatrixXd& map) {
  constexpr double kLeast = 1e-3;  // of a view that alone determines something, the residuals tell nothing
  RigCovariance sum = RigCovariance::Zero();
  for (const ViewEquations& view : views) {
    const Eigen::SelfAdjointEigenSolver<MatrixXd> leverage(root.transpose() * view.information * root);
    const MatrixXd& V = leverage.eigenvectors();
    const VectorXd enlarged = (1 - leverage.eigenvalues().array()).max(kLeast).rsqrt().matrix();
    const Eigen::Matrix<double, RigErrors::kCount, 1> change =
        map * (root * (V * enlarged.asDiagonal() * (V.transpose() * (root.transpose() * view.gradient))));
    sum += change * change.transpose();
  }
  return sum;
}

}  // namespace

CalibrationErrors errors_of(const StereoCalibration& calibration, const Board& board, Lens lens) {
  const StereoRig& rig = calibration.rig;
  std::vector<ViewJacobian> views;
  for (const PairFit& fit : calibration.fits) {
    if (fit.used) views.push_back(jacobian_of(rig, fit, board, coefficients_of(lens)));
  }
  const Eigen::Index parameters = views.front().by_cameras.cols();
  MatrixXd information = MatrixXd::Zero(parameters, parameters);
  std::vector<ViewEquations> equations;
  double sum2 = 0;
  Eigen::Index degrees = -parameters;
  for (const ViewJacobian& view : views) {
    const MatrixXd J = without_pose(view, view.by_cameras);
    equations.push_back({J.transpose() * J, J.transpose() * view.residuals});
    information += equations.back().information;
    sum2 += view.residuals.squaredNorm();
    degrees += view.residuals.size() - kPose;
  }
  // The parameters differ by many orders of magnitude.
  const VectorXd scale = information.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LLT<MatrixXd> factors(scale.asDiagonal() * information * scale.asDiagonal());
  if (factors.info() != Eigen::Success || degrees <= 0)
    throw std::runtime_error("these pairs do not determine the cameras: take more, with the board tilted differently");
  const MatrixXd identity = MatrixXd::Identity(parameters, parameters);
  const MatrixXd root = scale.asDiagonal() * factors.matrixU().solve(identity);
  const MatrixXd map = map_to_rig_errors(rig, views), mapped = map * root;

  CalibrationErrors errors;
  errors.noise_px = std::sqrt(sum2 / static_cast<double>(degrees));
  const RigCovariance independent = errors.noise_px * errors.noise_px * mapped * mapped.transpose();
  const RigCovariance weight = weight_of_positions(rig, views);
  const double ratio = (weight * covariance_by_views(equations, root, map)).trace() / (weight * independent).trace();
  errors.view_factor = std::max(1.0, ratio);
  errors.rig.covariance = errors.view_factor * independent;
  return errors;
}

double axial_sigma_m(const StereoRig& rig, double distance_m) {
  return std::sqrt(covariance_by_rig_errors(rig, rig.X_WL * Eigen::Vector3d(0, 0, distance_m)).trace());
}

}  // namespace multireach
