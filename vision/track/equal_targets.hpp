#pragma once

#include <optional>
#include <span>
#include <vector>

namespace multireach::vision {

/// One of the things that a target may be, among targets that look alike.
struct Claim {
  int left = 0, right = 0;  ///< numbers of its blobs, the same ones for all targets
  int thing = 0;            ///< claims of one target with the same number may be parts of one thing
  double evidence = 0;      ///< that it is this target: see Evidence
};

/// What one target is given when the things that are seen are divided.
struct Share {
  std::optional<size_t> claim;  ///< index among the target's claims; nothing: others are given all that it may be
  bool ambiguous = false;       ///< another division, in which it is another thing or none, is about as likely
};

/// Divides what is seen among targets that look alike, by the claims of each: a blob belongs to one target only. As
/// many targets as possible are given a thing; among such divisions the one with the largest sum of evidence is taken.
/// A share is ambiguous where this sum exceeds that of a division with another share by less than kLead.
std::vector<Share> divide(std::span<const std::vector<Claim>> claims);

}  // namespace multireach::vision
