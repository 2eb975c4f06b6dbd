#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "vision/colour/colour_background.hpp"
#include "vision/stereo/stereo_match.hpp"
#include "vision/track/target_identity.hpp"
#include "vision/track/target_track.hpp"

namespace multireach::vision {

/// What one blob shows of a thing besides its contour.
struct Appearance {
  double background = 0;   ///< share of its pixels that the remembered background explains, 0 to 1
  double compactness = 0;  ///< 1 for a disc, less for other shapes: compactness() in colour/blob.hpp
  /// Share of its pixels that are well inside the colour model, 0 to 1. Of a clipped channel, the value counts as it
  /// is: a lamp could be of any colour.
  double colour_share = 0;

  /// Whether the remembered background explains most of it.
  bool is_background() const { return background > ColourBackground::kExplained; }
};

/// Evidence that a candidate is the target, by terms: logarithms of likelihood ratios between the target and another
/// thing of its colour, up to constants that are the same for all candidates of a pair of images. They add.
struct Evidence {
  enum Term { kStill, kRound, kColour, kStereo, kSize, kHistory };
  static constexpr std::array kNames{"still", "round", "colour", "stereo", "size", "history"};
  std::array<double, kNames.size()> term{};
  /// Of a size that differs by two standard deviations: what has less is of another size.
  static constexpr double kOtherSize = -2;

  double sum() const;
};

/// A pair of contours that may show the target.
struct Candidate {
  StereoMatch match;
  Evidence evidence;
  double radius_px = 0;    ///< of the smaller image
  double expected_px = 0;  ///< radius of the target at this distance; 0 where it is not known
  bool mixed = false;      ///< excluded: its two images most likely show two things that look alike
  bool chosen = false;
  const char* reason = "";  ///< why it was chosen, or why not, as text
};

/// What is known of the target before a pair of images.
struct TargetHistory {
  std::optional<PositionEstimate> steady;       ///< predicted at the left image's time, for a steady motion
  std::optional<PositionEstimate> manoeuvring;  ///< the same for the fastest changes of motion
  double radius_m = 0;                          ///< of its last match; 0: not known
};

/// The candidates among compared pairs, best evidence first: pairs that passed all checks of `options`. `left` and
/// `right` describe the blobs that the pairs' matches refer to.
std::vector<Candidate> candidates_of(std::span<const ComparedPair> pairs, std::span<const Appearance> left,
                                     std::span<const Appearance> right, const TargetHistory& history,
                                     const MatchOptions& options);

/// Whether two candidates may be parts of one thing: their images are too near to one another for two.
[[nodiscard]] bool same_thing(const Candidate& a, const Candidate& b);

/// Chooses the first candidate, unless other things come within `lead` of it: such that are not parts of the same
/// thing. Where `sought` targets that look alike are looked for, as many things may come so near. Sets `chosen` and all
/// reasons. Returns the chosen one's index; nothing where there is none, or where several could be the target.
std::optional<size_t> choose(std::span<Candidate> candidates, size_t sought = 1, double lead = kLead);

/// Covariance of the position of the candidate with this number, m^2, from others that may be parts of the same thing,
/// as on the two sides of what occludes its middle: its centre may be that of both, of the other for which it is
/// farthest away.
[[nodiscard]] Eigen::Matrix3d covariance_of_parts(std::span<const Candidate> candidates, size_t number);

/// A pair that looks more like the target than a candidate does, by kLead in each image, but starts no track: it fits,
/// but the border cuts it off, while the candidate itself would not start one there; or it does not fit, as what moves
/// across the epipolar lines and is seen at different times: then it is of one size in both images, off the line by
/// less than its diameter, and not cut off. Null where there is none. `seen_radius_m`: of a target that was seen
/// lately, or 0; what is larger at the border is not it. `contours` and `appearance` of the left and of the right image
/// are those that the pairs' matches refer to.
[[nodiscard]] const ComparedPair* outdone_by(const Candidate& candidate, std::span<const Candidate> candidates,
                                             std::span<const ComparedPair> pairs,
                                             const std::array<std::span<const SphereContour>, 2>& contours,
                                             const std::array<std::span<const Appearance>, 2>& appearance,
                                             double seen_radius_m, const MatchOptions& options);

/// Whether two matches have no blob in common.
[[nodiscard]] bool are_apart(const StereoMatch& a, const StereoMatch& b);

/// Whether the best of these candidates is another thing than the followed one, which is among them.
[[nodiscard]] bool outdoes(const StereoMatch& best, std::span<const Candidate> candidates, const StereoMatch& followed);

/// Whether a thing of unknown size is enough like a target by its shape, colour and area to be taken for it where no
/// prediction supports it: specks that are small and ragged are not. `radius_px`: of the smaller image.
[[nodiscard]] bool is_likely(const StereoMatch& match, double radius_px, const Appearance& left,
                             const Appearance& right);

/// Whether the shape, the colour and the area of a thing speak for it by kLead more than is_likely() asks for.
/// `radius_px`: of the smaller image.
[[nodiscard]] bool is_convincing(const StereoMatch& match, double radius_px, const Appearance& left,
                                 const Appearance& right);

/// Whether a blob that the border cuts off may be taken for the target where no prediction supports it: the evidence
/// must exceed what is_convincing() asks for by kLead.
[[nodiscard]] bool may_start_at_border(const StereoMatch& match, double radius_px, const Appearance& left,
                                       const Appearance& right);

/// Evidence that a thing is the target, by what it looks like alone: by shape, colour and, without a known radius,
/// area. `radius_px`: of the smaller image.
[[nodiscard]] double evidence_by_looks(const StereoMatch& match, double radius_px, const Appearance& left,
                                       const Appearance& right, const MatchOptions& options);

/// Whether a thing is no target because none of its sampled pixels is well inside the target's colours, in one image at
/// least, and it is neither a sphere's contour nor as compact as a target (0.6).
[[nodiscard]] bool is_off_colour(const ComparedPair& pair, const Appearance& left, const Appearance& right);

/// Whether a thing of unknown size is no target where no prediction supports it: it is much smaller or more ragged than
/// the target was shortly before, and not convincing.
[[nodiscard]] bool is_unlike(const ComparedPair& pair, const Appearance& left, const Appearance& right,
                             const TargetAppearance& target);

/// Whether a thing of unknown size that is seen where the target is expected is much larger and more ragged than the
/// target was shortly before: what else has its colours, or the target with more of it. Its position is not the
/// target's.
[[nodiscard]] bool is_smear(const ComparedPair& pair, const Appearance& left, const Appearance& right,
                            const TargetAppearance& target);

/// Whether a candidate fits a known radius and the other image well enough to be taken for the target where no
/// prediction supports it: not at the edge of all gates.
[[nodiscard]] bool fits_known_radius(const Candidate& candidate);

}  // namespace multireach::vision
