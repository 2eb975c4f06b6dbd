#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "vision/colour/blob.hpp"
#include "vision/colour/chroma_classifier.hpp"
#include "vision/colour/colour_table.hpp"

namespace multireach::vision {

/// Colour of the pixels well inside a blob: their sum, and the sum that the model predicts for them in the light in
/// which it was learned, at the same brightness.
struct IlluminationSample {
  int64_t pixels = 0;
  Rgb seen, expected;
  double deviation = 0;  ///< of the mean colour from the model in the current light, standard deviations
  /// Relative standard deviations of R/G and B/G among the learned colours, as if white balance differed.
  WhiteBalanceGains spread{.red = 0, .blue = 0};
};

/// The gains after a frame in which the object was seen. They move towards the sample's by a step that grows with
/// `quality` (0 to 1: confidence that the blob is the object and nothing else), a few per cent at most, within the
/// bounds of WhiteBalanceGains. They move ten times as slowly by what is within the spread of the learned colours: an
/// object that was learned in several lights goes from one into another. With few pixels they do not change, nor by an
/// object whose mean colour is in the tails of the model: light changes slowly, so that is another object.
WhiteBalanceGains adapted(const WhiteBalanceGains& gains, const IlluminationSample& sample, double quality);
/// The gains after a frame in which the object was not seen: they return slowly to 1, because wrong gains may be the
/// cause.
WhiteBalanceGains relaxed(const WhiteBalanceGains& gains);

/// Whether the gains are so near 1 that the adapted colours are those that were learned.
bool are_as_learned(const WhiteBalanceGains& gains);
/// The gains after a frame in which wrong gains hid a part of the object: they return to 1 as fast as they adapt.
WhiteBalanceGains returning(const WhiteBalanceGains& gains, double quality);

/// A colour model adapted to the current white-balance gains. Results depend on the model and the gains only. Caches
/// the lookup table of the last gains; gains are rounded, so that small changes do not recompute it.
class AdaptedColourModel {
 public:
  /// Throws std::invalid_argument for a model that check() rejects.
  explicit AdaptedColourModel(const ColourModel& model);

  const ColourModel& model() const { return model_; }
  /// The lookup table for these gains. Valid until the next call.
  const ColourTable& members(const WhiteBalanceGains& gains);
  /// Share of the pixels of a blob, found in an 8-bit BGR image with these gains, that belong to the model even with
  /// half its tolerance. Looks at 64 pixels at most, evenly spread.
  double share_well_inside(const WhiteBalanceGains& gains, const cv::Mat& bgr, const Blob& blob);
  /// Samples the pixels of a blob that was found in an 8-bit BGR image with these gains.
  IlluminationSample sample(const WhiteBalanceGains& gains, const cv::Mat& bgr, const Blob& blob);

 private:
  void prepare(const WhiteBalanceGains& gains);

  ColourModel model_;
  WhiteBalanceGains gains_;
  ChromaClassifier test_, inner_;
  ColourTable members_;
  WhiteBalanceGains spread_;
};

}  // namespace multireach::vision
