// Generated pictures of shaded balls, to learn colours from.
#pragma once

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "imaging/rgb.hpp"
#include "numeric/random.hpp"

namespace multireach {

inline constexpr int kWidth = 320, kHeight = 240;

struct Ball {
  cv::Point centre;
  double radius = 20;
  Rgb colour;
  double seam = 0;  ///< width of its dark seams, radii: one across, and one on each side from top to bottom
};

/// A part of the picture with one colour and a fine texture, pixel by pixel of its brightness.
struct Patch {
  cv::Rect box;
  Rgb colour;
};

/// Shaded balls, each with a highlight and a dark side, before patches on a grey wall; blurred as by a lens, with
/// noise.
inline cv::Mat picture(const std::vector<Ball>& balls, const std::vector<Patch>& patches, uint64_t seed) {
  cv::Mat image(kHeight, kWidth, CV_32FC3, cv::Scalar(150, 152, 150));
  const CounterRandom random(seed);
  uint64_t counter = 0;
  for (const Patch& patch : patches) {
    for (int row = patch.box.y; row < patch.box.br().y; ++row) {
      for (int column = patch.box.x; column < patch.box.br().x; ++column) {
        const auto bright = static_cast<float>(random.uniform(counter++, 0.85, 1.15));
        image.at<cv::Vec3f>(row, column) =
            bright * cv::Vec3f(static_cast<float>(patch.colour.b), static_cast<float>(patch.colour.g),
                               static_cast<float>(patch.colour.r));
      }
    }
  }
  for (const Ball& ball : balls) {
    for (int row = 0; row < kHeight; ++row) {
      for (int column = 0; column < kWidth; ++column) {
        const double x = (column - ball.centre.x) / ball.radius, y = (row - ball.centre.y) / ball.radius;
        if (x * x + y * y > 1) continue;
        const double z = std::sqrt(1 - x * x - y * y), lit = -0.4 * x - 0.6 * y + 0.69 * z;
        const double to_side = std::abs(std::abs(x) - 0.45 * std::sqrt(1 - y * y));
        if (std::min(to_side, std::abs(y)) < ball.seam / 2) {
          image.at<cv::Vec3f>(row, column) = cv::Vec3f(24, 22, 25);
          continue;
        }
        const double shade = 0.35 + 0.75 * std::max(0.0, lit), shine = 120 * std::pow(std::max(0.0, lit), 40);
        const auto channel = [&](double value) { return static_cast<float>(std::min(255.0, value * shade + shine)); };
        image.at<cv::Vec3f>(row, column) = {channel(ball.colour.b), channel(ball.colour.g), channel(ball.colour.r)};
      }
    }
  }
  cv::GaussianBlur(image, image, {0, 0}, 1);
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      for (int k = 0; k < 3; ++k)
        image.at<cv::Vec3f>(row, column)[k] += static_cast<float>(random.uniform(counter++, -4, 4));
    }
  }
  cv::Mat bytes;
  image.convertTo(bytes, CV_8UC3);
  std::vector<uint8_t> jpeg;
  cv::imencode(".jpg", bytes, jpeg, {cv::IMWRITE_JPEG_QUALITY, 85});
  return cv::imdecode(jpeg, cv::IMREAD_COLOR);
}

inline const Rgb kRed{190, 60, 85}, kOrange{220, 120, 30}, kYellow{185, 195, 105}, kWood{172, 135, 82},
    kSkin{190, 120, 110};

}  // namespace multireach
