#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "vision/colour/blob.hpp"
#include "vision/colour/chroma_gauge.hpp"
#include "vision/colour/pixel_class.hpp"

namespace multireach::vision {

/// What the pixels well inside a blob say about the light: their sum, and the sum that the model expects of them in the
/// light in which it was learned, the same brightness given.
struct LightSample {
  int64_t pixels = 0;
  Rgb seen, expected;
};

/// The shift after a frame in which the object was seen. It moves a part of the way to what the sample says, the
/// farther the better the `quality` (0 to 1: how sure the caller is that the blob is the object and nothing else), a
/// few per cent at most, and stays within the bounds of ColourShift. With few pixels it stays as it is.
ColourShift adapted(const ColourShift& shift, const LightSample& sample, double quality);
/// The shift after a frame in which the object was not seen: slowly back to none, since a wrong one may be why.
ColourShift relaxed(const ColourShift& shift);

/// A colour model that is used under changing light. What it answers depends on the model and the shift alone; it keeps
/// what it computed for the last shift, and the shift is rounded, so that small changes cost nothing.
class LitModel {
 public:
  /// Throws std::invalid_argument for a model that check() refuses.
  explicit LitModel(const ColourModel& model);

  const ColourModel& model() const { return model_; }
  /// The model's members under a shift. Stays until the next call.
  const PixelClass& members(const ColourShift& shift);
  /// Looks at the pixels of a blob that was found in an 8-bit BGR image under that shift.
  LightSample sample(const ColourShift& shift, const cv::Mat& bgr, const Blob& blob);

 private:
  void prepare(const ColourShift& shift);

  ColourModel model_;
  ColourShift shift_;
  ChromaTest test_;
  PixelClass members_;
};

}  // namespace multireach::vision
