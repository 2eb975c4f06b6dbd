#include "tools/calibrate/hand_eye.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <multireach/robot_state_t.hpp>
#include <multireach/target_t.hpp>

#include "camera/rendering/ball_renderer.hpp"
#include "imaging/rig_errors.hpp"
#include "numeric/random.hpp"
#include "numeric/trigonometry.hpp"
#include "runtime/channels.hpp"
#include "runtime/joint_fields.hpp"
#include "runtime/log_file.hpp"
#include "runtime/message.hpp"
#include "runtime/robot_config.hpp"
#include "tests/temporary_folder.hpp"
#include "tools/calibrate/hand_eye_samples.hpp"
#include "vision/node/vision_node.hpp"

namespace multireach {
namespace {

/// Random positions of a hand, seen with noise that grows with the distance, mostly along the line of sight.
class Synthetic {
 public:
  explicit Synthetic(uint64_t seed) : random_(seed) {
    X_WL_.linear() = rotation_from_rpy({uniform(-3, 3), uniform(-1, 1), uniform(-3, 3)});
    X_WL_.translation() = point(0.5);
  }

  std::vector<HandEyeSample> samples(int count, const Eigen::Vector3d& p_HT, double turned_rad = 1) {
    std::vector<HandEyeSample> samples;
    for (int k = 0; k < count; ++k) {
      HandEyeSample sample;
      const Eigen::Vector3d p_L = point(0.15) + Eigen::Vector3d(0, 0, 0.6);
      sample.X_WH.linear() =
          rotation_from_rpy(turned_rad * Eigen::Vector3d(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)));
      sample.X_WH.translation() = X_WL_ * p_L - sample.X_WH.linear() * p_HT;
      const Eigen::Vector3d along = p_L.normalized();
      constexpr double kAcross = 0.0005, kAlong = 0.004;
      sample.covariance = kAcross * kAcross * Eigen::Matrix3d::Identity() + kAlong * kAlong * along * along.transpose();
      sample.p_LT = p_L + kAcross * noise() + kAlong * normal() * along;
      sample.X_WH.translation() += kHand * noise();
      samples.push_back(sample);
    }
    return samples;
  }
  double uniform(double from, double to) { return random_.uniform(counter_++, from, to); }
  /// Sum of twelve uniform numbers: variance 1.
  double normal() {
    double sum = -6;
    for (int k = 0; k < 12; ++k) sum += uniform(0, 1);
    return sum;
  }
  Eigen::Vector3d noise() { return {normal(), normal(), normal()}; }
  Eigen::Vector3d point(double reach) {
    return {uniform(-reach, reach), uniform(-reach, reach), uniform(-reach, reach)};
  }

  static constexpr double kHand = 0.001;
  Eigen::Isometry3d X_WL_ = Eigen::Isometry3d::Identity();

 private:
  CounterRandom random_;
  uint64_t counter_ = 0;
};

/// Rotation (about W's axes) and translation from the estimate to the truth.
Eigen::Matrix<double, 6, 1> error_of(const Eigen::Isometry3d& truth, const Eigen::Isometry3d& estimate) {
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(truth.linear() * estimate.linear().transpose()));
  Eigen::Matrix<double, 6, 1> error;
  error << turn.angle() * turn.axis(), truth.translation() - estimate.translation();
  return error;
}

