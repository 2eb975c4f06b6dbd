#pragma once

#include <array>
#include <vector>

#include "vision/association/assignment.hpp"
#include "vision/stereo_vision.hpp"

namespace multireach::vision {

/// Numbers the blobs of one image that several targets have found, equal ones alike.
class BlobNumbers {
 public:
  int of(const Blob& blob);

 private:
  std::vector<const Blob*> blobs_;
};

/// What the other targets of `group`, which look like the one with the number `target`, have of the blobs in `views`.
/// A target that is not expected anywhere takes nothing that touches another one either: it may be a part of it.
OtherTargets others_of(size_t target, const std::vector<size_t>& group,
                       const std::vector<StereoVision::Target>& targets, const PairTimes& times,
                       const std::array<View, 2>& views);

/// Assigns what one pair shows to a group of targets that look alike: first to those that are expected somewhere by
/// their motion, then to the others in their order. Changes the matches and candidates of these targets.
class GroupAssignment {
 public:
  /// `group`: numbers of the targets, which have been measured and matched as if each were alone.
  GroupAssignment(std::vector<StereoVision::Target>& targets, const std::vector<size_t>& group, const PairTimes& times)
      : targets_(targets), group_(group), times_(times) {}
  void run();

 private:
  bool is_expected(size_t target) const;
  void match_bounces();
  void sort_targets();
  void assign_expected();
  void add_jump_hypotheses(const std::vector<bool>& tentative);
  void match_unassigned();
  void withhold_shared_blobs(size_t target);
  void match_lost();
  void replace_doubtful();
  void leave_far_jumps();
  void match_again(size_t target, size_t sought);

  std::vector<StereoVision::Target>& targets_;
  const std::vector<size_t>& group_;
  PairTimes times_;
  // Numbers of targets:
  std::vector<size_t> expected_;                     // expected somewhere, and may be seen there
  std::vector<size_t> unassigned_;                   // nothing is assigned to them so far
  std::vector<size_t> ambiguous_;                    // of these: what they could be may be another target as well
  std::vector<size_t> lost_;                         // looked for anywhere
  std::vector<std::vector<Hypothesis>> hypotheses_;  // of expected_, then one of each jump to what no other has
  std::vector<Hypothesis> jumps_;                    // to what established targets may have jumped
  std::array<BlobNumbers, 2> numbers_;
};

}  // namespace multireach::vision
