#include "vision/camera_check/camera_motion.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "numeric/natural_log.hpp"
#include "vision/stereo/stereo_match.hpp"

namespace multireach::vision {
namespace {

// Smallest shift that counts, as a share of a cell: two pixels of 640. Between looks at still cameras, the largest of
// 77 on the videos of thrown and juggled balls, which docs/real-images.md names for tuning, was 0.22 pixels.
constexpr double kLeast = 1.0 / 16;
constexpr double kLarge = 1.0 / 8;  // likewise: a quarter of a cell of ColourBackground
constexpr int kLeastCell = 16;      // pixels
constexpr int kTimeConstant = 16;   // looks, time constant of what was seen before
constexpr int kLeastCells = 50;     // that a fit needs, ten for each number
constexpr double kNoise = 1;        // grey levels, least standard deviation of a cell's difference
constexpr int kUnchanged = 2;       // grey levels, between which a cell counts as unchanged
constexpr int kFewChanged = 20;     // a motion of the camera changes one of so many cells
constexpr int kRounds = 10;
constexpr double kFreedom = 3;  // degrees of freedom of the Student distribution of the differences
// Log likelihood by which a motion must explain the differences better than a change of exposure alone: strong
// evidence, and one for each number that the motion has more (Akaike).
constexpr double kEvidence = kLead + 3;

// A large object that moves explains many differences too, but where it is not, the image then stands still: no ninth
// of the image may speak against a motion of the camera by more than this log likelihood. Set on opencv-doc's
// vtest.avi, with an object of a fifth of its width that passes, and windows of it that move.
constexpr double kAgainst = 4;
constexpr int kParts = 3;  // in each direction

constexpr int kMotion = 3, kNumbers = 5;  // shift to the right and down, turn; contrast, brightness
using Row = Eigen::Matrix<double, kNumbers, 1>;

struct Differences {
  std::vector<Row> derivative;
  std::vector<double> value;  // grey levels
};

struct Fit {
  Row numbers = Row::Zero();
  std::vector<double> residual;
  double sigma = 0;
};

/// Fits the last `kCount` numbers robustly, by weights for a Student distribution.
template <int kCount>
Fit fitted(const Differences& differences) {
  const size_t size = differences.value.size();
  Fit fit;
  fit.residual = differences.value;
  std::vector<double> weight(size, 1), sorted;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix<double, kCount, kCount> information = 1e-9 * Eigen::Matrix<double, kCount, kCount>::Identity();
    Eigen::Matrix<double, kCount, 1> right = Eigen::Matrix<double, kCount, 1>::Zero();
    for (size_t k = 0; k < size; ++k) {
      const Eigen::Matrix<double, kCount, 1> derivative = differences.derivative[k].template tail<kCount>();
      information += weight[k] * derivative * derivative.transpose();
      right += weight[k] * derivative * differences.value[k];
    }
    const Eigen::Matrix<double, kCount, 1> numbers = information.ldlt().solve(right);
    fit.numbers.template tail<kCount>() = numbers;
    sorted.clear();
    for (size_t k = 0; k < size; ++k) {
      fit.residual[k] = differences.value[k] - differences.derivative[k].template tail<kCount>().dot(numbers);
      sorted.push_back(std::abs(fit.residual[k]));
    }
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(size / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    fit.sigma = std::max(kNoise, 1.4826 * *middle);  // of a normal distribution with this median
    for (size_t k = 0; k < size; ++k) {
      const double off = fit.residual[k] / fit.sigma;
      weight[k] = (kFreedom + 1) / (kFreedom + off * off);
    }
  }
  return fit;
}

double log_likelihood(double residual, double sigma) {
  return -0.5 * (kFreedom + 1) * natural_log(1 + residual * residual / (kFreedom * sigma * sigma));
}

}  // namespace

CameraMotion::CameraMotion(const cv::Size& area)
    : cell_px_(std::max(kLeastCell, (area.width + kColumns - 1) / kColumns)),
      columns_(area.width / cell_px_),
      rows_(area.height / cell_px_),
      before_(static_cast<size_t>(columns_ * rows_), 0),
      now_(before_) {}

void CameraMotion::forget() {
  std::ranges::fill(before_, uint8_t{0});
}

/// Mean of green, which is most of the luma, over some 64 pixels of a part of an image.
double CameraMotion::mean_of(const cv::Mat& bgr, const cv::Rect& part) const {
  const int step = std::max(2, cell_px_ / 8);
  int64_t sum = 0, count = 0;
  for (int y = part.y; y < part.br().y; y += step) {
    const auto* pixels = bgr.ptr<cv::Vec3b>(y);
    for (int x = part.x; x < part.br().x; x += step, ++count) sum += pixels[x][1];
  }
  return static_cast<double>(sum) / static_cast<double>(count);
}

/// Gradient of a cell's mean, grey levels per pixel to the right and down. With a shift it changes by what enters and
/// leaves at the cell's borders: so it is that between strips along them.
Eigen::Vector2d CameraMotion::gradient_of(const cv::Mat& bgr, int row, int column) const {
  const int half = cell_px_ / 8, x = column * cell_px_, y = row * cell_px_;
  const double left = mean_of(bgr, {x - half, y, 2 * half, cell_px_});
  const double right = mean_of(bgr, {x + cell_px_ - half, y, 2 * half, cell_px_});
  const double above = mean_of(bgr, {x, y - half, cell_px_, 2 * half});
  const double below = mean_of(bgr, {x, y + cell_px_ - half, cell_px_, 2 * half});
  return Eigen::Vector2d(right - left, below - above) / cell_px_;
}

CameraMotion::Motion CameraMotion::motion(const cv::Mat& bgr) {
  // Most pairs of a camera that stands still need no fit.
  size_t changed = 0;
  for (size_t k = 0; k < before_.size(); ++k) changed += std::abs(now_[k] - before_[k]) > kUnchanged;
  if (changed * kFewChanged < before_.size()) return Motion::kNone;
  Differences differences;
  double mean = 0;
  for (const uint8_t level : before_) mean += level;
  mean /= static_cast<double>(before_.size());
  for (int row = 1; row + 1 < rows_; ++row) {
    for (int column = 1; column + 1 < columns_; ++column) {
      const auto k = static_cast<size_t>(row * columns_ + column);
      const Eigen::Vector2d gradient = gradient_of(bgr, row, column);
      const double to_right = gradient.x(), down = gradient.y();
      // From the middle of the image, in halves of its width.
      const double x = (2 * column + 1.0 - columns_) / columns_, y = (2 * row + 1.0 - rows_) / columns_;
      Row derivative;
      derivative << -to_right, -down, -(down * x - to_right * y), before_[k] - mean, 1;
      differences.derivative.push_back(derivative);
      differences.value.push_back(now_[k] - before_[k]);
    }
  }
  const Fit still = fitted<kNumbers - kMotion>(differences), moving = fitted<kNumbers>(differences);
  moved_px_ = moving.numbers.head<kMotion>();
  if (!(size_px(moved_px_) > kLeast * cell_px_)) return Motion::kNone;
  // By the larger of both standard deviations: the smaller one is of the fit with more numbers.
  double evidence = 0;
  std::array<double, kParts * kParts> of_part{};
  for (size_t k = 0; k < differences.value.size(); ++k) {
    const double better =
        log_likelihood(moving.residual[k], still.sigma) - log_likelihood(still.residual[k], still.sigma);
    const int row = static_cast<int>(k) / (columns_ - 2), column = static_cast<int>(k) % (columns_ - 2);
    evidence += better;
    of_part[static_cast<size_t>(row * kParts / (rows_ - 2) * kParts + column * kParts / (columns_ - 2))] += better;
  }
  if (evidence < kEvidence || std::ranges::min(of_part) < -kAgainst) return Motion::kNone;
  return size_px(moved_px_) > kLarge * cell_px_ ? Motion::kLarge : Motion::kSmall;
}

double CameraMotion::size_px(const Eigen::Vector3d& moved_px) {
  return std::sqrt(moved_px.head<2>().squaredNorm() + moved_px.z() * moved_px.z() / 2);
}

CameraMotion::Motion CameraMotion::look(const cv::Mat& bgr) {
  moved_px_.setZero();
  if (rows_ < 3 || columns_ < 3 || (rows_ - 2) * (columns_ - 2) < kLeastCells) return Motion::kNone;
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) {
      const cv::Rect cell(column * cell_px_, row * cell_px_, cell_px_, cell_px_);
      now_[static_cast<size_t>(row * columns_ + column)] = static_cast<uint8_t>(mean_of(bgr, cell) + 0.5);
    }
  }
  const bool first = std::ranges::all_of(before_, [](uint8_t level) { return level == 0; });
  const Motion found = first ? Motion::kNone : motion(bgr);
  const bool moved = found != Motion::kNone;
  if (!moved) moved_px_.setZero();
  for (size_t k = 0; k < before_.size(); ++k) {
    const int apart = now_[k] - before_[k];
    const int step = first || moved ? std::abs(apart) : std::min(std::abs(apart), std::abs(apart) / kTimeConstant + 1);
    before_[k] = static_cast<uint8_t>(before_[k] + (apart > 0 ? step : -step));
  }
  return found;
}

}  // namespace multireach::vision
