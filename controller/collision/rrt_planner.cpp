#include "controller/collision/rrt_planner.hpp"

#include <algorithm>
#include <cmath>

namespace multireach::controller {
namespace {

constexpr int kMaxNodes = 500, kMaxSamples = 400;   // some 10 ms in all; after a failure the caller tries another seed
constexpr double kStep = 0.25;                      // rad (m): length of the longest edge of a tree
constexpr double kResolution = 0.05;                // rad (m): spacing of collision checks along an edge
constexpr int kKinematics = 2, kNodesPerUnit = 64;  // work, in units of continue_planning()

}  // namespace

RrtPlanner::RrtPlanner(const Chain& chain, const std::array<bool, kMaxJoints>& fixed) : chain_(chain), fixed_(fixed) {
  from_start_.reserve(kMaxNodes);
  from_goal_.reserve(kMaxNodes);
  path_.reserve(2 * kMaxNodes);
}

void RrtPlanner::begin(const JointVector& start, const JointVector& goal, Proximity& proximity, uint64_t seed) {
  path_.clear();
  least_clearance_ = std::min({0.0, proximity.clearance(start), proximity.clearance(goal)}) - 1e-6;
  from_start_.clear();
  from_goal_.clear();
  from_start_.push_back({start, -1});
  from_goal_.push_back({goal, -1});
  random_ = CounterRandom(seed, 7);
  drawn_ = 0;
  samples_ = 0;
  phase_ = Phase::kSample;
}

std::span<const JointVector> RrtPlanner::path() const {
  return path_.empty() ? std::span<const JointVector>{} : std::span<const JointVector>(path_).subspan(1);
}

void RrtPlanner::begin_line(const JointVector& from, const JointVector& to) {
  line_ = {from, to, 1, std::max(1, static_cast<int>(std::ceil((to - from).norm() / kResolution)))};
}

RrtPlanner::LineCheck RrtPlanner::check_line(Proximity& proximity, int& work) {
  for (; line_.next <= line_.parts; ++line_.next) {
    if (work <= 0) return LineCheck::kNotYet;
    const double share = static_cast<double>(line_.next) / line_.parts;
    const bool clear = proximity.clearance(line_.from + (line_.to - line_.from) * share) >= least_clearance_;
    work -= kKinematics + proximity.distances();
    if (!clear) return LineCheck::kCollides;
  }
  return LineCheck::kClear;
}

bool RrtPlanner::begin_edge(const Tree& tree, const JointVector& towards, int& work) {
  if (tree.size() == kMaxNodes) return false;
  work -= 1 + static_cast<int>(tree.size()) / kNodesPerUnit;
  const auto nearest =
      std::ranges::min_element(tree, {}, [&](const Node& node) { return (node.theta - towards).squaredNorm(); });
  parent_ = static_cast<int>(nearest - tree.begin());
  const JointVector difference = towards - nearest->theta;
  const double distance = difference.norm();
  begin_line(nearest->theta,
             distance > kStep ? JointVector(nearest->theta + difference * (kStep / distance)) : towards);
  return true;
}

void RrtPlanner::draw_sample() {
  grows_start_ = samples_ % 2 == 0;
  target_.resize(chain_.size());
  for (int i = 0; i < chain_.size(); ++i) {
    target_[i] = random_.uniform(drawn_++, chain_.sample_lower(i), chain_.sample_upper(i));
    if (fixed_[static_cast<size_t>(i)]) target_[i] = from_start_.front().theta[i];
  }
}

/// The other tree now grows towards `target`, a node of the grown one.
void RrtPlanner::begin_connecting(const JointVector& target, int& work) {
  target_ = target;
  phase_ = begin_edge(tree(!grows_start_), target_, work) ? Phase::kConnect : Phase::kSample;
}

/// The path through both trees, which have a node in common.
void RrtPlanner::join(int in_grown, int in_other) {
  const int in_start = grows_start_ ? in_grown : in_other, in_goal = grows_start_ ? in_other : in_grown;
  for (int node = in_start; node >= 0; node = from_start_[static_cast<size_t>(node)].parent) {
    path_.push_back(from_start_[static_cast<size_t>(node)].theta);
  }
  std::ranges::reverse(path_);
  for (int node = from_goal_[static_cast<size_t>(in_goal)].parent; node >= 0;
       node = from_goal_[static_cast<size_t>(node)].parent) {
    path_.push_back(from_goal_[static_cast<size_t>(node)].theta);
  }
}

/// Connects each configuration directly to the furthest later one with a collision-free straight line.
void RrtPlanner::begin_shortening() {
  shorten_from_ = 0;
  shorten_to_ = path_.size();
  next_shortcut();
}

void RrtPlanner::next_shortcut() {
  --shorten_to_;
  while (shorten_to_ <= shorten_from_ + 1) {
    ++shorten_from_;
    shorten_to_ = path_.size() - 1;
    if (shorten_from_ + 2 >= path_.size()) {
      phase_ = Phase::kFinished;
      return;
    }
  }
  phase_ = Phase::kShorten;
  begin_line(path_[shorten_from_], path_[shorten_to_]);
}

bool RrtPlanner::continue_planning(Proximity& proximity, int work) {
  while (phase_ != Phase::kFinished && work > 0) {
    if (phase_ == Phase::kSample) {
      if (samples_ == kMaxSamples) {
        phase_ = Phase::kFinished;
        break;
      }
      draw_sample();
      grown_ = 0;
      if (samples_++ == 0) {  // at first the goal's tree grows straight to the start
        begin_connecting(from_start_.front().theta, work);
      } else if (begin_edge(tree(grows_start_), target_, work)) {
        phase_ = Phase::kGrow;
      }
      continue;
    }
    const LineCheck checked = check_line(proximity, work);
    if (checked == LineCheck::kNotYet) break;
    if (phase_ == Phase::kShorten) {
      if (checked == LineCheck::kClear) {
        path_.erase(path_.begin() + static_cast<std::ptrdiff_t>(shorten_from_) + 1,
                    path_.begin() + static_cast<std::ptrdiff_t>(shorten_to_));
        shorten_to_ = shorten_from_ + 1;
      }
      next_shortcut();
      continue;
    }
    if (checked == LineCheck::kCollides) {
      phase_ = Phase::kSample;
      continue;
    }
    Tree& extended = tree((phase_ == Phase::kGrow) == grows_start_);
    extended.push_back({line_.to, parent_});
    const int added = static_cast<int>(extended.size()) - 1;
    if (phase_ == Phase::kGrow) {
      grown_ = added;
      begin_connecting(line_.to, work);
    } else if (line_.to == target_) {
      join(grown_, added);
      begin_shortening();
    } else if (!begin_edge(extended, target_, work)) {
      phase_ = Phase::kSample;
    }
  }
  return phase_ == Phase::kFinished;
}

}  // namespace multireach::controller
