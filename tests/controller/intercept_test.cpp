#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <vector>

#include "controller/intercept/free_fall_filter.hpp"
#include "controller/intercept/least_time.hpp"
#include "controller/reach_controller.hpp"
#include "controller/tracking_defaults.hpp"
#include "numeric/gaussian.hpp"
#include "numeric/random.hpp"
#include "tests/test_arms.hpp"

namespace multireach::controller {
namespace {

constexpr uint64_t kSeed = 71;
constexpr int64_t kFrame = 33333;  // us
constexpr double kNear = 0.01;     // m: half the radius of a ball that fits a small hand
const Eigen::Vector3d kGravity(0, 0, -9.81), kRelease(0.5, -0.3, 0.1), kThrown(-1.2, 0.4, 2.5);

Eigen::Vector3d thrown(double t, const Eigen::Vector3d& from = kRelease, const Eigen::Vector3d& velocity = kThrown) {
  return from + t * velocity + 0.5 * t * t * kGravity;
}

/// Noise of a standard deviation in each coordinate.
class Noise {
 public:
  explicit Noise(double sigma, uint64_t seed = kSeed) : sigma_(sigma), random_(seed) {}
  Eigen::Vector3d operator()() {
    Eigen::Vector3d noise;
    for (double& coordinate : noise) coordinate = sigma_ * gaussian(random_, counter_);
    return noise;
  }
  Eigen::Matrix3d covariance() const { return sigma_ * sigma_ * Eigen::Matrix3d::Identity(); }

