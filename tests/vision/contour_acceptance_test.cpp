#include "vision/contour/contour_acceptance.hpp"

#include <gtest/gtest.h>

namespace multireach::vision {
namespace {

/// A whole ball of 20 px with sharp edges.
constexpr FittedContour kWhole{.radius_px = 20,
                               .residual_px = 0.1,
                               .visible_fraction = 0.95,
                               .seen_inside = 0.95,
                               .painted_missing = 0,
                               .occlusion = 0.02,
                               .cut_off = false,
                               .blob_length = 1,
                               .motion_blur2 = 0};

template <class Change>
ContourVerdict with(const Change& change, double least_seen = kSeenOfASphere) {
  FittedContour fitted = kWhole;
  change(fitted);
  return verdict_on(fitted, least_seen, 0.5);
}

TEST(ContourAcceptance, EachContradictionIsNamed) {
  using Verdict = ContourVerdict;
  EXPECT_EQ(with([](FittedContour&) {}), Verdict::kAccepted);
  EXPECT_EQ(with([](FittedContour& f) { f.residual_px = 0.7; }), Verdict::kNothing) << "0.03 of the radius";
  EXPECT_EQ(with([](FittedContour& f) { f.visible_fraction = f.seen_inside = 0.3, f.occlusion = 0.4; }),
            Verdict::kNothing);
  const auto half_missing = [](FittedContour& f) { f.visible_fraction = f.seen_inside = 0.5; };
  EXPECT_EQ(with([&](FittedContour& f) { half_missing(f); }), Verdict::kContradicted) << "nothing occludes it";
  EXPECT_EQ(with([&](FittedContour& f) { half_missing(f), f.occlusion = 0.5; }), Verdict::kAccepted);
  EXPECT_EQ(with([&](FittedContour& f) { half_missing(f), f.occlusion = 0.5; }, kSeenOfAnything), Verdict::kPart);
  EXPECT_EQ(with([&](FittedContour& f) { half_missing(f), f.painted_missing = 0.4; }), Verdict::kAccepted)
      << "a stripe";
  EXPECT_EQ(with([&](FittedContour& f) { half_missing(f), f.occlusion = 0.5, f.residual_px = 0.3; }),
            Verdict::kContradicted)
      << "an occluder leaves the other edges sharp";
  EXPECT_EQ(with([&](FittedContour& f) { half_missing(f), f.occlusion = 0.5, f.blob_length = 1.3; }),
            Verdict::kContradicted)
      << "the blob shows more";
  EXPECT_EQ(with([](FittedContour& f) { f.motion_blur2 = 2, f.blob_length = 1.1; }), Verdict::kContradicted);
  EXPECT_EQ(with([](FittedContour& f) { f.motion_blur2 = 2, f.visible_fraction = 0.7; }), Verdict::kAccepted);
}

}  // namespace
}  // namespace multireach::vision
