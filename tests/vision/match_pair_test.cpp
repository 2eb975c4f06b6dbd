// Matching of two views without images.
#include "vision/matching/match_pair.hpp"

#include <gtest/gtest.h>

namespace multireach::vision {
namespace {

/// One blob of 20 px radius, 1 m before a camera, that the remembered background explains.
View background_at(double x_px) {
  constexpr double kFocal = 500, kRadius = 20;
  View view;
  view.content = View::Content::kBlobs;
  view.whole = true;
  view.window = {0, 0, 640, 480};
  Blob blob;
  blob.box = {static_cast<int>(x_px) - 20, 220, 40, 40};
  blob.area = 1256;
  blob.centroid = {x_px, 239.5};
  view.blobs.push_back(blob);
  view.seeds.push_back(blob);
  SphereContour contour;
  contour.value = {(x_px - 319.5) / kFocal, 0, kRadius / kFocal};
  contour.covariance = Eigen::Vector3d(1e-6, 1e-6, 1e-4).asDiagonal();
  contour.centre_px = blob.centroid;
  contour.radius_px = kRadius;
  contour.area = blob.area;
  view.contours.push_back(contour);
  view.appearance.push_back({.background = 1, .compactness = 1, .colour_share = 1});
  return view;
}

// Nothing replaces it where nothing else is seen. (The sanitizers find a read beyond the views.)
TEST(MatchPair, WhatIsFollowedMayBeTheOnlyThingInView) {
  TrackerOptions options;
  options.rig = parallel_rig(640, 480, 500, 0.1);
  const View left = background_at(319.5), right = background_at(269.5);
  TrackedObject object{TargetTrack(options.track)};
  object.track.update(1000000, PositionEstimate{{0, 0, 1}, 1e-4 * Eigen::Matrix3d::Identity()});
  object.radius_m = 0.04;
  ASSERT_EQ(object.track.status(), TargetTrack::Status::kTracked);
  ASSERT_FALSE(object.identity.known());
  const PairContext pair{options, object, {1033333, 1033333, 1033333}, left, right};
  const TargetMatch found = match_pair(pair, {});
  EXPECT_EQ(found.match.status, StereoMatch::Status::kSeen) << description(found.match.status);
  EXPECT_EQ(found.match.left, 0);
  EXPECT_FALSE(found.replaces);
  EXPECT_LT((found.match.point.p_W - Eigen::Vector3d(0, 0, 1)).norm(), 0.01);
}

}  // namespace
}  // namespace multireach::vision