std::string refusal(const std::vector<HandEyeSample>& samples, const HandEyeOptions& options = {}) {
  try {
    solve_hand_eye(samples, options);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "nothing was refused";
}

TEST(HandEye, ItsCovarianceIsHonest) {
  const Eigen::Vector3d p_HT(0.01, -0.02, 0.05);
  for (const bool estimate : {false, true}) {
    double nees = 0, offset_nees = 0, chi2 = 0;
    constexpr int kRuns = 200;
    for (int run = 0; run < kRuns; ++run) {
      Synthetic synthetic(static_cast<uint64_t>(run));
      const auto samples = synthetic.samples(20, p_HT);
      HandEyeOptions options{.estimate_offset = estimate, .hand_sigma_m = Synthetic::kHand};
      if (!estimate) options.p_HT = p_HT;
      const HandEye result = solve_hand_eye(samples, options);
      const auto error = error_of(synthetic.X_WL_, result.X_WL);
      nees += error.dot(result.covariance.inverse() * error) / (6 * kRuns);
      chi2 += result.chi2_per_dof / kRuns;
      if (!estimate) continue;
      const Eigen::Vector3d offset_error = p_HT - result.p_HT;
      offset_nees += offset_error.dot(result.offset_covariance.inverse() * offset_error) / (3 * kRuns);
      EXPECT_LT(offset_error.norm(), 0.01) << "seed " << run;
    }
    // chi^2 above its mean enlarges the covariance and one below does not shrink it: a little on the safe side.
    EXPECT_GT(nees, 0.75) << "seeds 0 to 199, offset estimated " << estimate;
    EXPECT_LT(nees, 1.15);
    EXPECT_NEAR(chi2, 1, 0.05);
    if (estimate) {
      EXPECT_GT(offset_nees, 0.7);
      EXPECT_LT(offset_nees, 1.2);
    }
    std::printf("offset estimated %d: NEES/6 %.3f, of the offset / 3 %.3f, chi2/dof %.3f\n", estimate, nees,
                offset_nees, chi2);
  }
}

TEST(HandEye, WrongPlacesAreLeftOut) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    Synthetic synthetic(seed);
    auto samples = synthetic.samples(30, Eigen::Vector3d::Zero());
    for (size_t k = 0; k < 9; ++k) samples[3 * k].p_LT += synthetic.point(0.3);
    const HandEye result = solve_hand_eye(samples, {.hand_sigma_m = Synthetic::kHand});
    const auto error = error_of(synthetic.X_WL_, result.X_WL);
    EXPECT_LT(error.head<3>().norm(), 0.02) << "seed " << seed;
    EXPECT_LT(error.dot(result.covariance.inverse() * error), 40) << "seed " << seed;
    for (size_t k = 0; k < samples.size(); ++k) {
      if (result.distances_m[k] > 0.05) {
        EXPECT_TRUE(result.outlier[k]) << "seed " << seed << ", place " << k;
      }
    }
    EXPECT_LE(std::ranges::count(result.outlier, true), 10) << "seed " << seed;
  }
}

TEST(HandEye, LargerResidualsThanSaidEnlargeTheCovariance) {
  Synthetic synthetic(5);
  auto samples = synthetic.samples(30, Eigen::Vector3d::Zero());
  const HandEye honest = solve_hand_eye(samples, {.hand_sigma_m = Synthetic::kHand});
  for (HandEyeSample& sample : samples) sample.covariance *= 0.01;
  const HandEye boasting = solve_hand_eye(samples, {.hand_sigma_m = 0.0001});
  EXPECT_GT(boasting.chi2_per_dof, 20);
  EXPECT_NEAR(boasting.covariance.trace() / honest.covariance.trace(), 1, 0.5);
}

TEST(HandEye, RefusesWhatDeterminesNothing) {
  Synthetic synthetic(7);
  const auto samples = synthetic.samples(12, Eigen::Vector3d::Zero(), 0);
  EXPECT_NE(refusal({samples.begin(), samples.begin() + 3}).find("3 hand positions"), std::string::npos);
  EXPECT_NE(refusal({}).find("0 hand positions"), std::string::npos);
  EXPECT_NE(refusal(samples, {.estimate_offset = true}).find("orientation varies too little"), std::string::npos)
      << refusal(samples, {.estimate_offset = true});
  auto line = samples, same = samples, shuffled = samples;
  for (size_t k = 0; k < samples.size(); ++k) {
    line[k].X_WH.translation() = Eigen::Vector3d(0.1, 0.2, 0.3) * (0.1 * static_cast<double>(k));
    line[k].p_LT = synthetic.X_WL_.inverse() * line[k].X_WH.translation();
    same[k] = samples[0];
    shuffled[k].p_LT = samples[(k * 5 + 3) % samples.size()].p_LT;
  }
  EXPECT_NE(refusal(line).find("on a line"), std::string::npos);
  EXPECT_NE(refusal(same).find("on a line"), std::string::npos);
  const std::string sentence = refusal(shuffled);
  EXPECT_TRUE(sentence.find("agree") != std::string::npos || sentence.find("does not move") != std::string::npos)
      << sentence;
}

class HandEyeFiles : public ::testing::Test {
 protected:
  const testing::TemporaryFolder folder_;
  const std::string path_ = folder_ / "poses";
};

