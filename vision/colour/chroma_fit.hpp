#pragma once

#include <span>
#include <vector>

#include "vision/colour/colour_model.hpp"

namespace multireach::vision {

/// A pixel used as a training sample.
struct ChromaSample {
  Rgb colour;
  Eigen::Vector2d chroma{0, 0};
  double luma = 0;
  double weight = 1;
};

double total_weight(std::span<const ChromaSample> samples);

/// Fits up to `most` normal distributions to the chroma of the samples. Each starts where the remaining samples are
/// densest and takes those within three standard deviations. The weights are shares of all samples; distributions with
/// less than a tenth are dropped. Empty for no samples.
std::vector<ChromaComponent> fit_chroma(std::vector<ChromaSample> samples, size_t most);

}  // namespace multireach::vision
