#include "tools/calibrate/stereo_calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/calib3d.hpp>
#include <stdexcept>

#include "tools/calibrate/calibration_errors.hpp"
#include "tools/calibrate/rigid_fit.hpp"

namespace multireach {
namespace {

constexpr const char* kAdvice =
    "; take more pairs, with the board tilted in different ways and at different places and distances";

struct Cameras {
  cv::Mat K[2], D[2], R, T;
};

struct Views {
  std::vector<std::vector<cv::Point3f>> board;
  std::vector<Corners> corners[2];
};

Views views_of(const std::vector<BoardPair>& pairs, const Board& board, const std::vector<PairFit>& fits) {
  Views views;
  for (size_t k = 0; k < pairs.size(); ++k) {
    if (!fits[k].used) continue;
    views.board.push_back(board.corners());
    views.corners[0].push_back(pairs[k].left);
    views.corners[1].push_back(pairs[k].right);
  }
  return views;
}

int flags_of(Lens lens) {
  return lens == Lens::kRadtan ? cv::CALIB_FIX_K3 : lens == Lens::kRational ? cv::CALIB_RATIONAL_MODEL : 0;
}

/// Calibrates both cameras and their relative pose, from an initial guess of K and D.
double solve_both(const Views& views, cv::Size size, Lens lens, Cameras& cameras) {
  cv::Mat E, F;
  const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 200, 1e-9);
  return cv::stereoCalibrate(views.board, views.corners[0], views.corners[1], cameras.K[0], cameras.D[0], cameras.K[1],
                             cameras.D[1], size, cameras.R, cameras.T, E, F,
                             cv::CALIB_USE_INTRINSIC_GUESS | flags_of(lens), until);
}

CameraModel model_of(const cv::Mat& K, const cv::Mat& D, cv::Size size) {
  CameraModel camera{.width = size.width,
                     .height = size.height,
                     .fx = K.at<double>(0, 0),
                     .fy = K.at<double>(1, 1),
                     .cx = K.at<double>(0, 2),
                     .cy = K.at<double>(1, 2),
                     .distortion = {}};
  std::copy_n(D.ptr<double>(), std::min(D.total(), camera.distortion.size()), camera.distortion.begin());
  return camera;
}

StereoRig rig_of(const Cameras& cameras, cv::Size size) {
  StereoRig rig;
  rig.left = model_of(cameras.K[0], cameras.D[0], size);
  rig.right = model_of(cameras.K[1], cameras.D[1], size);
  rig.X_WL.setIdentity();
  rig.X_RL.setIdentity();
  rig.X_RL.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(cameras.R.ptr<double>());
  rig.X_RL.translation() = Eigen::Map<const Eigen::Vector3d>(cameras.T.ptr<double>());
  return rig;
}

/// The residuals of a pair for the best board pose: Gauss-Newton steps from the pose found in the left image.
PairFit fit_of(const BoardPair& pair, const Board& board, const Cameras& cameras) {
  const std::vector<cv::Point3f> points = board.corners();
  const auto count = static_cast<int>(points.size());
  cv::Mat turn, shift, rig_turn;
  cv::solvePnP(points, pair.left, cameras.K[0], cameras.D[0], turn, shift);
  cv::Rodrigues(cameras.R, rig_turn);
  PairFit fit;
  constexpr int kSteps = 8;
  for (int step = 0; step <= kSteps; ++step) {
    cv::Mat turn_R, shift_R, rr, rt, tr, tt, unused, left_J, right_J;
    cv::composeRT(turn, shift, rig_turn, cameras.T, turn_R, shift_R, rr, rt, unused, unused, tr, tt);
    Corners left, right;
    cv::projectPoints(points, turn, shift, cameras.K[0], cameras.D[0], left, left_J);
    cv::projectPoints(points, turn_R, shift_R, cameras.K[1], cameras.D[1], right, right_J);
    fit.left_residuals.resize(points.size());
    fit.right_residuals.resize(points.size());
    cv::Mat residuals(4 * count, 1, CV_64F), J(4 * count, 6, CV_64F), d_right(6, 6, CV_64F);
    for (int k = 0; k < count; ++k) {
      const auto at = static_cast<size_t>(k);
      fit.left_residuals[at] = pair.left[at] - left[at];
      fit.right_residuals[at] = pair.right[at] - right[at];
      residuals.at<double>(2 * k) = fit.left_residuals[at].x;
      residuals.at<double>(2 * k + 1) = fit.left_residuals[at].y;
      residuals.at<double>(2 * (count + k)) = fit.right_residuals[at].x;
      residuals.at<double>(2 * (count + k) + 1) = fit.right_residuals[at].y;
    }
    if (step == kSteps) break;
    rr.copyTo(d_right(cv::Rect(0, 0, 3, 3)));
    rt.copyTo(d_right(cv::Rect(3, 0, 3, 3)));
    tr.copyTo(d_right(cv::Rect(0, 3, 3, 3)));
    tt.copyTo(d_right(cv::Rect(3, 3, 3, 3)));
    left_J.colRange(0, 6).copyTo(J.rowRange(0, 2 * count));
    J.rowRange(2 * count, 4 * count) = right_J.colRange(0, 6) * d_right;
    cv::Mat change;
    cv::solve(J, residuals, change, cv::DECOMP_SVD);
    turn += change.rowRange(0, 3);
    shift += change.rowRange(3, 6);
  }
  cv::Mat R_LB;
  cv::Rodrigues(turn, R_LB);
  fit.X_LB.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(R_LB.ptr<double>());
  fit.X_LB.translation() = Eigen::Map<const Eigen::Vector3d>(shift.ptr<double>());
  const auto rms = [](const Corners& residuals) {
    double sum = 0;
    for (const cv::Point2f& r : residuals) sum += static_cast<double>(r.x) * r.x + static_cast<double>(r.y) * r.y;
    return std::sqrt(sum / static_cast<double>(residuals.size()));
  };
  fit.left_rms_px = rms(fit.left_residuals);
  fit.right_rms_px = rms(fit.right_residuals);
  return fit;
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

/// The residual above which a pair is poor: the board moved between the two images, was bent, or was detected wrongly.
/// Five robust standard deviations (1.48 median deviations), and at least twice the median, because few pairs may agree
/// by chance.
double poor_above(const std::vector<PairFit>& fits) {
  std::vector<double> values;
  for (const PairFit& fit : fits) {
    if (fit.used) values.push_back(fit.rms_px());
  }
  const double middle = median(values);
  for (double& value : values) value = std::abs(value - middle);
  return std::max(2 * middle, middle + 5 * 1.4826 * median(values));
}

StereoCalibration calibrate_used(const std::vector<BoardPair>& pairs, const Board& board, cv::Size size, Lens lens,
                                 std::vector<PairFit>& fits) {
  const Views views = views_of(pairs, board, fits);
  StereoCalibration result;
  Cameras cameras;
  for (const int side : {0, 1}) {
    std::vector<cv::Mat> turns, shifts;
    cv::Mat sigmas, unused;
    const double rms = cv::calibrateCamera(views.board, views.corners[side], size, cameras.K[side], cameras.D[side],
                                           turns, shifts, sigmas, unused, unused, flags_of(lens));
    (side == 0 ? result.left_rms_px : result.right_rms_px) = rms;
    (side == 0 ? result.left_fx_sigma_px : result.right_fx_sigma_px) = sigmas.at<double>(0);
  }
  result.stereo_rms_px = solve_both(views, size, lens, cameras);
  result.rig = rig_of(cameras, size);
  for (size_t k = 0; k < pairs.size(); ++k) {
    const bool used = fits[k].used, poor = fits[k].poor;
    fits[k] = fit_of(pairs[k], board, cameras);
    fits[k].used = used;
    fits[k].poor = poor;
  }
  return result;
}

}  // namespace

double PairFit::rms_px() const {
  return std::sqrt((left_rms_px * left_rms_px + right_rms_px * right_rms_px) / 2);
}

bool StereoCalibration::pairs_contradict() const {
  constexpr double kTwice = 2;  // as for a pair that is poor
  const double alone_px = std::sqrt((left_rms_px * left_rms_px + right_rms_px * right_rms_px) / 2);
  return stereo_rms_px > kTwice * alone_px;
}

StereoCalibration calibrate(const std::vector<BoardPair>& pairs, const Board& board, cv::Size image_size, Lens lens,
                            bool leave_out_poor) {
  if (pairs.size() < 3) throw std::runtime_error("at least 3 pairs must show the board; better are 10 to 20");
  try {
    std::vector<PairFit> fits(pairs.size());
    StereoCalibration result = calibrate_used(pairs, board, image_size, lens, fits);
    for (size_t left = pairs.size(); left > std::max<size_t>(3, pairs.size() / 2);) {
      const double limit = poor_above(fits);
      const auto worst = std::ranges::max_element(
          fits, {}, [](const PairFit& fit) { return fit.used && !fit.poor ? fit.rms_px() : 0.0; });
      if (worst->poor || !worst->used || worst->rms_px() <= limit) break;
      worst->poor = true;
      if (!leave_out_poor) continue;
      worst->used = false;
      --left;
      result = calibrate_used(pairs, board, image_size, lens, fits);
    }
    result.fits = std::move(fits);
    const double doubt =
        std::max(result.left_fx_sigma_px / result.rig.left.fx, result.right_fx_sigma_px / result.rig.right.fx);
    // If all boards face the same way, any focal length fits well.
    constexpr double kMaxRelativeSigma = 0.02;
    if (!(doubt < kMaxRelativeSigma)) {
      throw std::runtime_error(
          fmt::format("the focal lengths would be known to {:.0f} % only{}", 100 * doubt, kAdvice));
    }
    result.rig.errors = errors_of(result, board, lens).rig;
    return result;
  } catch (const cv::Exception&) {
    throw std::runtime_error(std::string("these pairs do not determine the cameras") + kAdvice);
  }
}

std::vector<double> leave_one_out(const std::vector<BoardPair>& pairs, const Board& board, cv::Size image_size,
                                  Lens lens, const StereoCalibration& calibration,
                                  const std::function<void(double)>& progress) {
  const std::vector<cv::Point3f> points = board.corners();
  const auto count = static_cast<Eigen::Index>(points.size());
  Eigen::Matrix3Xd model(3, count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const cv::Point3f& point = points[static_cast<size_t>(k)];
    model.col(k) << point.x, point.y, point.z;
  }
  std::vector<double> distances;
  for (size_t k = 0; k < pairs.size(); ++k) {
    progress(static_cast<double>(k) / static_cast<double>(pairs.size()));
    if (!calibration.fits[k].used) continue;
    std::vector<PairFit> others = calibration.fits;
    others[k].used = false;
    Cameras cameras;
    int side = 0;
    for (const CameraModel* camera : {&calibration.rig.left, &calibration.rig.right}) {
      cameras.K[side] = (cv::Mat_<double>(3, 3) << camera->fx, 0, camera->cx, 0, camera->fy, camera->cy, 0, 0, 1);
      const int coefficients = lens == Lens::kRational ? 8 : 5;
      cameras.D[side] = cv::Mat(camera->distortion, true).rowRange(0, coefficients).t();
      ++side;
    }
    solve_both(views_of(pairs, board, others), image_size, lens, cameras);
    const StereoRig rig = rig_of(cameras, image_size);
    Eigen::Matrix3Xd seen(3, count);
    Eigen::Index found = 0;
    for (; found < count; ++found) {
      const cv::Point2f &l = pairs[k].left[static_cast<size_t>(found)], &r = pairs[k].right[static_cast<size_t>(found)];
      const auto point = vision::triangulate(rig, {rig.left.ray({l.x, l.y}), vision::ray_covariance(rig.left, 1)},
                                             {rig.right.ray({r.x, r.y}), vision::ray_covariance(rig.right, 1)});
      if (!point) break;
      seen.col(found) = point->p_W;
    }
    if (found < count) continue;
    const Eigen::Isometry3d X = rigid_fit(model, seen);
    for (Eigen::Index c = 0; c < count; ++c)
      distances.push_back((X * model.col(c) - seen.col(c)).norm() / board.square_m);
  }
  std::ranges::sort(distances);
  return distances;
}

}  // namespace multireach