/// Postures whose hand is well inside both images.
std::vector<JointVector> postures_in_view(const Chain& chain, const StereoRig& rig, size_t count) {
  std::vector<JointVector> postures;
  const CounterRandom random(21);
  for (uint64_t counter = 0; postures.size() < count && counter < 100000;) {
    JointVector theta(chain.size());
    for (int i = 0; i < chain.size(); ++i) theta[i] = random.uniform(counter++, chain.lower()[i], chain.upper()[i]);
    const Eigen::Vector3d p_L = rig.X_WL.inverse() * chain.position(theta);
    const auto inside = [](const CameraModel& camera, const Eigen::Vector3d& p_C) {
      if (p_C.z() < 0.25 || p_C.z() > 0.65) return false;
      const Eigen::Vector2d pixel = camera.project(p_C);
      return pixel.x() > 40 && pixel.y() > 40 && pixel.x() < camera.width - 40 && pixel.y() < camera.height - 40;
    };
    if (inside(rig.left, p_L) && inside(rig.right, rig.X_RL * p_L)) postures.push_back(theta);
  }
  return postures;
}

/// A log of what the robot says and what the vision stage says, whose clock is another one.
class SessionLog {
 public:
  SessionLog(const std::string& path, const Chain& chain) : log_(path), chain_(chain) {}

  void state(const JointVector& theta, int64_t utime) {
    robot_state_t state{};
    state.utime = utime;
    state.joint_name = joint_names(chain_);
    state.joint_position = to_field(theta);
    state.num_joints = chain_.size();
    state.joint_velocity = state.joint_effort = std::vector<double>(state.joint_position.size(), 0.0);
    log_.write(utime, channel::kRobotState, *encode(state));
  }
  void target(const Eigen::Vector3d& p_W, const Eigen::Matrix3d& covariance, int8_t status, int64_t utime) {
    target_t target{};
    target.utime = utime - 5000000;
    target.name = "ball";
    target.status = status;
    Eigen::Map<Eigen::Vector3d>(target.position_m) = p_W;
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&target.covariance_m2[0][0]) = covariance;
    log_.write(utime, channel::kTarget, *encode(target));
  }
  void close() { log_.close(); }

 private:
  LogWriter log_;
  const Chain& chain_;
};

TEST_F(HandEyeFiles, ARenderedSessionGivesTheCamerasPlaceBack) {
  // The ball is rendered where the hand is; the vision stage believes that its cameras are elsewhere.
  VisionConfig vision = VisionConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/vision.yaml");
  const Chain chain = RobotConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/robot.yaml").chain;
  const StereoRig truth = vision.rig;
  const SceneOptions scene{.distractors = 0, .noise_grey_levels = 2};
  const BallRenderer left(scene, truth.left, truth.X_WL, truth.X_WL),
      right(scene, truth.right, truth.X_WL * truth.X_RL.inverse(), truth.X_WL);
  Eigen::Isometry3d believed = Eigen::Isometry3d::Identity();
  believed.linear() = rotation_from_rpy({-2, 0.3, -1});
  believed.translation() = Eigen::Vector3d(0.3, 0.1, 0.2);
  vision::TrackerOptions options = vision.targets.front().options;
  options.rig.X_WL = believed;
  vision::StereoTracker tracker(options);

  const std::vector<JointVector> postures = postures_in_view(chain, truth, 40);
  ASSERT_EQ(postures.size(), 40U);
  SessionLog log(path_, chain);
  int64_t utime = 1000000;
  uint64_t stream = 0;
  for (const JointVector& theta : postures) {
    // The first image is of where the hand was before: it comes too soon to be believed.
    for (int frame = 0; frame < 4; ++frame, utime += 200000) {
      log.state(theta, utime);
      const Eigen::Vector3d ball = frame == 0 ? Eigen::Vector3d(0.1, -0.12, 0.1) : chain.position(theta);
      const vision::StereoMatch match = tracker.find(left.render(ball, stream), right.render(ball, stream + 1)).match;
      stream += 2;
      const bool seen = match.status == vision::StereoMatch::Status::kSeen;
      log.target(match.point.p_W, match.covariance(), seen ? target_t::STATUS_TRACKED : target_t::STATUS_LOST,
                 utime + 50000);
    }
  }
  log.close();

  const auto samples = samples_from_log(path_, chain, believed, {});
  EXPECT_GE(samples.size(), 38U);
  for (const bool estimate : {false, true}) {
    const HandEye result = solve_hand_eye(samples, {.estimate_offset = estimate});
    const auto error = error_of(truth.X_WL, result.X_WL);
    std::printf(
        "offset estimated %d: rotation %.2f mrad, translation %.2f mm, rms %.2f mm, chi2/dof %.2f, NEES/6 %.2f\n",
        estimate, 1e3 * error.head<3>().norm(), 1e3 * error.tail<3>().norm(), 1e3 * result.rms_m, result.chi2_per_dof,
        error.dot(result.covariance.inverse() * error) / 6);
    EXPECT_LT(error.head<3>().norm(), 0.01);
    EXPECT_LT((truth.X_WL * Eigen::Vector3d(0, 0, 0.45) - result.X_WL * Eigen::Vector3d(0, 0, 0.45)).norm(), 0.003);
  }
  EXPECT_THROW(samples_from_log(path_, chain, believed, {.target = "cup"}), InputError);
}

