#pragma once

#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace multireach::vision {

// Data association: which of several things that look alike is which target.

/// One of the things that a target may be, among targets that look alike.
struct Hypothesis {
  int left = 0, right = 0;  ///< numbers of its blobs, the same ones for all targets
  int thing = 0;            ///< hypotheses of one target with the same number may be parts of one thing
  double evidence = 0;      ///< that it is this target: see Evidence
};

/// What one target is given.
struct Assignment {
  /// Index among the target's hypotheses; nothing: others are given all that it may be.
  std::optional<size_t> hypothesis;
  bool ambiguous = false;  ///< another association, in which it is another thing or none, is about as likely
};

/// Whether hypothesis `a.second` of target `a.first` and hypothesis `b.second` of target `b.first` cannot both be true.
using Exclusion = std::function<bool(std::pair<size_t, size_t> a, std::pair<size_t, size_t> b)>;

/// Assigns what is seen to targets that look alike, by the hypotheses of each: a blob belongs to one target only. As
/// many targets as possible are given a thing; among such associations the one with the largest sum of evidence is
/// taken. An assignment is ambiguous where this sum exceeds that of an association with another one by less than kLead.
/// `excluded`: what else cannot be true at once (default: nothing). `tentative`: targets for which it is arbitrary
/// which thing they follow (default: none); associations that differ only by which of these has which thing are equally
/// good, and not ambiguous. `lost`: number of further tentative targets, which are not seen yet and take what is left.
std::vector<Assignment> assign(std::span<const std::vector<Hypothesis>> hypotheses, const Exclusion& excluded = {},
                               std::vector<bool> tentative = {}, size_t lost = 0);

}  // namespace multireach::vision
