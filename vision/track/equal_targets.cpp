#include "vision/track/equal_targets.hpp"

#include <algorithm>
#include <limits>

#include "vision/stereo/stereo_match.hpp"

namespace multireach::vision {
namespace {

// Steps of the search. Six targets with six claims each that exclude no others take 137,000; more are not tracked at
// once, for no more blobs are measured.
constexpr int kMostSteps = 200000;

/// How good a division is: first by the number of targets that are given a thing, then by evidence.
struct Value {
  int given = -1;
  double evidence = -std::numeric_limits<double>::infinity();
  friend auto operator<=>(const Value&, const Value&) = default;
};

class Search {
 public:
  explicit Search(std::span<const std::vector<Claim>> claims) : claims_(claims), now_(claims.size()) {
    for (const std::vector<Claim>& of_target : claims) best_with_.emplace_back(of_target.size() + 1);
  }

  std::vector<Share> result() {
    visit(0, {0, 0});
    std::vector<Share> shares;
    for (size_t target = 0; target < claims_.size(); ++target) shares.push_back({best_[target], doubtful(target)});
    return shares;
  }

 private:
  static bool share_a_blob(const Claim& a, const Claim& b) { return a.left == b.left || a.right == b.right; }

  bool is_free(size_t target, const Claim& claim) const {
    for (size_t before = 0; before < target; ++before) {
      if (now_[before] && share_a_blob(claims_[before][*now_[before]], claim)) return false;
    }
    return true;
  }

  void visit(size_t target, const Value& value) {
    const int most = value.given + static_cast<int>(claims_.size() - target);
    if (most < best_value_.given || ++steps_ > kMostSteps) return;
    if (target == claims_.size()) {
      for (size_t k = 0; k < target; ++k) {
        Value& with = best_with_[k][now_[k].value_or(claims_[k].size())];
        with = std::max(with, value);
      }
      if (value > best_value_) {
        best_value_ = value;
        best_ = now_;
      }
      return;
    }
    for (size_t k = 0; k < claims_[target].size(); ++k) {
      const Claim& claim = claims_[target][k];
      if (!is_free(target, claim)) continue;
      now_[target] = k;
      visit(target + 1, {value.given + 1, value.evidence + claim.evidence});
    }
    now_[target].reset();
    visit(target + 1, value);
  }

  /// Whether a division that gives the target something else is about as good as the best one.
  bool doubtful(size_t target) const {
    const std::vector<Claim>& own = claims_[target];
    const std::optional<size_t> given = best_[target];
    for (size_t k = 0; k <= own.size(); ++k) {
      const bool none = k == own.size();
      if (given ? k == *given || (!none && own[k].thing == own[*given].thing) : none) continue;
      const Value& with = best_with_[target][k];
      if (with.given == best_value_.given && best_value_.evidence - with.evidence < kLead) return true;
    }
    return false;
  }

  std::span<const std::vector<Claim>> claims_;
  std::vector<std::optional<size_t>> now_, best_;
  Value best_value_;
  std::vector<std::vector<Value>> best_with_;  // of divisions with each claim of each target, and at last with none
  int steps_ = 0;
};

}  // namespace

std::vector<Share> divide(std::span<const std::vector<Claim>> claims) {
  return Search(claims).result();
}

}  // namespace multireach::vision