TEST_F(HandEyeFiles, TargetsOfAnUnknownCameraPoseAreInTheCamerasFrame) {
  const StereoRig truth = VisionConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/vision.yaml").rig;
  const Chain chain = RobotConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/robot.yaml").chain;
  const auto write = [&](int8_t status, const Eigen::Isometry3d& X_FW) {
    SessionLog log(path_, chain);
    int64_t utime = 1000000;
    for (const JointVector& theta : postures_in_view(chain, truth, 8)) {
      for (int frame = 0; frame < 20; ++frame, utime += 33333) {
        log.state(theta, utime);
        log.target(X_FW * chain.position(theta), 1e-6 * Eigen::Matrix3d::Identity(), status, utime + 1);
      }
    }
    log.close();
  };
  write(target_t::STATUS_UNCALIBRATED, truth.X_WL.inverse());
  // Whatever the vision file says: such targets are not in W.
  for (const std::optional<Eigen::Isometry3d>& believed :
       {std::optional<Eigen::Isometry3d>(), std::optional(Eigen::Isometry3d(Eigen::Translation3d(1, 2, 3)))}) {
    const HandEye result = solve_hand_eye(samples_from_log(path_, chain, believed, {}), {});
    EXPECT_LT((truth.X_WL.inverse() * result.X_WL).translation().norm(), 1e-9);
  }
  write(target_t::STATUS_TRACKED, Eigen::Isometry3d::Identity());
  EXPECT_THROW(samples_from_log(path_, chain, std::nullopt, {}), InputError) << "in W, but of which cameras?";
}

TEST_F(HandEyeFiles, WhatAllPositionsShareIsNoNoiseOfThem) {
  StereoRig rig = VisionConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/vision.yaml").rig;
  rig.errors.covariance.diagonal() << 1e-5, 1e-5, 1e-8, 1e-6, 1e-6;
  StereoRig rig_L = rig;
  rig_L.X_WL.setIdentity();
  const Chain chain = RobotConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/robot.yaml").chain;
  for (const int8_t status : {target_t::STATUS_TRACKED, target_t::STATUS_UNCALIBRATED}) {
    const bool in_W = status == target_t::STATUS_TRACKED;
    SessionLog log(path_, chain);
    int64_t utime = 1000000;
    for (const JointVector& theta : postures_in_view(chain, rig, 8)) {
      const Eigen::Vector3d p_W = chain.position(theta), p = in_W ? p_W : rig.X_WL.inverse() * p_W;
      const Eigen::Matrix3d shared = covariance_by_rig_errors(in_W ? rig : rig_L, p);
      for (int frame = 0; frame < 20; ++frame, utime += 33333) {
        log.state(theta, utime);
        log.target(p, 1e-6 * Eigen::Matrix3d::Identity() + shared, status, utime + 1);
      }
    }
    log.close();
    const auto samples = samples_from_log(path_, chain, rig.X_WL, {.target = "", .rig = rig});
    ASSERT_EQ(samples.size(), 8U);
    for (const HandEyeSample& sample : samples) {
      EXPECT_LT((1e6 * sample.covariance - 1e6 * sample.covariance(0, 0) * Eigen::Matrix3d::Identity()).norm(), 1e-6);
      EXPECT_LT(sample.covariance(0, 0), 1.1e-7) << "of at least ten measurements";
    }
  }
}

