#include "vision/track/equal_targets.hpp"

#include <gtest/gtest.h>

#include "numeric/random.hpp"
#include "vision/colour/blob.hpp"

namespace multireach::vision {
namespace {

TEST(Divide, GivesEachTargetTheThingThatItIs) {
  const std::vector<std::vector<Claim>> claims{{{0, 0, 0, 20}, {1, 1, 1, 12}}, {{1, 1, 0, 18}, {0, 0, 1, 15}}};
  const std::vector<Share> shares = divide(claims);
  EXPECT_EQ(shares[0].claim, 0U);
  EXPECT_EQ(shares[1].claim, 0U);
  EXPECT_FALSE(shares[0].ambiguous || shares[1].ambiguous);
}

TEST(Divide, ABlobIsOneTargetOnly) {
  const std::vector<std::vector<Claim>> claims{{{0, 0, 0, 10}}, {{0, 1, 0, 20}}};  // the same blob of the left image
  const std::vector<Share> shares = divide(claims);
  EXPECT_FALSE(shares[0].claim);
  EXPECT_EQ(shares[1].claim, 0U);
  EXPECT_FALSE(shares[0].ambiguous || shares[1].ambiguous);
}

TEST(Divide, AsManyTargetsAsPossibleAreGivenAThing) {
  const std::vector<std::vector<Claim>> claims{{{0, 0, 0, 30}, {1, 1, 1, 1}}, {{0, 0, 0, 20}}};
  const std::vector<Share> shares = divide(claims);
  EXPECT_EQ(shares[0].claim, 1U);
  EXPECT_EQ(shares[1].claim, 0U);
}

TEST(Divide, AnExchangeThatIsAboutAsLikelyIsAmbiguousForBoth) {
  const std::vector<std::vector<Claim>> claims{
      {{0, 0, 0, 20}, {1, 1, 1, 19}}, {{1, 1, 0, 20}, {0, 0, 1, 19}}, {{2, 2, 0, 20}}};
  const std::vector<Share> shares = divide(claims);
  EXPECT_TRUE(shares[0].ambiguous && shares[1].ambiguous);
  EXPECT_FALSE(shares[2].ambiguous);
}

TEST(Divide, PartsOfOneThingAreNoAlternative) {
  const std::vector<std::vector<Claim>> claims{{{0, 0, 0, 20}, {1, 1, 0, 19}}};
  EXPECT_FALSE(divide(claims)[0].ambiguous);
}

TEST(Divide, WithoutClaimsNothingIsGiven) {
  EXPECT_TRUE(divide({}).empty());
  const std::vector<std::vector<Claim>> none(2);
  for (const Share& share : divide(none)) EXPECT_FALSE(share.claim || share.ambiguous);
}

TEST(Divide, ManyTargetsThatAllClaimEverythingAreDividedInLimitedTime) {
  std::vector<std::vector<Claim>> claims(20);
  for (int target = 0; target < 20; ++target) {
    for (int thing = 0; thing < 20; ++thing)
      claims[static_cast<size_t>(target)].push_back({thing, thing, thing, thing == target ? 9.0 : 1.0});
  }
  const std::vector<Share> shares = divide(claims);
  for (const Share& share : shares) EXPECT_TRUE(share.claim);
}

/// The best value over all divisions, by trying each.
std::pair<int, double> best_of_all(const std::vector<std::vector<Claim>>& claims, std::vector<int>& given,
                                   size_t target = 0) {
  if (target == claims.size()) {
    std::pair<int, double> value{0, 0};
    for (size_t k = 0; k < given.size(); ++k) {
      if (given[k] < 0) continue;
      const Claim& claim = claims[k][static_cast<size_t>(given[k])];
      for (size_t other = 0; other < k; ++other) {
        if (given[other] < 0) continue;
        const Claim& its = claims[other][static_cast<size_t>(given[other])];
        if (its.left == claim.left || its.right == claim.right) return {-1, 0};
      }
      value = {value.first + 1, value.second + claim.evidence};
    }
    return value;
  }
  std::pair<int, double> best{-1, 0};
  for (int k = -1; k < static_cast<int>(claims[target].size()); ++k) {
    given[target] = k;
    best = std::max(best, best_of_all(claims, given, target + 1));
  }
  return best;
}

TEST(Divide, IsTheBestOfAllDivisions) {
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    const CounterRandom random(seed);
    uint64_t at = 0;
    const auto below = [&](int most) { return static_cast<int>(random.uniform(at++) * most); };
    std::vector<std::vector<Claim>> claims(static_cast<size_t>(1 + below(4)));
    for (std::vector<Claim>& of_target : claims) {
      const int count = below(5);
      for (int k = 0; k < count; ++k) of_target.push_back({below(4), below(4), k, 10 * random.uniform(at++)});
    }
    const std::vector<Share> shares = divide(claims);
    std::vector<int> given(claims.size(), -1);
    const auto best = best_of_all(claims, given);
    std::pair<int, double> found{0, 0};
    for (size_t k = 0; k < claims.size(); ++k) {
      if (shares[k].claim) found = {found.first + 1, found.second + claims[k][*shares[k].claim].evidence};
    }
    EXPECT_EQ(found.first, best.first) << "seed " << seed;
    EXPECT_NEAR(found.second, best.second, 1e-9) << "seed " << seed;
  }
}

TEST(CommonPixels, OfTwoBlobsAreThoseThatBothHave) {
  Blob a, b;
  a.runs = {{1, 0, 5}, {1, 8, 12}, {2, 0, 4}};
  a.box = {0, 1, 12, 2};
  b.runs = {{0, 0, 9}, {1, 3, 10}, {2, 4, 6}};
  b.box = {0, 0, 10, 3};
  EXPECT_EQ(common_pixels(a, b), 4);  // 3, 4, 8 and 9 of row 1
  EXPECT_EQ(common_pixels(b, a), 4);
  EXPECT_EQ(common_pixels(a, a), 13);
  b.box.x = 20;
  EXPECT_EQ(common_pixels(a, b), 0) << "boxes that do not meet";
}

}  // namespace
}  // namespace multireach::vision
