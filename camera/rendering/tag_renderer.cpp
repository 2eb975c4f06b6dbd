#include "camera/rendering/tag_renderer.hpp"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace multireach {
namespace {

constexpr int kRays = 64;                   // in a pixel
constexpr int kBlackCells = 8;              // along a side of the black square
constexpr float kWhite = 225, kBlack = 22;  // grey levels of paper and toner in full light
constexpr int kInstants = 24;               // of an exposure

cv::Mat1b cells_of(int id) {
  apriltag_family_t* family = tag36h11_create();
  const bool known = id >= 0 && id < static_cast<int>(family->ncodes);
  cv::Mat1b cells(family->total_width, family->total_width, uint8_t{1});
  if (known) {
    const int margin = (family->total_width - family->width_at_border) / 2;
    cells(cv::Rect(margin, margin, family->width_at_border, family->width_at_border)) = 0;
    // The first cell's bit is the highest.
    uint64_t code = family->codes[id] << (64 - family->nbits);
    for (uint32_t cell = 0; cell < family->nbits; ++cell, code <<= 1) {
      if (code >> 63)
        cells(static_cast<int>(family->bit_y[cell]) + margin, static_cast<int>(family->bit_x[cell]) + margin) = 1;
    }
  }
  tag36h11_destroy(family);
  if (!known) throw std::invalid_argument("a tag's id must be from 0 to 586");
  return cells;
}

/// The k-th of kRays points of a pixel: Hammersley's point set, k/64 and k with its six bits reversed.
std::pair<double, double> ray_position(int k) {
  int reversed = 0;
  for (int bit = 0; bit < 6; ++bit) reversed |= (k >> bit & 1) << (5 - bit);
  return {(k + 0.5) / kRays, (reversed + 0.5) / kRays};
}

}  // namespace

TagRenderer::TagRenderer(const SceneOptions& scene, const TagLook& tag, const CameraModel& camera,
                         const Eigen::Isometry3d& X_WC, const Eigen::Isometry3d& X_WL)
    : TagRenderer(scene, Card{cells_of(tag.id), tag.size_m / kBlackCells}, camera, X_WC, X_WL) {}

TagRenderer::TagRenderer(const SceneOptions& scene, const Card& card, const CameraModel& camera,
                         const Eigen::Isometry3d& X_WC, const Eigen::Isometry3d& X_WL)
    : camera_(camera),
      X_CW_(X_WC.inverse()),
      light_W_(Eigen::Vector3d(0.3, 0.4, 1.0).normalized()),
      background_(scene, camera, X_WC, X_WL),
      card_(card) {}

/// The cell that a ray of the camera hits, which may lie beside the tag.
cv::Point TagRenderer::cell_at(const Eigen::Isometry3d& X_TC, const Eigen::Vector3d& ray) const {
  const Eigen::Vector3d origin = X_TC.translation(), way = X_TC.linear() * ray;
  const Eigen::Vector3d p = origin - way * (origin.z() / way.z());
  const auto index = [&](double at, int cells) {
    return static_cast<int>(std::floor(std::clamp(at / card_.cell_m + 0.5 * cells, -1.0, cells + 0.5)));
  };
  return {index(p.x(), card_.cells.cols), index(p.y(), card_.cells.rows)};
}

void TagRenderer::draw(const Eigen::Isometry3d& X_CT, cv::Mat& image) const {
  const Eigen::Isometry3d X_TC = X_CT.inverse();
  // The camera must be before the paper: on the side of negative z.
  if (X_TC.translation().z() >= 0) return;
  const double half_width = 0.5 * card_.cells.cols * card_.cell_m, half_height = 0.5 * card_.cells.rows * card_.cell_m;
  Eigen::Array2d low(1e9, 1e9), high(-1e9, -1e9);
  for (int corner = 0; corner < 4; ++corner) {
    const Eigen::Vector3d p =
        X_CT * Eigen::Vector3d(corner % 2 ? half_width : -half_width, corner / 2 ? half_height : -half_height, 0);
    if (p.z() < 1e-3) return;
    const Eigen::Vector2d pixel = camera_.project(p);
    low = low.min(pixel.array());
    high = high.max(pixel.array());
  }
  const auto bound = [](double value, int limit) { return std::clamp(static_cast<int>(std::floor(value)), 0, limit); };
  const cv::Rect inside(0, 0, card_.cells.cols, card_.cells.rows);
  const Eigen::Vector3d front_W = -(X_CW_.linear().transpose() * X_CT.linear().col(2));
  const auto light = static_cast<float>(0.5 + 0.5 * std::max(0.0, front_W.dot(light_W_)));
  for (int row = bound(low.y() - 3, camera_.height); row < bound(high.y() + 4, camera_.height); ++row) {
    for (int column = bound(low.x() - 3, camera_.width); column < bound(high.x() + 4, camera_.width); ++column) {
      const cv::Vec3f behind = image.at<cv::Vec3f>(row, column);
      const auto colour = [&](const cv::Point& cell) -> cv::Vec3f {
        if (!inside.contains(cell)) return behind;
        const float grey = light * (card_.cells(cell) ? kWhite : kBlack);
        return {grey, grey, grey};
      };
      // A cell that holds all corners of the pixel holds the whole pixel, except for the lens's curvature.
      const cv::Point corner = cell_at(X_TC, background_.ray_in_pixel(column, row, 0, 0));
      const bool whole = corner == cell_at(X_TC, background_.ray_in_pixel(column, row, 1, 0)) &&
                         corner == cell_at(X_TC, background_.ray_in_pixel(column, row, 0, 1)) &&
                         corner == cell_at(X_TC, background_.ray_in_pixel(column, row, 1, 1));
      if (whole && inside.contains(corner)) {
        image.at<cv::Vec3f>(row, column) = colour(corner);
        continue;
      }
      cv::Vec3f sum(0, 0, 0);
      for (int k = 0; k < kRays; ++k) {
        const auto [right, down] = ray_position(k);
        sum += colour(cell_at(X_TC, background_.ray_in_pixel(column, row, right, down)));
      }
      image.at<cv::Vec3f>(row, column) = sum / kRays;
    }
  }
}

Card chessboard_card(int columns, int rows, double square_m) {
  Card card{cv::Mat1b(rows + 3, columns + 3, uint8_t{1}), square_m};
  for (int row = 1; row < rows + 2; ++row) {
    for (int column = 1; column < columns + 2; ++column)
      card.cells(row, column) = static_cast<uint8_t>((row + column) % 2);
  }
  return card;
}

cv::Mat TagRenderer::exposed(const std::optional<Eigen::Isometry3d>& X_WT) const {
  cv::Mat image = background_.wall().clone();
  if (X_WT) draw(X_CW_ * *X_WT, image);
  return image;
}

cv::Mat TagRenderer::render(const std::optional<Eigen::Isometry3d>& X_WT, uint64_t stream,
                            const Eigen::Vector3d& motion_W) const {
  if (!X_WT) return background_.developed(background_.wall(), stream);
  const int instants = motion_W.isZero(0) ? 1 : kInstants;
  cv::Mat sum = cv::Mat::zeros(background_.wall().size(), CV_32FC3);
  for (int k = 0; k < instants; ++k) {
    cv::Mat image = background_.wall().clone();
    Eigen::Isometry3d X_WT_then = *X_WT;
    X_WT_then.translation() += ((k + 0.5) / instants - 0.5) * motion_W;
    draw(X_CW_ * X_WT_then, image);
    sum += image / instants;
  }
  return background_.developed(sum, stream);
}

}  // namespace multireach
