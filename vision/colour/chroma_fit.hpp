#pragma once

#include <vector>

#include "vision/colour/colour_model.hpp"

namespace multireach::vision {

/// A pixel to learn from.
struct ChromaSample {
  Rgb colour;
  Eigen::Vector2d chroma{0, 0};
  double luma = 0;
  double weight = 1;
};

/// Up to `most` normal distributions for the chroma of some pixels, the heaviest first: each begins where the remaining
/// pixels are densest and takes those within three standard deviations. The weights are shares of all pixels. Those
/// that would have less than a tenth are left out. Nothing for no pixels.
std::vector<ChromaComponent> fit_chroma(std::vector<ChromaSample> samples, size_t most);

}  // namespace multireach::vision
