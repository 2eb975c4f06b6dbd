#pragma once

#include <multireach/image_t.hpp>
#include <opencv2/imgproc.hpp>

#include "camera/rendering/ball_renderer.hpp"

// Rendered images with several balls, and images as messages hold them.
namespace multireach::testing {

/// Draws one more ball into an image that `camera` rendered with this `stream`; it hides what is behind it.
inline void add_ball(const BallRenderer& camera, const Eigen::Vector3d& ball, uint64_t stream, cv::Mat& image) {
  const cv::Mat with = camera.render(ball, stream), without = camera.render(std::nullopt, stream);
  cv::Mat differs;
  cv::absdiff(with, without, differs);
  cv::cvtColor(differs, differs, cv::COLOR_BGR2GRAY);
  with.copyTo(image, differs > 0);  // the noise is the same
}

/// An 8-bit BGR image, captured at `utime`, as images_t holds it: not compressed.
inline image_t image_message(const cv::Mat& bgr, int64_t utime) {
  image_t image{};
  image.utime = utime;
  image.width = bgr.cols;
  image.height = bgr.rows;
  image.pixelformat = image_t::PIXEL_FORMAT_BGR;
  image.data.assign(bgr.data, bgr.data + bgr.total() * bgr.elemSize());
  image.size = static_cast<int32_t>(image.data.size());
  return image;
}

}  // namespace multireach::testing
