#include "vision/contour/contour_acceptance.hpp"

#include <algorithm>
#include <numbers>

#include "numeric/trigonometry.hpp"

namespace multireach::vision {
namespace {

constexpr double kWorstShape = 0.03;  // largest residual of an edge fit, relative to the radius
// A contour with both ends missing: residual, pixels; where so much is painted; share of the area that seems occluded.
constexpr double kRagged = 0.275, kRaggedPaint = 0.375, kSomePaint = 0.05, kBothEndsOccluded = 0.25;
constexpr double kAccountedFor = 0.4;  // of the area that missing edges make expect to be occluded
// A blob that is this many times as long as a contour shows more than the contour does: for certain (a disc of which
// three tenths are occluded measures 1.11), and where a motion blurs its edges.
constexpr double kLonger = 1.2, kSlightlyLonger = 1.08;
constexpr double kLeastCutOff = 0.5;  // share of the contour of an object of unknown shape that the border cuts off
constexpr double kBothEndsMissing = 0.65;  // share of the contour of a moved ball that its sides, and more, must show

/// Whether edges are missing although nothing is occluded and the surface there is not painted. A straight border that
/// hides the share h of a circle hides h - sin(2 pi h) / 2 pi of its area.
bool misses_edges(const FittedContour& fitted) {
  const double missing = std::max(0.0, 1 - fitted.seen_inside - fitted.painted_missing);
  double sine, cosine;
  sine_and_cosine_of(2 * std::numbers::pi * missing, sine, cosine);
  const double expected = missing - sine / (2 * std::numbers::pi);
  return missing > 1 - kSeenOfAnything && !fitted.cut_off && fitted.occlusion < kAccountedFor * expected;
}

/// Where the object moved further than an edge's window, both ends have no edges, and the rest fits anywhere between.
bool is_contradicted(const FittedContour& fitted, double least_seen) {
  const bool whole = fitted.visible_fraction >= kSeenOfAnything;
  // An occluder leaves the other edges sharp. Where they are not, both ends of a fast ball are missing.
  const bool ragged = least_seen == kSeenOfASphere && !whole && fitted.radius_px > kLargeEnough &&
                      fitted.residual_px > (fitted.painted_missing < kSomePaint ? kRagged : kRaggedPaint);
  if (fitted.motion_blur2 > kMovedBlur2)
    return fitted.blob_length > kSlightlyLonger || fitted.visible_fraction < kBothEndsMissing ||
           (ragged && fitted.occlusion > kBothEndsOccluded);
  return misses_edges(fitted) || ragged || (fitted.blob_length > kLonger && !whole);
}

}  // namespace

ContourVerdict verdict_on(const FittedContour& fitted, double least_seen, double small_residual_px) {
  if (is_contradicted(fitted, least_seen)) return ContourVerdict::kContradicted;
  const double most_residual = std::max(small_residual_px, kWorstShape * fitted.radius_px);
  if (!(fitted.residual_px < most_residual) || fitted.visible_fraction < kSeenOfASphere)
    return ContourVerdict::kNothing;
  const bool enough = fitted.visible_fraction >= std::min(least_seen, kLeastCutOff) && fitted.seen_inside >= least_seen;
  return enough ? ContourVerdict::kAccepted : ContourVerdict::kPart;
}

}  // namespace multireach::vision
