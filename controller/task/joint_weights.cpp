#include "controller/task/joint_weights.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace multireach::controller {
namespace {

constexpr double kSlow = 8;       // a joint is slow below the median speed divided by this
constexpr double kHeaviest = 30;  // heavier joints would make the systems of equations ill-conditioned

}  // namespace

JointVector default_joint_weights(const Chain& chain) {
  JointVector weights = JointVector::Ones(chain.size());
  std::vector<double> speeds;
  for (const double speed : chain.velocity()) {
    if (std::isfinite(speed) && speed > 0) speeds.push_back(speed);
  }
  if (speeds.empty()) return weights;
  const auto middle = speeds.begin() + static_cast<std::ptrdiff_t>(speeds.size() / 2);
  std::ranges::nth_element(speeds, middle);
  const double median = *middle;
  for (int i = 0; i < chain.size(); ++i) {
    const double speed = chain.velocity()[i];
    if (speed > 0 && kSlow * speed < median) weights[i] = std::min(median / speed, kHeaviest);
  }
  return weights;
}

JointVector joint_weights_of(const Chain& chain, const JointVector& weights) {
  if (weights.size() == 0) return default_joint_weights(chain);
  if (weights.size() != chain.size()) throw std::invalid_argument("joint_weights needs one value per joint, or none");
  for (const double weight : weights) {
    if (!(weight > 0)) throw std::invalid_argument("a joint's weight must be positive");
  }
  const double least = weights.minCoeff();
  if (!std::isfinite(least)) throw std::invalid_argument("every joint is locked; at least one must be free to move");
  return weights / least;
}

JointVector joint_mobility(const JointVector& weights) {
  JointVector mobility(weights.size());
  for (Eigen::Index i = 0; i < weights.size(); ++i) mobility[i] = 1 / (weights[i] * weights[i]);
  return mobility;
}

}  // namespace multireach::controller
