#pragma once

namespace multireach::vision {

/// Smallest visible share of the contour of an object that is known to be a sphere, and of one of unknown shape.
inline constexpr double kSeenOfASphere = 0.35, kSeenOfAnything = 0.75;

/// Variance of a motion's blur across a contour, px^2, from which on the motion must be allowed for: some 4 px.
inline constexpr double kMovedBlur2 = 1;

/// Radius, pixels, below which a contour has too few pixels inside to judge by.
inline constexpr double kLargeEnough = 12;

/// What a fit of a sphere's contour to edges shows, from which it is decided whether the object has this contour.
struct FittedContour {
  double radius_px = 0;         ///< of the contour
  double residual_px = 0;       ///< of the edges
  double visible_fraction = 0;  ///< of the contour's whole length with a fitting edge
  double seen_inside = 0;       ///< the same, of its length inside the readable pixels
  double painted_missing = 0;   ///< share of its length without an edge, where the surface is painted
  double occlusion = 0;         ///< share of the area that the blob does not show
  bool cut_off = false;         ///< a part is outside of the readable pixels
  double blob_length = 0;       ///< of the blob, as a multiple of the contour's; 0: not known
  double motion_blur2 = 0;      ///< variance of the motion's blur, px^2
};

/// From bad to good.
enum class ContourVerdict {
  kContradicted,  ///< no sphere contour: it does not explain the blob; what is occluded is not known
  kNothing,       ///< too ragged, or too little of it
  kPart,          ///< an arc of a sphere contour: less of it than is accepted
  kAccepted,      ///< a sphere contour
};

/// `least_seen`: kSeenOfASphere or kSeenOfAnything. `small_residual_px`: no contour with less is refused as ragged.
[[nodiscard]] ContourVerdict verdict_on(const FittedContour& fitted, double least_seen, double small_residual_px);

}  // namespace multireach::vision
