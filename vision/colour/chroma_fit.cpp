#include "vision/colour/chroma_fit.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>

namespace multireach::vision {
namespace {

constexpr double kMinSigma = 0.05;  // added to the fit, because one image does not show how much a colour varies
constexpr double kFirstSigma = 0.2;
constexpr double kRadius2 = 9;  // three standard deviations
constexpr double kMinShare = 0.1;
constexpr int kRounds = 12;

/// Chroma with the highest sample density, on a grid with 0.2 spacing.
Eigen::Vector2d densest(const std::vector<ChromaSample>& samples) {
  constexpr int kBins = 30;
  constexpr double kFrom = -2, kBin = 0.2;
  std::array<double, kBins * kBins> weights{};
  const auto bin = [&](double value) { return std::clamp(static_cast<int>((value - kFrom) / kBin), 0, kBins - 1); };
  for (const ChromaSample& sample : samples) {
    weights[static_cast<size_t>(bin(sample.chroma.y()) * kBins + bin(sample.chroma.x()))] += sample.weight;
  }
  const auto at = static_cast<int>(std::ranges::max_element(weights) - weights.begin());
  return {kFrom + kBin * (at % kBins + 0.5), kFrom + kBin * (at / kBins + 0.5)};
}

double distance2(const ChromaComponent& component, const Eigen::Matrix2d& information, const Eigen::Vector2d& chroma) {
  const Eigen::Vector2d from = chroma - component.mean;
  return from.dot(information * from);
}

/// Mean, covariance and total weight of the samples near the component.
ChromaComponent refined(const ChromaComponent& component, const std::vector<ChromaSample>& samples) {
  const Eigen::Matrix2d information = component.covariance.inverse();
  ChromaComponent result{Eigen::Vector2d::Zero(), Eigen::Matrix2d::Zero(), 0};
  const auto each = [&](const auto& visit) {
    for (const ChromaSample& sample : samples) {
      if (distance2(component, information, sample.chroma) <= kRadius2) visit(sample);
    }
  };
  each([&](const ChromaSample& sample) {
    result.weight += sample.weight;
    result.mean += sample.weight * sample.chroma;
  });
  if (!(result.weight > 0)) return result;
  result.mean /= result.weight;
  each([&](const ChromaSample& sample) {
    const Eigen::Vector2d from = sample.chroma - result.mean;
    result.covariance += sample.weight / result.weight * from * from.transpose();
  });
  result.covariance += kMinSigma * kMinSigma * Eigen::Matrix2d::Identity();
  result.covariance(1, 0) = result.covariance(0, 1);
  return result;
}

}  // namespace

double total_weight(std::span<const ChromaSample> samples) {
  double total = 0;
  for (const ChromaSample& sample : samples) total += sample.weight;
  return total;
}

std::vector<ChromaComponent> fit_chroma(std::vector<ChromaSample> samples, size_t most) {
  const double total = total_weight(samples);
  std::vector<ChromaComponent> components;
  while (components.size() < most && total_weight(samples) > kMinShare * total) {
    ChromaComponent component{densest(samples), kFirstSigma * kFirstSigma * Eigen::Matrix2d::Identity(), 0};
    for (int round = 0; round < kRounds; ++round) {
      const ChromaComponent next = refined(component, samples);
      if (!(next.weight > 0)) break;
      component = next;
    }
    const Eigen::Matrix2d information = component.covariance.inverse();
    const auto taken = std::erase_if(samples, [&](const ChromaSample& sample) {
      return distance2(component, information, sample.chroma) <= kRadius2;
    });
    if (taken == 0 || !(component.weight > kMinShare * total)) break;
    component.weight /= total;
    components.push_back(component);
  }
  return components;
}

}  // namespace multireach::vision
