#include "vision/track/target_track.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <functional>
#include <tuple>
#include <vector>

#include "numeric/gaussian.hpp"

namespace multireach::vision {
namespace {

using Status = TargetTrack::Status;
constexpr int64_t kFrame = 33333;
const Eigen::Vector3d kSigma(5e-5, 5e-5, 3e-4);

double normal(const CounterRandom& random, uint64_t k) {
  uint64_t counter = 2 * k;
  return gaussian(random, counter);
}

PositionEstimate seen_at(const Eigen::Vector3d& p) {
  return {p, kSigma.cwiseAbs2().asDiagonal()};
}

PositionEstimate seen_at(const Eigen::Vector3d& p, const CounterRandom& random, uint64_t k) {
  return seen_at(p + kSigma.cwiseProduct(
                         Eigen::Vector3d(normal(random, 3 * k), normal(random, 3 * k + 1), normal(random, 3 * k + 2))));
}

/// The mean of a number computed from the track, over a run without its first second.
double mean_of(const std::function<Eigen::Vector3d(double)>& path,
               const std::function<double(const TargetTrack&, double)>& number) {
  const CounterRandom random(11);
  TargetTrack track({});
  double sum = 0;
  int count = 0;
  for (int k = 0; k < 600; ++k) {
    const double t = k * kFrame * 1e-6;
    EXPECT_TRUE(track.update(k * kFrame, seen_at(path(t), random, static_cast<uint64_t>(k)))) << k;
    if (k < 30) continue;
    sum += number(track, t);
    ++count;
  }
  return sum / count;
}

TEST(TargetTrack, SaysWhereTheTargetWasBefore) {
  const CounterRandom random(12);
  const Eigen::Vector3d velocity(0.6, 0, -0.2);
  TargetTrack track({});
  for (int k = 0; k < 60; ++k)
    track.update(k * kFrame, seen_at(k * kFrame * 1e-6 * velocity, random, static_cast<uint64_t>(k)));
  double before = track.estimate().covariance.trace();
  for (int k = 58; k > 50; --k) {
    const PositionEstimate estimate = track.estimate_before(k * kFrame);
    const Eigen::Vector3d error = estimate.position - k * kFrame * 1e-6 * velocity;
    EXPECT_LT(error.dot(estimate.covariance.ldlt().solve(error)), 16.3) << k;  // 99.9 % of chi^2, three degrees
    EXPECT_GT(estimate.covariance.trace(), before) << k;
    before = estimate.covariance.trace();
    EXPECT_EQ(track.unseen_status(k * kFrame), Status::kCoasting);
  }
  EXPECT_EQ(track.unseen_status(40 * kFrame), Status::kLost) << "longer ago than it coasts";
}

TEST(TargetTrack, IsQuietWhereTheTargetRests) {
  const Eigen::Vector3d p(0.2, -0.1, 0.4);
  const auto path = [&](double) { return p; };
  const double place2 =
      mean_of(path, [&](const TargetTrack& track, double) { return (track.estimate().position - p).squaredNorm(); });
  const double speed2 = mean_of(path, [](const TargetTrack& track, double) { return track.velocity().squaredNorm(); });
  EXPECT_LT(std::sqrt(place2), 0.7 * kSigma.norm());
  EXPECT_LT(std::sqrt(speed2), 0.005);
}

TEST(TargetTrack, FollowsAHandThatMovesIt) {
  // Oscillation of 10 cm amplitude at 0.7 Hz: 0.44 m/s, 1.9 m/s^2.
  const double w = 2 * M_PI * 0.7;
  const auto path = [&](double t) { return Eigen::Vector3d(0.1 * std::sin(w * t), 0, 0.5); };
  const double place2 = mean_of(
      path, [&](const TargetTrack& track, double t) { return (track.estimate().position - path(t)).squaredNorm(); });
  const double speed2 = mean_of(path, [&](const TargetTrack& track, double t) {
    return (track.velocity() - Eigen::Vector3d(0.1 * w * std::cos(w * t), 0, 0)).squaredNorm();
  });
  EXPECT_LT(std::sqrt(place2), 1.5 * kSigma.norm());
  EXPECT_LT(std::sqrt(speed2), 0.05);
}

TEST(TargetTrack, FollowsAThrow) {
  TargetTrack track({});
  const Eigen::Vector3d gravity(0, 0, -9.81), v0(1.5, 0, 3);
  int taken = 0;
  for (int k = 0; k < 25; ++k) {
    const double t = k < 5 ? 0 : (k - 5) * kFrame * 1e-6;
    taken += track.update(k * kFrame, seen_at(v0 * t + 0.5 * gravity * t * t)) ? 1 : 0;
  }
  EXPECT_GE(taken, 22) << "but for the confirmation of the throw";
  EXPECT_LT((track.velocity() - (v0 + gravity * 19 * kFrame * 1e-6)).norm(), 0.3);
}

TEST(TargetTrack, CovarianceIsHonestForTheMotionThatItAssumes) {
  const CounterRandom random(3);
  double sum = 0;
  int count = 0;
  for (uint64_t run = 0; run < 200; ++run) {
    TargetTrack::Options options;
    options.min_process_noise_m2_s3 = options.coasting_process_noise_m2_s3 = options.max_process_noise_m2_s3 = 1;
    TargetTrack track(options);
    Eigen::Vector3d p(0, 0, 0.5), v(0, 0, 0);
    const double dt = kFrame * 1e-6;
    for (uint64_t k = 0; k < 40; ++k) {
      for (int axis = 0; axis < 3; ++axis) {  // exact discretisation of white-noise acceleration
        const uint64_t at = 1000000 + 1000 * run + 10 * k + 2 * static_cast<uint64_t>(axis);
        const double a = normal(random, at), b = normal(random, at + 1);
        p[axis] += v[axis] * dt + std::sqrt(dt * dt * dt / 3) * a;
        v[axis] += std::sqrt(dt) * (std::sqrt(0.75) * a + 0.5 * b);
      }
      track.update(static_cast<int64_t>(k) * kFrame, seen_at(p, random, 100 * run + k));
      if (k < 10 || track.status() != Status::kTracked) continue;
      const Eigen::Vector3d off = track.velocity() - v;
      sum += off.dot(track.velocity_covariance().ldlt().solve(off)) / 3;
      ++count;
    }
  }
  EXPECT_NEAR(sum / count, 1, 0.1);
}

TEST(TargetTrack, CoastsThroughAShortLossAndIsLostInALongOne) {
  TargetTrack track({});
  int64_t t = 0;
  for (int k = 0; k < 30; ++k, t += kFrame) track.update(t, seen_at({0.3 * static_cast<double>(t) * 1e-6, 0, 0.5}));
  double before = 0;
  int coasted = 0;
  for (; coasted < 100; ++coasted, t += kFrame) {
    EXPECT_FALSE(track.update(t, std::nullopt));
    if (track.status() != Status::kCoasting) break;
    const double variance = track.estimate().covariance.trace();
    EXPECT_GT(variance, before);
    before = variance;
    EXPECT_NEAR(track.estimate().position.x(), 0.3 * static_cast<double>(t) * 1e-6, 0.02);
    EXPECT_EQ(track.utime() - *track.last_seen_utime(), (coasted + 1) * kFrame);
  }
  EXPECT_EQ(track.status(), Status::kLost);
  EXPECT_GE(coasted, 4);
  EXPECT_LE(coasted, 15);
  EXPECT_FALSE(track.predicted(t));
  EXPECT_TRUE(track.update(t + kFrame, seen_at({1, 1, 1})));
  EXPECT_EQ(track.status(), Status::kTracked);
}

TEST(TargetTrack, EndsWhereNoPairsCameForLong) {
  for (const bool stalls : {false, true}) {
    TargetTrack track({});
    const auto seen = [](double x) { return PositionEstimate{{x, 0, 0.5}, 1e-6 * Eigen::Matrix3d::Identity()}; };
    int64_t utime = 0;
    for (int k = 0; k < 20; ++k, utime += 33333) ASSERT_TRUE(track.update(utime, seen(0.001 * k)));
    utime += stalls ? 600'000 : 300'000;
    track.expire(utime);
    EXPECT_EQ(track.status() == TargetTrack::Status::kLost, stalls);
    ASSERT_TRUE(track.update(utime, seen(0.03)));
    EXPECT_EQ(track.start() != TargetTrack::Start::kNone, stalls);
  }
}

TEST(TargetTrack, SlowPairsAreNoPause) {
  TargetTrack track({.coast_s = 0});
  const auto seen = [](double x) { return PositionEstimate{{x, 0, 0.5}, 1e-6 * Eigen::Matrix3d::Identity()}; };
  int64_t utime = 0;
  for (int k = 0; k < 10; ++k, utime += 200'000) {
    track.expire(utime);
    ASSERT_TRUE(track.update(utime, seen(0.001 * k)));
    EXPECT_EQ(track.start() == TargetTrack::Start::kFirst, k == 0);
  }
}

TEST(TargetTrack, WhatIsElsewhereIsAJumpHoweverNear) {
  TargetTrack track({});
  const auto seen = [](double x) { return PositionEstimate{{x, 0, 0.5}, 1e-4 * Eigen::Matrix3d::Identity()}; };
  int64_t utime = 0;
  for (int k = 0; k < 20; ++k, utime += 33333) ASSERT_TRUE(track.update(utime, seen(0)));
  EXPECT_FALSE(track.update(utime, seen(0.01), TargetTrack::Jump::kIfConfirmed, true));
  EXPECT_TRUE(track.update(utime + 33333, seen(0.01), TargetTrack::Jump::kIfConfirmed, true));
  EXPECT_EQ(track.start(), TargetTrack::Start::kJump);
}

TEST(TargetTrack, RejectsAJumpUntilItIsConfirmed) {
  const Eigen::Vector3d here(0, 0, 0.5), there(0.3, 0, 0.5);
  TargetTrack track({});
  int64_t t = 0;
  const auto see = [&](const Eigen::Vector3d& p) { return track.update(t += kFrame, seen_at(p)); };
  for (int k = 0; k < 10; ++k) EXPECT_TRUE(see(here));
  EXPECT_FALSE(see(there)) << "one wrong match";
  EXPECT_EQ(track.status(), Status::kCoasting);
  EXPECT_LT((track.estimate().position - here).norm(), 0.01);
  EXPECT_TRUE(see(here));
  // Wrong matches at different positions do not confirm a jump.
  for (int k = 0; k < 4; ++k) EXPECT_FALSE(see({k % 2 ? 0.4 : -0.4, 0.3, 0.5}));
  EXPECT_TRUE(see(here));
  for (int k = 0; k < 5; ++k)
    EXPECT_FALSE(track.update(t += kFrame, seen_at(there), TargetTrack::Jump::kNever)) << "it cannot be told there";
  EXPECT_TRUE(see(here));
  EXPECT_FALSE(see(there));
  EXPECT_FALSE(see(there));
  EXPECT_TRUE(see(there)) << "confirmed";
  EXPECT_LT((track.estimate().position - there).norm(), 1e-3);
}

// A target rests, then is measured poorly, as where little of it is visible, while it moves as the filter's model of a
// target that is not seen has it. Poor measurements do not tell that it rests.
TEST(TargetTrack, IsConsistentWhileATargetIsMeasuredPoorly) {
  constexpr double kPoor = 0.02, kDt = kFrame * 1e-6;
  const double noise = TargetTrack::Options().coasting_process_noise_m2_s3;
  constexpr int kRuns = 200, kPairs = 10;
  double nees = 0;
  for (int run = 0; run < kRuns; ++run) {
    const CounterRandom random(static_cast<uint64_t>(run));
    uint64_t counter = 0;
    const auto normals = [&] {
      const double x = gaussian(random, counter), y = gaussian(random, counter), z = gaussian(random, counter);
      return Eigen::Vector3d(x, y, z);
    };
    TargetTrack track({});
    Eigen::Vector3d p(0, 0, 0.5), v(0, 0, 0);
    int64_t t = 0;
    for (int k = 0; k < 30; ++k) track.update(t += kFrame, seen_at(p + kSigma.cwiseProduct(normals())));
    for (int k = 0; k < kPairs; ++k) {
      // White acceleration over a step: of its two parts, one moves the target by half a step of the velocity it adds.
      const Eigen::Vector3d change = std::sqrt(noise * kDt) * normals();
      p += kDt * v + 0.5 * kDt * change + std::sqrt(noise * kDt * kDt * kDt / 12) * normals();
      v += change;
      const PositionEstimate seen{p + kPoor * normals(), kPoor * kPoor * Eigen::Matrix3d::Identity()};
      ASSERT_TRUE(track.update(t += kFrame, seen, TargetTrack::Jump::kNever)) << "run " << run << ", " << k;
    }
    const Eigen::Vector3d error = track.estimate().position - p;
    nees += error.dot(track.estimate().covariance.ldlt().solve(error));
  }
  // The standard deviation of the mean of chi^2 / 3 is sqrt(2 / 3 / runs), 0.06; and the measurements that do not fit
  // raise the process noise.
  EXPECT_NEAR(nees / 3 / kRuns, 1, 4 * std::sqrt(2.0 / 3 / kRuns));
}

TEST(TargetTrack, TakesABounceWithTheSecondMatchAfterIt) {
  // A ball that falls onto a table at 4 m/s and leaves it at 3 m/s, between two pairs.
  const double dt = kFrame * 1e-6, g = 9.81;
  const auto height = [&](int k) {
    const double t = (k - 0.5) * dt;  // since the bounce
    return t < 0 ? -4 * t - 0.5 * g * t * t : 3 * t - 0.5 * g * t * t;
  };
  TargetTrack track({});
  for (int k = -10; k <= 0; ++k) EXPECT_TRUE(track.update((k + 20) * kFrame, seen_at({0, 0, height(k)}))) << k;
  EXPECT_FALSE(track.update(21 * kFrame, seen_at({0, 0, height(1)}))) << "it could be another object";
  EXPECT_TRUE(track.update(22 * kFrame, seen_at({0, 0, height(2)})));
  EXPECT_NEAR(track.velocity().z(), 3 - g * 1.5 * dt, 0.3);
  for (int k = 3; k < 8; ++k) EXPECT_TRUE(track.update((k + 20) * kFrame, seen_at({0, 0, height(k)}))) << k;
}

TEST(TargetTrack, ANearJumpNeedsOneMatchLessButAtLeastTwo) {
  for (const auto& [confirmations, near, far] : {std::tuple(1, 1, 1), {2, 2, 2}, {3, 2, 3}, {5, 4, 5}}) {
    for (const double distance : {0.09, 0.6}) {
      TargetTrack::Options options;
      options.confirmations = confirmations;
      TargetTrack track(options);
      int64_t t = 0;
      for (int k = 0; k < 10; ++k) EXPECT_TRUE(track.update(t += kFrame, seen_at({0, 0, 0.5})));
      int needed = 1;
      while (needed < 9 && !track.update(t += kFrame, seen_at({distance, 0, 0.5}))) ++needed;
      EXPECT_EQ(needed, distance < 0.1 ? near : far) << confirmations << " at " << distance;
    }
  }
}

TEST(TargetTrack, ABounceIsNoFasterThanTheTarget) {
  TargetTrack track({});
  int64_t t = 0;
  const double step = 0.05;  // 1.5 m/s
  for (int k = 0; k < 10; ++k) EXPECT_TRUE(track.update(t += kFrame, seen_at({step * k, 0, 0.5})));
  const Eigen::Vector3d last(9 * step, 0, 0.5);
  const auto there = [&](double x, double z) { return seen_at(last + Eigen::Vector3d(x, 0, z)); };
  const PositionEstimate back = there(-0.8 * step, 0);
  EXPECT_TRUE(track.may_bounce_to(t + kFrame, back));
  EXPECT_FALSE(track.may_bounce_to(t + kFrame, there(-2 * step, 0))) << "3 m/s";
  // A depth that is measured poorly excuses no way to the side.
  PositionEstimate poor = there(-2 * step, 0);
  poor.covariance(2, 2) = 0.07 * 0.07;
  EXPECT_FALSE(track.may_bounce_to(t + kFrame, poor));
  poor.position = last + Eigen::Vector3d(0, 0, 2 * step);
  EXPECT_TRUE(track.may_bounce_to(t + kFrame, poor));
  EXPECT_TRUE(track.may_bounce_to(t + 120000, back));
  EXPECT_FALSE(track.may_bounce_to(t + 120001, back)) << "it was seen too long ago";
  EXPECT_FALSE(TargetTrack({}).may_bounce_to(t, back)) << "it was never seen";
  TargetTrack missed = track;
  missed.update(t + kFrame, std::nullopt);
  EXPECT_FALSE(missed.may_bounce_to(t + 2 * kFrame, back)) << "it was not seen in the pair before";

  EXPECT_TRUE(track.update(t + kFrame, back, TargetTrack::Jump::kAtOnce));
  EXPECT_EQ(track.start(), TargetTrack::Start::kJumpAtOnce);
  EXPECT_NEAR(track.estimate().position.x(), back.position.x(), 1e-9);
  EXPECT_NEAR(track.velocity_covariance()(0, 0), 3 * 3 / 5.0, 1e-9);
}

TEST(TargetTrack, ABallAtRestDoesNotBounce) {
  TargetTrack track({});
  int64_t t = 0;
  for (int k = 0; k < 10; ++k) EXPECT_TRUE(track.update(t += kFrame, seen_at({0, 0, 0.5})));
  EXPECT_FALSE(track.may_bounce_to(t + kFrame, seen_at({0.05, 0, 0.5})));
}

TEST(TargetTrack, TakesTimesAsTheyCome) {
  TargetTrack track({});
  const Eigen::Vector3d p(0, 0, 0.5);
  EXPECT_TRUE(track.update(2000000, seen_at(p)));
  EXPECT_FALSE(track.update(2000000, seen_at(p))) << "the same pair again";
  EXPECT_FALSE(track.update(1900000, seen_at(p))) << "late";
  EXPECT_EQ(track.utime(), 2000000);
  EXPECT_TRUE(track.update(2000000 + kFrame, seen_at(p)));
  EXPECT_FALSE(track.update(500000, seen_at({1, 0, 0.5}))) << "older: a user of the stage decides when time restarts";
  EXPECT_FALSE(track.update(600000, PositionEstimate{{std::nan(""), 0, 0}, Eigen::Matrix3d::Identity()}));
}

/// A blob's centroid, whose error along the line of sight, z, is the same in each image.
PositionEstimate centroid_at(const Eigen::Vector3d& p, double error_m, bool with_bias = true) {
  PositionEstimate seen{p + Eigen::Vector3d(0, 0, error_m),
                        Eigen::Vector3d(0.003, 0.003, 0.13).cwiseAbs2().asDiagonal()};
  if (with_bias) seen.bias_covariance = seen.covariance;
  return seen;
}

/// A minute of centroids that are off by 0.2 m.
void see_centroids(const Eigen::Vector3d& p, bool with_bias, TargetTrack& track) {
  for (int k = 0; k < 1800; ++k) ASSERT_TRUE(track.update(k * kFrame, centroid_at(p, 0.2, with_bias))) << k;
}

TEST(TargetTrack, BiasDoesNotHideWhereTheTargetIs) {
  const Eigen::Vector3d p(0.1, 0, 1.3);
  TargetTrack track({}), without({});
  see_centroids(p, true, track);
  TargetTrack restored({});
  ASSERT_TRUE(restored.deserialize(track.utime(), track.serialize()));
  EXPECT_TRUE(restored.expects(1800 * kFrame, seen_at(p)));
  EXPECT_TRUE(restored.is_near(1800 * kFrame, seen_at(p)));
  EXPECT_TRUE(restored.update(1800 * kFrame, seen_at(p)));
  EXPECT_LT((restored.estimate().position - p).norm(), 3 * kSigma.norm());
  EXPECT_LT(restored.velocity().norm(), 0.1);
  see_centroids(p, false, without);
  EXPECT_FALSE(without.update(1800 * kFrame, seen_at(p))) << "what the bias is considered for";
  EXPECT_FALSE(without.is_near(1800 * kFrame, seen_at(p)));
  EXPECT_FALSE(TargetTrack(track).update(1800 * kFrame, seen_at(p + Eigen::Vector3d(0.2, 0, 0))))
      << "a jump is still one";
  EXPECT_FALSE(track.update(1800 * kFrame, seen_at(p + Eigen::Vector3d(0, 0, 0.9)))) << "also along the line of sight";
}

TEST(TargetTrack, OneCentroidAmongContoursMakesNoBias) {
  const Eigen::Vector3d p(0.1, 0, 1.3);
  TargetTrack track({});
  int64_t utime = 0;
  for (int k = 0; k < 60; ++k) ASSERT_TRUE(track.update(utime += kFrame, seen_at(p)));
  ASSERT_TRUE(track.update(utime += kFrame, centroid_at(p, 0.2)));
  EXPECT_FALSE(TargetTrack(track).update(utime + kFrame, seen_at(p + Eigen::Vector3d(0, 0, 0.3))));
  EXPECT_FALSE(track.update(utime += kFrame, std::nullopt));
  const PositionEstimate coasting = track.estimate();
  EXPECT_LT(std::sqrt((coasting.covariance + coasting.bias_covariance)(2, 2)), 0.01);
}

TEST(TargetTrack, AJumpThatACentroidAndAContourConfirmHasAnHonestVelocity) {
  const Eigen::Vector3d p(0.1, 0, 1.3), there = p + Eigen::Vector3d(0.5, 0, 0);
  TargetTrack track({});
  int64_t utime = 0;
  for (int k = 0; k < 60; ++k) ASSERT_TRUE(track.update(utime += kFrame, seen_at(p)));
  EXPECT_FALSE(track.update(utime += kFrame, centroid_at(there, 0.2)));
  EXPECT_FALSE(track.update(utime += kFrame, centroid_at(there, 0.2)));
  ASSERT_TRUE(track.update(utime += kFrame, seen_at(there)));
  EXPECT_LT(std::abs(track.velocity().z()), 3 * std::sqrt(track.velocity_covariance()(2, 2)));
  EXPECT_TRUE(track.update(utime += kFrame, seen_at(there)));
}

/// Mean over many targets of e^T S^-1 e / 3, which is 1 where the covariance S is that of the errors e, and less where
/// it is larger.
TEST(TargetTrack, ItsCovarianceCoversBias) {
  constexpr int kTargets = 300, kPairs = 120;
  const CounterRandom random(20);
  std::vector<double> of_position(kPairs), of_velocity(kPairs);
  uint64_t drawn = 0;
  const auto vector = [&] {
    drawn += 3;
    return Eigen::Vector3d(normal(random, drawn), normal(random, drawn + 1), normal(random, drawn + 2));
  };
  const Eigen::Vector3d sigma(0.003, 0.003, 0.13);
  for (int k = 0; k < kTargets; ++k) {
    TargetTrack track({});
    const Eigen::Vector3d bias = sigma.cwiseProduct(vector()), velocity = 0.3 * vector();
    for (int pair = 0; pair < kPairs; ++pair) {
      const Eigen::Vector3d p = Eigen::Vector3d(0, 0, 2) + velocity * (pair * 1e-6 * kFrame);
      // 40 centroids, 40 contours, then one of three is a centroid.
      const bool centroid = pair < 40 || (pair >= 80 && pair % 3 == 0);
      const PositionEstimate seen = centroid ? centroid_at(p, 0) : seen_at(p);
      const Eigen::Vector3d noise = kSigma.cwiseProduct(vector());
      track.update((pair + 1) * kFrame,
                   PositionEstimate{seen.position + noise + (centroid ? bias : Eigen::Vector3d::Zero().eval()),
                                    seen.covariance, seen.bias_covariance});
      const PositionEstimate estimate = track.estimate();
      const auto at = static_cast<size_t>(pair);
      const Eigen::Vector3d error = estimate.position - p, faster = track.velocity() - velocity;
      const Eigen::Matrix3d covariance = estimate.covariance + estimate.bias_covariance;
      of_position[at] += error.dot(covariance.ldlt().solve(error)) / 3 / kTargets;
      of_velocity[at] += faster.dot(track.velocity_covariance().ldlt().solve(faster)) / 3 / kTargets;
    }
  }
  for (size_t pair = 0; pair < kPairs; ++pair) {
    EXPECT_LT(of_position[pair], 1.25) << pair;
    EXPECT_LT(of_velocity[pair], 1.25) << pair;
  }
}

TEST(TargetTrack, GoesOnFromItsState) {
  const CounterRandom random(4);
  TargetTrack track({});
  for (int k = 0; k < 200; ++k) {
    TargetTrack other({});
    ASSERT_TRUE(other.deserialize(track.utime(), track.serialize()));
    const int64_t t = 1000000 + k * kFrame;
    std::optional<PositionEstimate> seen;
    const double x = k % 50 > 40 ? 0.3 : 0;  // the target also jumps
    if (random.uniform(static_cast<uint64_t>(5000 + k)) > 0.2)
      seen = seen_at({x, 0, 0.5}, random, static_cast<uint64_t>(k));
    if (seen && k % 3 == 0) seen->bias_covariance = seen->covariance;
    EXPECT_EQ(track.update(t, seen), other.update(t, seen));
    ASSERT_EQ(track.serialize(), other.serialize()) << k;
    EXPECT_EQ(track.status(), other.status());
  }
  const std::vector<double> memory = track.serialize();
  for (size_t k = 0; k < memory.size(); ++k) {
    std::vector<double> broken = memory;
    broken[k] = std::nan("");
    EXPECT_FALSE(track.deserialize(0, broken));
  }
  EXPECT_FALSE(track.deserialize(0, {memory.data(), memory.size() - 1}));
  EXPECT_EQ(track.serialize(), memory);
}

}  // namespace
}  // namespace multireach::vision
