#include "tools/calibrate/reprojection_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace multireach {
namespace {

constexpr double kPanelWidth = 800;
constexpr int kGap = 20, kCaption = 40, kShift = 4;  // kShift: fractional bits, drawing in 1/16 pixel
const cv::Scalar kPaper(255, 255, 255), kInk(60, 60, 60), kGood(160, 90, 20), kPoor(40, 40, 220);

cv::Point fixed_point(const cv::Point2d& point) {
  return {cvRound(point.x * (1 << kShift)), cvRound(point.y * (1 << kShift))};
}

/// The largest factor of the series 1, 2, 5, 10, ... that draws a residual of `rms_px` at most 15 pixels long.
double enlargement(double rms_px) {
  double factor = 1;
  for (const double next : {2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0}) {
    if (next * rms_px <= 15) factor = next;
  }
  return factor;
}

}  // namespace

cv::Mat reprojection_picture(const std::vector<BoardPair>& pairs, const StereoCalibration& calibration,
                             cv::Size image_size) {
  const double scale = kPanelWidth / image_size.width;
  const cv::Size panel(cvRound(kPanelWidth), cvRound(image_size.height * scale));
  cv::Mat picture(panel.height + kCaption + kGap, 2 * panel.width + 3 * kGap, CV_8UC3, kPaper);
  const double enlarged = enlargement(calibration.stereo_rms_px);
  for (const int side : {0, 1}) {
    const cv::Point corner(kGap + side * (panel.width + kGap), kCaption);
    cv::rectangle(picture, cv::Rect(corner, panel), kInk);
    cv::putText(picture,
                fmt::format("{}: {:.3f} px rms alone, {:.3f} px both; residuals x {:.0f}", side == 0 ? "left" : "right",
                            side == 0 ? calibration.left_rms_px : calibration.right_rms_px, calibration.stereo_rms_px,
                            enlarged),
                corner + cv::Point(0, -12), cv::FONT_HERSHEY_SIMPLEX, 0.6, kInk, 1, cv::LINE_AA);
    cv::Mat inside = picture(cv::Rect(corner, panel));
    for (size_t k = 0; k < pairs.size(); ++k) {
      const PairFit& fit = calibration.fits[k];
      const Corners& corners = side == 0 ? pairs[k].left : pairs[k].right;
      const Corners& residuals = side == 0 ? fit.left_residuals : fit.right_residuals;
      for (size_t c = 0; c < corners.size(); ++c) {
        const cv::Point2d from = (cv::Point2d(corners[c]) + cv::Point2d(0.5, 0.5)) * scale;
        const cv::Scalar& colour = fit.poor ? kPoor : kGood;
        cv::circle(inside, fixed_point(from), 24, colour, cv::FILLED, cv::LINE_AA, kShift);
        cv::line(inside, fixed_point(from), fixed_point(from + cv::Point2d(residuals[c]) * enlarged), colour, 1,
                 cv::LINE_AA, kShift);
      }
    }
  }
  return picture;
}

}  // namespace multireach