 private:
  double sigma_;
  CounterRandom random_;
  uint64_t counter_ = 0;
};

double seconds(int64_t utime) {
  return 1e-6 * static_cast<double>(utime);
}

// Observations without noise: the prediction is the closed form, up to the assumed noise of half a millimetre and the
// first guess of the velocity, which both lead nowhere else when the observations lie on a parabola.
TEST(FreeFallFilter, PredictsTheParabola) {
  FreeFallFilter filter({});
  for (int k = 0; k < 8; ++k) {
    filter.observe(kFrame * k, thrown(seconds(kFrame * k)), Eigen::Matrix3d::Zero());
  }
  const auto body = filter.at(800000);
  ASSERT_TRUE(body);
  // The velocity's first guess, 0 with a deviation of 10 m/s, weighs (0.5 mm / 33 ms / 10 m/s)^2, 2e-6, of 2.8 m/s.
  EXPECT_LT((body->position - thrown(0.8)).norm(), 1e-5);
  EXPECT_LT((body->velocity - (kThrown + 0.8 * kGravity)).norm(), 1e-5);
}

// Without other accelerations the filter is the exact Gaussian posterior: errors agree with its covariance. Of 5000
// throws the mean of NEES / 3 has a standard deviation of sqrt(2 / 15000), 0.0115. The filter adds (0.5 mm)^2, a 64th
// of the noise's variance.
TEST(FreeFallFilter, ItsCovarianceIsThatOfItsErrors) {
  Noise noise(0.004);
  double sum = 0;
  int known = 0;
  for (int throws = 0; throws < 5000; ++throws) {
    FreeFallFilter filter({.other_acceleration = 1e-9});
    for (int k = 0; k < 9; ++k) filter.observe(kFrame * k, thrown(seconds(kFrame * k)) + noise(), noise.covariance());
    const auto object = filter.at(600000);
    if (!object) continue;
    const Eigen::Vector3d error = object->position - thrown(0.6);
    sum += error.dot(object->covariance.llt().solve(error)) / 3;
    ++known;
  }
  EXPECT_GT(known, 4750) << "nine images show a fall in most throws; one in a thousand disagrees by chance";
  EXPECT_NEAR(sum / known, 1, 5 * 0.0115 + 1.0 / 64) << "seed " << kSeed;
}

// A ball that is held, carried, or swung in a hand does not fall, as long as the hand accelerates it by no more than
// half of the gravity: strokes up to 15 cm, up to 2 a second, in 2000 images each, observed with noise.
TEST(FreeFallFilter, AnObjectInAHandDoesNotFall) {
  for (const double stroke : {0.0, 0.02, 0.05, 0.1, 0.15}) {
    for (const double per_s : {0.5, 1.0, 1.5, 2.0}) {
      if (stroke * std::pow(2 * M_PI * per_s, 2) > 0.5 * kGravity.norm()) continue;
      Noise noise(0.003, kSeed + static_cast<uint64_t>(1000 * stroke + 10 * per_s));
      FreeFallFilter filter({});
      for (int k = 0; k < 2000; ++k) {
        const double angle = 2 * M_PI * per_s * seconds(kFrame * k);
        const Eigen::Vector3d at = kRelease + stroke * Eigen::Vector3d(0.3 * std::cos(0.7 * angle), 0, std::sin(angle));
        filter.observe(kFrame * k, at + noise(), noise.covariance());
        ASSERT_FALSE(filter.falls()) << stroke << " m, " << per_s << " 1/s, image " << k << ", seed " << kSeed;
      }
    }
  }
}

// One wrong match in a flight is left out.
TEST(FreeFallFilter, OneWrongObservationDoesNotEndAFlight) {
  FreeFallFilter filter({});
  for (int k = 0; k < 14; ++k) {
    const Eigen::Vector3d wrong = k == 9 ? Eigen::Vector3d(0.3, 0, 0) : Eigen::Vector3d::Zero();
    filter.observe(kFrame * k, thrown(seconds(kFrame * k)) + wrong, Eigen::Matrix3d::Zero());
    EXPECT_TRUE(k < 8 || filter.falls()) << k;
  }
  EXPECT_LT((filter.at(800000)->position - thrown(0.8)).norm(), 1e-5);
}

// A bounce ends the fall; the next flight is known some images later.
TEST(FreeFallFilter, ABounceIsAnotherFlight) {
  FreeFallFilter filter({});
  int64_t utime = 0;
  for (int k = 0; k < 10; ++k, utime += kFrame) filter.observe(utime, thrown(seconds(utime)), Eigen::Matrix3d::Zero());
  EXPECT_TRUE(filter.falls());
  const double bounced = seconds(utime - kFrame / 2);
  const auto after = [&](int64_t at) { return thrown(seconds(at) - bounced, thrown(bounced), {-1.2, 0.4, 3}); };
  filter.observe(utime, after(utime), Eigen::Matrix3d::Zero());
  utime += kFrame;
  filter.observe(utime, after(utime), Eigen::Matrix3d::Zero());
  EXPECT_FALSE(filter.falls());
  for (int k = 0; k < 6; ++k) {
    utime += kFrame;
    filter.observe(utime, after(utime), Eigen::Matrix3d::Zero());
  }
  ASSERT_TRUE(filter.falls());
  EXPECT_LT((filter.at(utime + 300000)->position - after(utime + 300000)).norm(), 1e-4);
}

TEST(FreeFallFilter, IgnoresWhatIsNotFiniteOlderOrHardlyKnown) {
  FreeFallFilter filter({});
  for (int k = 0; k < 6; ++k) {
    filter.observe(kFrame * k, thrown(seconds(kFrame * k)), Eigen::Matrix3d::Zero());
    filter.observe(kFrame * k + 10, {NAN, 0, 0}, Eigen::Matrix3d::Zero());
    filter.observe(kFrame * k + 10, {9, 9, 9}, 4 * Eigen::Matrix3d::Identity());
    filter.observe(kFrame * k - 10, {9, 9, 9}, Eigen::Matrix3d::Zero());
    filter.observe(kFrame * k + 10, {9, 9, 9}, Eigen::Matrix3d::Constant(NAN));
    filter.observe(kFrame * k + 10, {9, 9, 9}, Eigen::Matrix3d::Constant(INFINITY));
    filter.observe(kFrame * k + 10, {9, 9, 9}, -Eigen::Matrix3d::Identity());
  }
  ASSERT_TRUE(filter.falls());
  EXPECT_LT((filter.at(400000)->position - thrown(0.4)).norm(), 1e-4);
}

// Against a joint that is accelerated step by step.
TEST(LeastTime, IsThatOfAJointAtFullAcceleration) {
  constexpr double kStep = 1e-5, kSpeed = 2, kAcceleration = 15;  // s, rad/s, rad/s^2
  for (const double distance : {0.01, 0.13, 0.5, 2.0}) {
    double at = 0, velocity = 0, time = 0;
    while (at < distance) {
      const double next = std::min(velocity + kStep * kAcceleration, kSpeed);
      at += kStep * (velocity + next) / 2;
      velocity = next;
      time += kStep;
    }
    EXPECT_NEAR(least_time(distance, kSpeed, kAcceleration), time, 2 * kStep);
  }
}

/// The Hoap2's controller, which waits for throws.
class Intercepting : public ::testing::Test {
 protected:
  Intercepting() : controller_(testing::hoap2(), options()) {
    start_ << 0.2, -0.3, -0.2, -0.9;
    EXPECT_TRUE(controller_.start(start_));
    controller_.restart_grid(0);
  }
  static ReachOptions options() {
    ReachOptions options;
    GuardedParameters law;
    law.gains = kTrackGains;
    options.law = law;
    options.intercept.emplace();
    return options;
  }
  /// Ticks until the time of the observation.
  void see(int64_t utime, const Eigen::Vector3d& position, bool seen = true) {
    controller_.observe({.utime = utime, .seen = seen, .position = position});
    while (*controller_.next_tick() <= utime) {
      last_ = controller_.tick();
      excess_ = std::max(excess_, controller_.chain().limit_excess(last_.theta));
    }
  }
  /// The velocity at the release that brings a body from `from` to `to` in a time.
  static Eigen::Vector3d velocity(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double time) {
    return (to - from - 0.5 * time * time * kGravity) / time;
  }

