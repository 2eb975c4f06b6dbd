#include "vision/track/candidates.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "vision/track/unoccluded_size.hpp"

namespace multireach::vision {
namespace {

constexpr double kRadius = 0.02, kFocal = 500;

StereoRig rig() {
  StereoRig rig;
  rig.left = {.width = 640, .height = 480, .fx = kFocal, .fy = kFocal, .cx = 320, .cy = 240, .distortion = {}};
  rig.right = rig.left;
  rig.X_RL = rig.X_WL = Eigen::Isometry3d::Identity();
  rig.X_RL.translation().x() = -0.06;
  return rig;
}

/// Something of the target's colour in front of the cameras, measured without error by the centroid of its blob.
struct Thing {
  Eigen::Vector3d p_L;
  double radius_m = kRadius;
  Appearance appearance{.background = 0, .compactness = 0.9, .colour_share = 0.8};
  double size_sigma = 0;  // of its image, as a share
};

SphereContour contour_of(const CameraModel& camera, const Eigen::Vector3d& p_C, double radius_m, double size_sigma) {
  SphereContour contour;
  contour.value << p_C.hnormalized(), radius_m / p_C.norm();
  contour.covariance = std::pow(0.5 / kFocal, 2) * Eigen::Matrix3d::Identity();
  contour.covariance(2, 2) += std::pow(size_sigma * contour.value.z(), 2);
  contour.centre_px = camera.project(p_C);
  contour.radius_px = contour.value.z() * kFocal;
  contour.visible_fraction = 1;
  return contour;
}

struct Judged {
  std::vector<Candidate> candidates;
  std::optional<size_t> chosen;

