#include "vision/track/equal_targets.hpp"

#include <algorithm>
#include <limits>

#include "vision/stereo/stereo_match.hpp"

namespace multireach::vision {
namespace {

// Steps of the search. Six targets with six hypotheses each that exclude no others take 137,000; more are not tracked
// at once, for no more blobs are measured.
constexpr int kMostSteps = 200000;

/// How good an association, an assignment to every target, is: first by the number of targets that are given a thing,
/// then by evidence.
struct Value {
  int given = -1;
  double evidence = -std::numeric_limits<double>::infinity();
  friend auto operator<=>(const Value&, const Value&) = default;
};

class Search {
 public:
  Search(std::span<const std::vector<Hypothesis>> hypotheses, const Exclusion& excluded)
      : hypotheses_(hypotheses), now_(hypotheses.size()) {
    for (const std::vector<Hypothesis>& of_target : hypotheses) {
      first_.push_back(all_);
      all_ += of_target.size();
      best_with_.emplace_back(of_target.size() + 1);
    }
    // The search asks for each pair many times.
    both_.resize(all_ * all_);
    for (size_t b = 0; b < hypotheses.size(); ++b) {
      for (size_t a = 0; a < b; ++a) {
        for (size_t of_a = 0; of_a < hypotheses[a].size(); ++of_a) {
          for (size_t of_b = 0; of_b < hypotheses[b].size(); ++of_b) {
            both_[(first_[a] + of_a) * all_ + first_[b] + of_b] =
                !share_a_blob(hypotheses[a][of_a], hypotheses[b][of_b]) && !excluded({a, of_a}, {b, of_b});
          }
        }
      }
    }
  }

  std::vector<Assignment> result() {
    visit(0, {0, 0});
    std::vector<Assignment> assignments;
    for (size_t target = 0; target < hypotheses_.size(); ++target)
      assignments.push_back({best_[target], doubtful(target)});
    return assignments;
  }

 private:
  static bool share_a_blob(const Hypothesis& a, const Hypothesis& b) { return a.left == b.left || a.right == b.right; }

  bool is_free(size_t target, size_t hypothesis) const {
    for (size_t before = 0; before < target; ++before) {
      if (now_[before] && !both_[(first_[before] + *now_[before]) * all_ + first_[target] + hypothesis]) return false;
    }
    return true;
  }

  void visit(size_t target, const Value& value) {
    const int most = value.given + static_cast<int>(hypotheses_.size() - target);
    if (most < best_value_.given || ++steps_ > kMostSteps) return;
    if (target == hypotheses_.size()) {
      for (size_t k = 0; k < target; ++k) {
        Value& with = best_with_[k][now_[k].value_or(hypotheses_[k].size())];
        with = std::max(with, value);
      }
      if (value > best_value_) {
        best_value_ = value;
        best_ = now_;
      }
      return;
    }
    for (size_t k = 0; k < hypotheses_[target].size(); ++k) {
      if (!is_free(target, k)) continue;
      now_[target] = k;
      visit(target + 1, {value.given + 1, value.evidence + hypotheses_[target][k].evidence});
    }
    now_[target].reset();
    visit(target + 1, value);
  }

  /// Whether an association that gives the target something else is about as good as the best one.
  bool doubtful(size_t target) const {
    const std::vector<Hypothesis>& own = hypotheses_[target];
    const std::optional<size_t> given = best_[target];
    for (size_t k = 0; k <= own.size(); ++k) {
      const bool none = k == own.size();
      if (given ? k == *given || (!none && own[k].thing == own[*given].thing) : none) continue;
      const Value& with = best_with_[target][k];
      if (with.given == best_value_.given && best_value_.evidence - with.evidence < kLead) return true;
    }
    return false;
  }

  std::span<const std::vector<Hypothesis>> hypotheses_;
  size_t all_ = 0;             // number of hypotheses
  std::vector<size_t> first_;  // number of each target's first one
  std::vector<bool> both_;     // for each pair of them, whether both can be true
  std::vector<std::optional<size_t>> now_, best_;
  Value best_value_;
  // Of associations with each hypothesis of each target, and at last with none.
  std::vector<std::vector<Value>> best_with_;
  int steps_ = 0;
};

}  // namespace

std::vector<Assignment> assign(std::span<const std::vector<Hypothesis>> hypotheses, const Exclusion& excluded) {
  return Search(hypotheses, excluded).result();
}

}  // namespace multireach::vision