  JointVector start_{4};
  ReachController controller_;
  ReachOutput last_;
  double excess_ = 0;
  const Eigen::Vector3d held_{0.9, -0.3, 0}, to_{0.10, -0.14, 0.06};  // m; the latter within the workspace
};

// The hand is at the meeting place, at rest, when the body comes; it does not follow it before, and returns after.
TEST_F(Intercepting, IsWhereTheBodyWillBe) {
  int64_t utime = 0;
  for (; utime < 1000000; utime += kFrame) {
    see(utime, held_);
    EXPECT_LT((last_.theta - start_).cwiseAbs().maxCoeff(), 1e-9) << "waits";
    EXPECT_FALSE(last_.interception);
  }
  const int64_t released = utime;
  const Eigen::Vector3d fast = velocity(held_, to_, 0.6);
  const auto body = [&](int64_t at) { return thrown(seconds(at - released), held_, fast); };
  double closest = 1;
  for (; utime < released + 800000; utime += kFrame) {
    see(utime, body(utime));
    // A set-point holds for the end of its tick.
    const int64_t holds = last_.utime + controller_.options().tick_us;
    for (int64_t at = holds - kFrame / 2; at < holds + kFrame / 2; at += 1000)
      closest = std::min(closest, (last_.x - body(at)).norm());
  }
  EXPECT_LT(closest, kNear);
  for (; utime < released + 4000000; utime += kFrame) see(utime, {0.1, -0.1, -0.5});
  EXPECT_FALSE(last_.interception);
  EXPECT_EQ(last_.mode, ReachMode::kResting);
  EXPECT_LT((last_.theta - start_).cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_EQ(excess_, 0);
}

// A body that is hidden in the middle of its flight is met all the same.
TEST_F(Intercepting, ABodyThatIsLostInFlightIsMet) {
  const Eigen::Vector3d fast = velocity(held_, to_, 0.7);
  double closest = 1;
  for (int64_t utime = 0; utime < 900000; utime += kFrame) {
    see(utime, thrown(seconds(utime), held_, fast), utime < 250000);
    // The set-point holds for the end of its tick; the body is near it some milliseconds earlier or later.
    const int64_t holds = last_.utime + controller_.options().tick_us;
    for (int64_t at = holds - kFrame / 2; at < holds + kFrame / 2; at += 1000)
      closest = std::min(closest, (last_.x - thrown(seconds(at), held_, fast)).norm());
  }
  EXPECT_LT(closest, kNear);
}

TEST_F(Intercepting, ABodyThatPassesOutOfReachIsLeftAlone) {
  const Eigen::Vector3d fast = velocity(held_, to_ + Eigen::Vector3d(0, 2, 0), 0.6);
  for (int64_t utime = 0; utime < 900000; utime += kFrame) {
    see(utime, thrown(seconds(utime), held_, fast));
    EXPECT_FALSE(last_.interception);
  }
  EXPECT_LT((last_.theta - start_).cwiseAbs().maxCoeff(), 1e-9);
}

TEST_F(Intercepting, NeedsTheGuardedLaw) {
  ReachOptions options;
  options.law = PaperParameters{};
  options.intercept.emplace();
  EXPECT_THROW(ReachController(testing::hoap2(), options), std::invalid_argument);
  options.law = GuardedParameters{};
  options.intercept->gravity.setZero();
  EXPECT_THROW(ReachController(testing::hoap2(), options), std::invalid_argument);
}

}  // namespace
}  // namespace multireach::controller