  Eigen::Vector3d p_W() const { return candidates.at(chosen.value()).match.point.p_W; }
};

Judged judge(const std::vector<Thing>& things, const TargetHistory& history = {},
             const MatchOptions& options = {.radius_m = kRadius}) {
  std::vector<SphereContour> left, right;
  std::vector<Appearance> appearance;
  for (const Thing& thing : things) {
    left.push_back(contour_of(rig().left, thing.p_L, thing.radius_m, thing.size_sigma));
    right.push_back(contour_of(rig().right, rig().X_RL * thing.p_L, thing.radius_m, thing.size_sigma));
    appearance.push_back(thing.appearance);
  }
  std::optional<Prediction> prediction;
  if (history.manoeuvring) prediction = {history.manoeuvring->position, history.manoeuvring->covariance};
  Judged judged;
  const auto pairs = compare_pairs(rig(), left, right, prediction, options);
  judged.candidates = candidates_of(pairs, appearance, appearance, history, options);
  judged.chosen = choose(judged.candidates);
  return judged;
}

const Eigen::Vector3d kHere(-0.05, 0, 0.5), kThere(0.06, 0.03, 0.52);

TEST(Candidates, AsManyEqualThingsMayBeThereAsTargetsThatLookAlikeAreLookedFor) {
  std::vector<Thing> things;
  for (const double x : {-0.1, 0.0, 0.1}) things.push_back({{x, 0.05 * x, 0.5}});
  for (size_t there = 1; there <= things.size(); ++there) {
    std::vector<Candidate> candidates =
        judge({things.begin(), things.begin() + static_cast<ptrdiff_t>(there)}).candidates;
    for (size_t sought = 1; sought <= 4; ++sought)
      EXPECT_EQ(choose(candidates, sought).has_value(), there <= sought) << there << " of " << sought;
  }
}

TEST(Candidates, OneThingAloneIsChosen) {
  Thing poor{.p_L = kHere, .appearance = {.background = 1, .compactness = 0.1, .colour_share = 0.05}};
  const Judged judged = judge({poor}, {}, {});
  ASSERT_TRUE(judged.chosen);
  EXPECT_STREQ(judged.candidates[0].reason, "chosen");
}

TEST(Candidates, OfTwoEqualBallsNoneIsChosenAndBothAreNamed) {
  for (const double known : {kRadius, 0.0}) {
    const Judged judged = judge({{kHere}, {kThere}}, {}, {.radius_m = known});
    EXPECT_FALSE(judged.chosen);
    ASSERT_GE(judged.candidates.size(), 2U);
    const Eigen::Vector3d a = judged.candidates[0].match.point.p_W, b = judged.candidates[1].match.point.p_W;
    EXPECT_LT(std::min((a - kHere).norm(), (a - kThere).norm()), 1e-6);
    EXPECT_LT(std::min((b - kHere).norm(), (b - kThere).norm()), 1e-6);
    EXPECT_GT((a - b).norm(), 0.1) << "one candidate for each ball";
    EXPECT_STREQ(judged.candidates[1].reason, "it could be the target as well");
    for (size_t k = 2; k < judged.candidates.size(); ++k) EXPECT_TRUE(judged.candidates[k].mixed) << k;
  }
}

// A large thing, and a small one that is nearer: the images of both, taken together, would be two things in order.
TEST(Candidates, TwoThingsOfDifferentSizesAreNotMixed) {
  const Eigen::Vector3d near(0.03, 0, 0.1);  // left of the large one in the right image, and right of it in the left
  constexpr double kCentroid = 0.3;          // a centroid's size, as a share: both mixtures pass as one thing
  const auto judge_with = [&](double small_m) {
    Thing large{kHere, 2 * kRadius}, small{near, small_m};
    large.size_sigma = small.size_sigma = kCentroid;
    return judge({large, small}, {}, {});
  };
  const auto is_one_thing = [&](const Candidate& candidate) {
    const Eigen::Vector3d& p_W = candidate.match.point.p_W;
    return std::min((p_W - kHere).norm(), (p_W - near).norm()) < 1e-6;
  };
  for (const Candidate& candidate : judge_with(0.12 * kRadius).candidates)
    EXPECT_EQ(candidate.mixed, !is_one_thing(candidate)) << candidate.match.point.p_W.transpose();
  for (const Candidate& candidate : judge_with(0.3 * kRadius).candidates)
    EXPECT_EQ(candidate.mixed, is_one_thing(candidate)) << "of one size, the order decides";
}

TEST(Candidates, WhatIsRememberedAsStandingStillYieldsToWhatMoves) {
  Thing still{kHere};
  still.appearance.background = 1;
  for (const double larger : {1.0, 2.5}) {
    still.radius_m = larger * kRadius;
    const Judged judged = judge({still, {kThere}}, {}, {});
    ASSERT_TRUE(judged.chosen) << larger;
    EXPECT_LT((judged.p_W() - kThere).norm(), 1e-6);
    EXPECT_STREQ(judged.candidates[1].reason, "it stands where the colour was before");
  }
}

TEST(Candidates, ARaggedSpeckIsNoTargetButASmallBallIs) {
  constexpr double kSpeck = 0.0035;  // 3.5 px
  const Thing ragged{.p_L = kHere, .radius_m = kSpeck, .appearance = {.compactness = 0.15, .colour_share = 0.8}};
  const Thing ball{.p_L = kHere, .radius_m = kSpeck, .appearance = {.compactness = 0.9, .colour_share = 0.8}};
  const Thing pen{.p_L = kHere, .radius_m = 6 * kSpeck, .appearance = {.compactness = 0.15, .colour_share = 0.8}};
  const auto likely = [](const Thing& thing) {
    const Candidate candidate = judge({thing}, {}, {}).candidates.at(0);
    return is_likely(candidate.match, candidate.radius_px, thing.appearance, thing.appearance);
  };
  EXPECT_FALSE(likely(ragged));
  EXPECT_TRUE(likely(ball));
  EXPECT_TRUE(likely(pen)) << "a long thing may be the target, if it is large";
}

// Of the constants: half of the radius, 0.4 of the compactness, and an evidence of 6.5 + ln 20.
TEST(Candidates, WhatIsUnlikeTheTargetNeedsMoreEvidence) {
  const auto pair_of = [](double radius_m, double radius_px, bool by_contour) {
    ComparedPair pair;
    pair.radius_m = radius_m;
    pair.radius_px = radius_px;
    pair.match.both_by_contour = by_contour;
    return pair;
  };
  const Appearance compact{.background = 0, .compactness = 0.6, .colour_share = 0.2};  // neither for nor against it
  const Appearance ragged{.background = 0, .compactness = 0.15, .colour_share = 0.2};  // -3 by its shape
  const auto unlike = [&](double radius_m, double radius_px, const Appearance& left, const Appearance& right,
                          const TargetAppearance& target, bool by_contour = false) {
    return is_unlike(pair_of(radius_m, radius_px, by_contour), left, right, target);
  };
  const TargetAppearance target{.radius_m = 0.04, .compactness = 0.8};
  // 2 ln(pi r^2) is 8.8 for 5.1 px, and 9.7 for 6.4 px.
  EXPECT_TRUE(unlike(0.019, 5.1, compact, compact, target));
  EXPECT_FALSE(unlike(0.021, 5.1, compact, compact, target)) << "not much smaller";
  EXPECT_FALSE(unlike(0.019, 6.4, compact, compact, target)) << "smaller, but evidence enough";
  EXPECT_FALSE(unlike(0, 5.1, compact, compact, target)) << "its size is not known";
  EXPECT_TRUE(unlike(0.04, 6.4, ragged, compact, target)) << "the less compact image counts";
  EXPECT_TRUE(unlike(0.04, 6.4, compact, ragged, target));
  EXPECT_FALSE(unlike(0.04, 6.4, ragged, ragged, target, true)) << "a contour, whatever its blob";
  EXPECT_FALSE(unlike(0.04, 40, ragged, ragged, target)) << "large";
  EXPECT_FALSE(unlike(0.04, 6.4, ragged, ragged, {.radius_m = 0.04, .compactness = 0.35})) << "so is the target";
  EXPECT_FALSE(unlike(0.001, 3, ragged, ragged, {})) << "nothing is known";
}

TEST(Candidates, AThingWithoutTheTargetsColourMustHaveAShape) {
  ComparedPair pair;
  const auto off = [&](double compactness, double colour_left, double colour_right) {
    return is_off_colour(pair, {.compactness = compactness, .colour_share = colour_left},
                         {.compactness = 1, .colour_share = colour_right});
  };
  EXPECT_TRUE(off(0.5, 0, 0));
  EXPECT_TRUE(off(0.5, 0.3, 0)) << "both images must show its colour";
  EXPECT_FALSE(off(0.5, 0.02, 0.02));
  EXPECT_FALSE(off(0.7, 0, 0)) << "compact, in another light";
  pair.match.both_by_contour = true;
  EXPECT_FALSE(off(0.5, 0, 0)) << "a ball, partly covered";
}

// What passes every gate, but just so, is no first match.
TEST(Candidates, WhatHardlyFitsAKnownRadiusIsNoFirstMatch) {
  const MatchOptions options{.radius_m = kRadius};
  Candidate candidate = judge({{kHere}}, {}, options).candidates.at(0);
  EXPECT_TRUE(fits_known_radius(candidate));
  // The logarithms of the likelihoods of rows, sizes and radius are half of chi^2, whose 99.9 per cent with three
  // degrees of freedom is 16.27.
  candidate.evidence.term[Evidence::kStereo] = -3;
  candidate.evidence.term[Evidence::kSize] = 3 - 0.5 * 16.2;
  EXPECT_TRUE(fits_known_radius(candidate));
  candidate.evidence.term[Evidence::kSize] = 3 - 0.5 * 16.3;
  EXPECT_FALSE(fits_known_radius(candidate));
}

// A ball that moves before cameras that are not synchronised fits no pair: a speck that fits is not the target.
TEST(Candidates, WhatBothImagesShowAndNoPairLocatesOutdoesASpeck) {
  const auto outdone = [](bool in_left, bool in_right, double known, double later_m = 0.03, bool cut_off = false) {
    const Thing speck{
        .p_L = kThere, .radius_m = 0.2 * kRadius, .appearance = {.compactness = 0.4, .colour_share = 0.1}};
    const Eigen::Vector3d later = kHere + Eigen::Vector3d(0, later_m, 0);  // 30 px in between
    std::array<std::vector<SphereContour>, 2> contours{
        std::vector{contour_of(rig().left, speck.p_L, speck.radius_m, 0)},
        std::vector{contour_of(rig().right, rig().X_RL * speck.p_L, speck.radius_m, 0)}};
    if (in_left) contours[0].push_back(contour_of(rig().left, kHere, kRadius, 0));
    if (in_right) contours[1].push_back(contour_of(rig().right, rig().X_RL * later, kRadius, 0));
    if (in_left) contours[0].back().cut_off = cut_off;
    const std::vector<Appearance> appearance{speck.appearance, Thing{kHere}.appearance};
    const MatchOptions options{.radius_m = known};
    const auto pairs = compare_pairs(rig(), contours[0], contours[1], std::nullopt, options);
    const std::vector<Candidate> candidates = candidates_of(pairs, appearance, appearance, {}, options);
    EXPECT_EQ(candidates.size(), 1U);
    return outdone_by(candidates.at(0), candidates, pairs, {contours[0], contours[1]}, {appearance, appearance}, 0,
                      options) != nullptr;
  };
  for (const double known : {0.0, 0.2 * kRadius}) {
    EXPECT_TRUE(outdone(true, true, known));
    EXPECT_FALSE(outdone(true, false, known)) << "what one camera sees may be outside of the other's view";
    EXPECT_FALSE(outdone(false, true, known));
    EXPECT_FALSE(outdone(false, false, known));
    EXPECT_FALSE(outdone(true, true, known, 0.08)) << "two things, more than a diameter apart";
    EXPECT_FALSE(outdone(true, true, known, 0.03, true)) << "what the border cuts off fits nothing";
  }
}

// While a target at the border starts no track, a speck is not the target. A ball that is as good is.
TEST(Candidates, WhatTheBorderCutsOffOutdoesASpeckButNoBall) {
  const auto outdone = [](const Thing& whole, bool cut_off, double seen_radius_m = 0) {
    const Thing entering{kHere};
    std::array<std::vector<SphereContour>, 2> contours;
    for (const Thing* thing : {&whole, &entering}) {
      contours[0].push_back(contour_of(rig().left, thing->p_L, thing->radius_m, 0));
      contours[1].push_back(contour_of(rig().right, rig().X_RL * thing->p_L, thing->radius_m, 0));
    }
    for (auto& side : contours) side.back().cut_off = cut_off;
    const std::vector<Appearance> appearance{whole.appearance, entering.appearance};
    const auto pairs = compare_pairs(rig(), contours[0], contours[1], std::nullopt, {});
    std::vector<Candidate> candidates = candidates_of(pairs, appearance, appearance, {}, {});
    std::erase_if(candidates,
                  [&](const Candidate& candidate) { return cut_off ? candidate.match.left != 0 : candidate.mixed; });
    const auto speck = std::ranges::find(candidates, 0, [](const Candidate& each) { return each.match.left; });
    const ComparedPair* better =
        outdone_by(*speck, candidates, pairs, {contours[0], contours[1]}, {appearance, appearance}, seen_radius_m, {});
    EXPECT_TRUE(!better || better->match.status == StereoMatch::Status::kCutOff);
    return better != nullptr;
  };
  const Thing speck{.p_L = kThere, .radius_m = 0.2 * kRadius, .appearance = {.compactness = 0.4, .colour_share = 0.1}};
  EXPECT_TRUE(outdone(speck, true));
  EXPECT_TRUE(outdone(speck, true, kRadius));
  EXPECT_FALSE(outdone(speck, true, 0.5 * kRadius)) << "at the border is something larger than what was seen lately";
  EXPECT_FALSE(outdone(speck, false)) << "what is whole is a candidate itself";
  EXPECT_FALSE(outdone({.p_L = kThere, .radius_m = 0.7 * kRadius}, true));
  Thing slow{.p_L = kThere, .radius_m = 0.7 * kRadius};
  slow.appearance.background = 0.4;
  EXPECT_FALSE(outdone(slow, true)) << "a ball that moves slowly is partly remembered as background";
}

// Where the target is expected, something much larger and more ragged is not the target.
TEST(Candidates, ASmearIsLargerAndMoreRaggedThanTheTarget) {
  const TargetAppearance target{.radius_m = kRadius, .compactness = 0.9};
  const auto smear = [&](double radius_m, double compactness, bool by_contour = false) {
    const Thing thing{.p_L = kHere, .radius_m = radius_m};
    const SphereContour left = contour_of(rig().left, thing.p_L, radius_m, 0),
                        right = contour_of(rig().right, rig().X_RL * thing.p_L, radius_m, 0);
    ComparedPair pair = compare_pairs(rig(), std::array{left}, std::array{right}, std::nullopt, {}).at(0);
    pair.match.both_by_contour = by_contour;
    const Appearance appearance{.compactness = compactness};
    return is_smear(pair, appearance, appearance, target);
  };
  EXPECT_TRUE(smear(2.1 * kRadius, 0.3));
  EXPECT_FALSE(smear(1.9 * kRadius, 0.3)) << "seen with something else";
  EXPECT_FALSE(smear(2.1 * kRadius, 0.4)) << "an ellipse of 5 : 2";
  EXPECT_FALSE(smear(2.1 * kRadius, 0.3, true)) << "a contour has a size of its own";
}

TEST(Candidates, SizeAloneDecidesOnlyAgainstSpecks) {
  EXPECT_FALSE(judge({{kHere, 2 * kRadius}, {kThere}}, {}, {}).chosen);
  EXPECT_TRUE(judge({{kHere, 5 * kRadius}, {kThere}}, {}, {}).chosen) << "25 times the area";
}

TEST(Candidates, EachTermCanDecide) {
  const auto worse = [](const auto& change, const MatchOptions& options = {}) {
    Thing other{kThere};
    change(other);
    const Judged judged = judge({other, {kHere}}, {}, options);
    EXPECT_TRUE(judged.chosen && (judged.p_W() - kHere).norm() < 1e-6);
    return judged.candidates.size() > 1 ? std::string(judged.candidates[1].reason) : "";
  };
  EXPECT_EQ(worse([](Thing& thing) { thing.appearance.compactness = 0.1; }), "it is less round");
  EXPECT_EQ(worse([](Thing& thing) { thing.appearance.colour_share = 0; }), "its colour fits less");
  EXPECT_EQ(worse([](Thing& thing) { thing.radius_m = 1.35 * kRadius; }, {.radius_m = kRadius}),
            "its size fits the target less");
}

TargetHistory expected_at(const Eigen::Vector3d& p_W, double steady_m, double manoeuvring_m) {
  TargetHistory history;
  history.steady = {p_W, steady_m * steady_m * Eigen::Matrix3d::Identity()};
  history.manoeuvring = {p_W, manoeuvring_m * manoeuvring_m * Eigen::Matrix3d::Identity()};
  history.radius_m = kRadius;
  return history;
}

TEST(Candidates, ATrackedTargetIsNotMistakenForWhatAppearsElsewhere) {
  for (const double known : {kRadius, 0.0}) {
    const TargetHistory history = expected_at(kHere + Eigen::Vector3d(0.002, 0, 0.005), 0.003, 0.04);
    const Judged judged = judge({{kHere}, {kThere}}, history, {.radius_m = known});
    ASSERT_TRUE(judged.chosen);
    EXPECT_LT((judged.p_W() - kHere).norm(), 1e-3);
  }
}

TEST(Candidates, TwoThatAreEquallyNearThePredictionAreAmbiguous) {
  const Eigen::Vector3d other = kHere + Eigen::Vector3d(0.05, 0, 0);
  const Judged judged = judge({{kHere}, {other}}, expected_at(0.5 * (kHere + other), 0.02, 0.04));
  EXPECT_FALSE(judged.chosen);
  ASSERT_GE(judged.candidates.size(), 2U);
}

TEST(Candidates, PartsOfOneThingAreNotTwo) {
  // A ball that a stripe divides: two halves, nearer to each other than two balls can be.
  const Thing upper{kHere - Eigen::Vector3d(0, 0.011, 0), 0.6 * kRadius},
      lower{kHere + Eigen::Vector3d(0, 0.011, 0), 0.6 * kRadius};
  EXPECT_TRUE(judge({upper, lower}, {}, {}).chosen);
}

// A bar hides the middle of a box: the centre is between what is seen on its two sides.
TEST(Candidates, WhatMayBeTwoPartsOfOneThingIsUncertain) {
  constexpr double kPart = 0.02;
  const Eigen::Vector3d apart(0, 0.018, 0);
  const Judged judged = judge({{kHere - apart, kPart}, {kHere + apart, 0.9 * kPart}}, {}, {});
  ASSERT_TRUE(judged.chosen.has_value());
  ASSERT_EQ(judged.candidates.size(), 2U);
  const Eigen::Matrix3d covariance = covariance_of_parts(judged.candidates, *judged.chosen);
  const double share = 0.81 / 1.81;  // of the areas
  EXPECT_NEAR(std::sqrt(covariance(1, 1)), 2 * apart.y() * share, 1e-4);
  EXPECT_LT(covariance(0, 0), 1e-9);
  const Judged far = judge({{kHere, kPart}, {kThere, 0.3 * kPart}}, {}, {});
  ASSERT_TRUE(far.chosen.has_value());
  EXPECT_EQ(covariance_of_parts(far.candidates, *far.chosen).norm(), 0) << "two things";
}

TEST(UnoccludedSize, WhatLooksSmallerThanBeforeIsUncertain) {
  constexpr int64_t kSecond = 1'000'000;
  UnoccludedSize size;
  EXPECT_EQ(size.occlusion_covariance(0.01, 0).norm(), 0) << "nothing is known";
  int64_t utime = kSecond;
  for (int k = 0; k < 30; ++k) size.update(0.02, utime += kSecond / 10);
  EXPECT_NEAR(size.radius_m(), 0.02, 1e-12);
  EXPECT_EQ(size.occlusion_covariance(0.02, utime).norm(), 0);
  EXPECT_EQ(size.occlusion_covariance(0.03, utime).norm(), 0);
  // The centre of a disc of which half is hidden is 0.42 of its radius off, and that of a square half of its side.
  const double half = 0.02 * std::sqrt(0.5);
  EXPECT_NEAR(std::sqrt(size.occlusion_covariance(half, utime)(0, 0)), 0.5 * 0.02, 1e-9);
  EXPECT_EQ(size.occlusion_covariance(half, utime + 30 * kSecond).norm(), 0) << "by then, it is another size";
  for (int k = 0; k < 10; ++k) size.update(0.014, utime += kSecond / 10);
  EXPECT_GT(size.radius_m(), 0.0195) << "a second hides nothing for ever";
  size.update(0.014, utime += 30 * kSecond);
  EXPECT_EQ(size.radius_m(), 0.014) << "after long, it is another size";
}

}  // namespace
}  // namespace multireach::vision