TEST_F(HandEyeFiles, ATargetThatTheHandOnlyFollowsIsRefused) {
  const VisionConfig vision = VisionConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/vision.yaml");
  const Chain chain = RobotConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/robot.yaml").chain;
  const std::vector<JointVector> postures = postures_in_view(chain, vision.rig, 12);
  // At every place the hand stands for a second; the target is already at the next place for the last tenth of it, or
  // only at one of the places, or it moves by less than what is seen is uncertain.
  const auto count_samples = [&](const std::function<bool(size_t)>& goes_ahead, double sigma_m) {
    SessionLog log(path_, chain);
    int64_t utime = 1000000;
    for (size_t k = 0; k + 1 < postures.size(); ++k) {
      for (int frame = 0; frame < 30; ++frame, utime += 33333) {
        log.state(postures[k], utime);
        const bool ahead = frame >= 27 && goes_ahead(k);
        log.target(chain.position(postures[k + (ahead ? 1 : 0)]), sigma_m * sigma_m * Eigen::Matrix3d::Identity(),
                   target_t::STATUS_TRACKED, utime + 1);
      }
    }
    log.close();
    return samples_from_log(path_, chain, vision.rig.X_WL, {}).size();
  };
  EXPECT_EQ(count_samples([](size_t) { return false; }, 0.001), 11U);
  EXPECT_EQ(count_samples([](size_t k) { return k == 4; }, 0.001), 10U);
  EXPECT_EQ(count_samples([](size_t) { return true; }, 0.1), 11U);
  try {
    count_samples([](size_t k) { return k % 2 == 0; }, 0.001);
    FAIL() << "nothing was refused";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("at 6 of 11 positions: the hand does not hold it"), std::string::npos)
        << error.what();
  }
}

TEST_F(HandEyeFiles, AHandThatTurnsInPlaceBeginsANewPlace) {
  // The hand's origin stays where it is; the target in it, 5 cm away, does not.
  const Joint wrist{
      .name = "wrist", .axis = Eigen::Vector3d::UnitZ(), .lower = -2, .upper = 2, .velocity = 1, .effort = 1};
  const Chain chain({wrist}, {Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity()}, "base", "hand");
  SessionLog log(path_, chain);
  int64_t utime = 1000000;
  for (const double angle : {-1.0, 0.0, 1.0}) {
    const JointVector theta = JointVector::Constant(1, angle);
    for (int frame = 0; frame < 30; ++frame, utime += 33333) {
      log.state(theta, utime);
      log.target(chain.pose(theta) * Eigen::Vector3d(0.05, 0, 0), 1e-6 * Eigen::Matrix3d::Identity(),
                 target_t::STATUS_TRACKED, utime + 1);
    }
  }
  log.close();
  EXPECT_EQ(samples_from_log(path_, chain, Eigen::Isometry3d::Identity(), {}).size(), 3U);
}

TEST_F(HandEyeFiles, ATableIsRead) {
  Synthetic synthetic(3);
  const auto samples = synthetic.samples(15, Eigen::Vector3d(0, 0, 0.05));
  const auto write = [&](const std::string& header, const std::string& extra = "") {
    std::string text = header + "\n";
    for (const HandEyeSample& sample : samples) {
      const Eigen::Quaterniond q(Eigen::Matrix3d(sample.X_WH.linear()));
      char line[400];
      std::snprintf(line, sizeof line, "%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", sample.p_LT.x(),
                    sample.p_LT.y(), sample.p_LT.z(), sample.X_WH.translation().x(), sample.X_WH.translation().y(),
                    sample.X_WH.translation().z(), q.w(), q.x(), q.y(), q.z());
      text += line;
    }
    write_text_file(path_, text + extra);
  };
  const auto sentence = [&] {
    try {
      samples_from_csv(path_, 0.001);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("nothing was refused");
  };
  const std::string header = "seen_x_m,seen_y_m,seen_z_m,hand_x_m,hand_y_m,hand_z_m,hand_qw,hand_qx,hand_qy,hand_qz";
  write(header);
  const auto back = samples_from_csv(path_, 0.001);
  ASSERT_EQ(back.size(), samples.size());
  for (size_t k = 0; k < samples.size(); ++k) {
    EXPECT_EQ(back[k].p_LT, samples[k].p_LT);
    EXPECT_TRUE(back[k].X_WH.isApprox(samples[k].X_WH, 1e-12));
    EXPECT_EQ(back[k].covariance(1, 1), 1e-6);
  }
  write(header, "1,2,3\n");
  EXPECT_NE(sentence().find(":17: expected 10 finite numbers"), std::string::npos) << sentence();
  write(header, "1,2,3,4,5,6,7,8,9,nothing\n");
  EXPECT_NE(sentence().find(":17: 'nothing' is not a number"), std::string::npos) << sentence();
  write(header, "1,2,3,4,5,6,7,8,9,10\n");
  EXPECT_NE(sentence().find("quaternion"), std::string::npos) << sentence();
  write("a,b,c,d,e,f,g,h,i,j");
  EXPECT_NE(sentence().find("has no column 'seen_x_m'"), std::string::npos) << sentence();
}

}  // namespace
}  // namespace multireach
