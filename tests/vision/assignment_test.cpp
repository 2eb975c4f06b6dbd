#include "vision/association/assignment.hpp"

#include <gtest/gtest.h>

#include "numeric/random.hpp"
#include "vision/colour/blob.hpp"

namespace multireach::vision {
namespace {

TEST(Assign, GivesEachTargetTheThingThatItIs) {
  const std::vector<std::vector<Hypothesis>> hypotheses{{{0, 0, 0, 20}, {1, 1, 1, 12}}, {{1, 1, 0, 18}, {0, 0, 1, 15}}};
  const std::vector<Assignment> assignments = assign(hypotheses);
  EXPECT_EQ(assignments[0].hypothesis, 0U);
  EXPECT_EQ(assignments[1].hypothesis, 0U);
  EXPECT_FALSE(assignments[0].ambiguous || assignments[1].ambiguous);
}

TEST(Assign, ABlobIsOneTargetOnly) {
  const std::vector<std::vector<Hypothesis>> hypotheses{{{0, 0, 0, 10}},
                                                        {{0, 1, 0, 20}}};  // the same blob of the left image
  const std::vector<Assignment> assignments = assign(hypotheses);
  EXPECT_FALSE(assignments[0].hypothesis);
  EXPECT_EQ(assignments[1].hypothesis, 0U);
  EXPECT_FALSE(assignments[0].ambiguous || assignments[1].ambiguous);
}

TEST(Assign, AsManyTargetsAsPossibleAreGivenAThing) {
  const std::vector<std::vector<Hypothesis>> hypotheses{{{0, 0, 0, 30}, {1, 1, 1, 1}}, {{0, 0, 0, 20}}};
  const std::vector<Assignment> assignments = assign(hypotheses);
  EXPECT_EQ(assignments[0].hypothesis, 1U);
  EXPECT_EQ(assignments[1].hypothesis, 0U);
}

TEST(Assign, AnExchangeThatIsAboutAsLikelyIsAmbiguousForBoth) {
  const std::vector<std::vector<Hypothesis>> hypotheses{
      {{0, 0, 0, 20}, {1, 1, 1, 19}}, {{1, 1, 0, 20}, {0, 0, 1, 19}}, {{2, 2, 0, 20}}};
  const std::vector<Assignment> assignments = assign(hypotheses);
  EXPECT_TRUE(assignments[0].ambiguous && assignments[1].ambiguous);
  EXPECT_FALSE(assignments[2].ambiguous);
}

TEST(Assign, WhichOfTheTentativeHasWhichThingDoesNotMatter) {
  const std::vector<std::vector<Hypothesis>> hypotheses{{{0, 0, 0, 20}, {1, 1, 1, 19}}, {{1, 1, 0, 20}, {0, 0, 1, 19}}};
  const auto ambiguous = [&](const std::vector<bool>& tentative) {
    const std::vector<Assignment> assignments = assign(hypotheses, {}, tentative);
    EXPECT_EQ(assignments[0].hypothesis, 0U) << "the likelier one";
    EXPECT_EQ(assignments[0].ambiguous, assignments[1].ambiguous);
    return assignments[0].ambiguous;
  };
  EXPECT_FALSE(ambiguous({true, true}));
  EXPECT_TRUE(ambiguous({true, false})) << "the second is established, and may be the other thing";
  EXPECT_TRUE(ambiguous({false, false}));
}

TEST(Assign, OfMoreThingsThanTentativeTargetsAllOrNoneAreTaken) {
  // One target and two things: which is the target? With another one that takes what is left, both are targets.
  const std::vector<std::vector<Hypothesis>> hypotheses{{{0, 0, 0, 20}, {1, 1, 1, 19}}};
  EXPECT_TRUE(assign(hypotheses, {}, {true}, 0)[0].ambiguous);
  EXPECT_FALSE(assign(hypotheses, {}, {true}, 1)[0].ambiguous);
  EXPECT_TRUE(assign(hypotheses, {}, {false}, 1)[0].ambiguous) << "an established target is one of them only";
}

TEST(Assign, OtherPairsOfBlobsAreOtherThings) {
  const std::vector<std::vector<Hypothesis>> one{{{0, 0, 0, 20}, {0, 1, 1, 19}}};
  EXPECT_TRUE(assign(one, {}, {true}, 0)[0].ambiguous);
  EXPECT_TRUE(assign(one, {}, {true}, 1)[0].ambiguous);
  const std::vector<std::vector<Hypothesis>> two{{{0, 0, 0, 20}, {0, 1, 1, 19}}, {{1, 1, 0, 20}, {1, 0, 1, 19}}};
  for (const Assignment& each : assign(two, {}, {true, true})) EXPECT_TRUE(each.ambiguous);
}

TEST(Assign, PartsOfOneThingAreNoAlternative) {
  const std::vector<std::vector<Hypothesis>> hypotheses{{{0, 0, 0, 20}, {1, 1, 0, 19}}};
  EXPECT_FALSE(assign(hypotheses)[0].ambiguous);
}

TEST(Assign, HypothesesThatExcludeEachOtherAreNotBothGiven) {
  const std::vector<std::vector<Hypothesis>> hypotheses{{{0, 0, 0, 20}, {1, 1, 1, 5}}, {{1, 1, 0, 20}, {0, 0, 1, 5}}};
  const auto straight_on = [](auto a, auto b) { return a.second == 0 && b.second == 0; };
  const std::vector<Assignment> assignments = assign(hypotheses, straight_on);
  EXPECT_EQ(assignments[0].hypothesis, 1U);
  EXPECT_EQ(assignments[1].hypothesis, 1U);
  EXPECT_FALSE(assignments[0].ambiguous || assignments[1].ambiguous);
}

TEST(Assign, WithoutHypothesesNothingIsGiven) {
  EXPECT_TRUE(assign({}).empty());
  const std::vector<std::vector<Hypothesis>> none(2);
  for (const Assignment& assignment : assign(none)) EXPECT_FALSE(assignment.hypothesis || assignment.ambiguous);
}

TEST(Assign, ManyTargetsThatMayBeEverythingAreAssignedInLimitedTime) {
  std::vector<std::vector<Hypothesis>> hypotheses(20);
  for (int target = 0; target < 20; ++target) {
    for (int thing = 0; thing < 20; ++thing)
      hypotheses[static_cast<size_t>(target)].push_back({thing, thing, thing, thing == target ? 9.0 : 1.0});
  }
  const std::vector<Assignment> assignments = assign(hypotheses);
  for (const Assignment& assignment : assignments) {
    EXPECT_TRUE(assignment.hypothesis);
    EXPECT_TRUE(assignment.ambiguous) << "not all associations were compared";
  }
}

/// The best value over all associations, by trying each.
std::pair<int, double> best_of_all(const std::vector<std::vector<Hypothesis>>& hypotheses, std::vector<int>& given,
                                   size_t target = 0) {
  if (target == hypotheses.size()) {
    std::pair<int, double> value{0, 0};
    for (size_t k = 0; k < given.size(); ++k) {
      if (given[k] < 0) continue;
      const Hypothesis& hypothesis = hypotheses[k][static_cast<size_t>(given[k])];
      for (size_t other = 0; other < k; ++other) {
        if (given[other] < 0) continue;
        const Hypothesis& its = hypotheses[other][static_cast<size_t>(given[other])];
        if (its.left == hypothesis.left || its.right == hypothesis.right) return {-1, 0};
      }
      value = {value.first + 1, value.second + hypothesis.evidence};
    }
    return value;
  }
  std::pair<int, double> best{-1, 0};
  for (int k = -1; k < static_cast<int>(hypotheses[target].size()); ++k) {
    given[target] = k;
    best = std::max(best, best_of_all(hypotheses, given, target + 1));
  }
  return best;
}

TEST(Assign, IsTheBestOfAllAssociations) {
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    const CounterRandom random(seed);
    uint64_t at = 0;
    const auto below = [&](int most) { return static_cast<int>(random.uniform(at++) * most); };
    std::vector<std::vector<Hypothesis>> hypotheses(static_cast<size_t>(1 + below(4)));
    for (std::vector<Hypothesis>& of_target : hypotheses) {
      const int count = below(5);
      for (int k = 0; k < count; ++k) of_target.push_back({below(4), below(4), k, 10 * random.uniform(at++)});
    }
    const std::vector<Assignment> assignments = assign(hypotheses);
    std::vector<int> given(hypotheses.size(), -1);
    const auto best = best_of_all(hypotheses, given);
    std::pair<int, double> found{0, 0};
    for (size_t k = 0; k < hypotheses.size(); ++k) {
      if (assignments[k].hypothesis)
        found = {found.first + 1, found.second + hypotheses[k][*assignments[k].hypothesis].evidence};
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
