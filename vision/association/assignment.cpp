#include "vision/association/assignment.hpp"

#include <algorithm>
#include <limits>
#include <set>

#include "vision/stereo/stereo_match.hpp"

namespace multireach::vision {
namespace {

// Steps of the search. Six targets with six hypotheses each that exclude no others take 137,000. Where there are more
// (ten targets, each with candidates in its window), the best association may not be found: all are ambiguous.
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
  Search(std::span<const std::vector<Hypothesis>> hypotheses, const Exclusion& excluded,
         const std::vector<bool>& tentative, size_t lost)
      : hypotheses_(hypotheses), tentative_(tentative), lost_(lost), now_(hypotheses.size()) {
    for (const std::vector<Hypothesis>& of_target : hypotheses) {
      first_.push_back(all_);
      all_ += of_target.size();
    }
    // The search asks for each pair many times.
    both_.resize(all_ * all_);
    for (size_t b = 0; b < hypotheses.size(); ++b) {
      for (size_t a = 0; a < b; ++a) {
        for (size_t of_a = 0; of_a < hypotheses[a].size(); ++of_a) {
          for (size_t of_b = 0; of_b < hypotheses[b].size(); ++of_b) {
            both_[(first_[a] + of_a) * all_ + first_[b] + of_b] =
                !share_a_blob(hypotheses[a][of_a], hypotheses[b][of_b]) &&
                !(excluded && excluded({a, of_a}, {b, of_b}));
          }
        }
      }
    }
  }

  std::vector<Assignment> result() {
    visit(0, {0, 0});
    for (const std::optional<size_t>& hypothesis : best_) result_.push_back({hypothesis});
    const bool complete = steps_ <= kMostSteps;
    steps_ = 0;
    visit(0, {0, 0});
    if (!complete || steps_ > kMostSteps) {
      for (Assignment& each : result_) each.ambiguous = true;
    }
    return result_;
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
      if (!result_.empty()) {
        compare(value);
      } else if (value > best_value_) {
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

  /// Whether the association differs from the best one only by which of the tentative targets has which thing; those
  /// that are lost take what is left.
  bool is_equivalent() const {
    std::vector<const Hypothesis*> given, given_by_best;
    std::set<int> left, right;  // all blobs that the tentative targets may be
    for (size_t k = 0; k < now_.size(); ++k) {
      if (!tentative_[k]) {
        if (now_[k] != best_[k]) return false;
        continue;
      }
      for (const Hypothesis& each : hypotheses_[k]) {
        left.insert(each.left);
        right.insert(each.right);
      }
      if (now_[k]) given.push_back(&hypotheses_[k][*now_[k]]);
      if (best_[k]) given_by_best.push_back(&hypotheses_[k][*best_[k]]);
    }
    // A blob that is matched with another one of the other image is another thing.
    size_t common = 0;
    for (const Hypothesis* a : given) {
      for (const Hypothesis* b : given_by_best) {
        if ((a->left == b->left) != (a->right == b->right)) return false;
        common += a->left == b->left;
      }
    }
    return common == given.size() || std::max(left.size(), right.size()) <= given.size() + lost_;
  }

  /// Marks the targets that an association gives something else, if it is about as good as the best one.
  void compare(const Value& value) {
    if (value.given < best_value_.given || best_value_.evidence - value.evidence >= kLead) return;
    if (is_equivalent()) return;
    for (size_t k = 0; k < now_.size(); ++k) {
      const std::vector<Hypothesis>& own = hypotheses_[k];
      const bool same = now_[k] == best_[k] || (now_[k] && best_[k] && own[*now_[k]].thing == own[*best_[k]].thing);
      result_[k].ambiguous = result_[k].ambiguous || !same;
    }
  }

  std::span<const std::vector<Hypothesis>> hypotheses_;
  std::vector<bool> tentative_;
  size_t lost_;
  size_t all_ = 0;             // number of hypotheses
  std::vector<size_t> first_;  // number of each target's first one
  std::vector<bool> both_;     // for each pair of them, whether both can be true
  std::vector<std::optional<size_t>> now_, best_;
  Value best_value_;
  std::vector<Assignment> result_;  // empty until the best association is known
  int steps_ = 0;
};

}  // namespace

std::vector<Assignment> assign(std::span<const std::vector<Hypothesis>> hypotheses, const Exclusion& excluded,
                               std::vector<bool> tentative, size_t lost) {
  tentative.resize(hypotheses.size());
  return Search(hypotheses, excluded, tentative, lost).result();
}

}  // namespace multireach::vision
