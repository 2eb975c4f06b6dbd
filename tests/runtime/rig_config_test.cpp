// The pose of the cameras as a vision.yaml gives it.
#include "runtime/rig_config.hpp"

#include <gtest/gtest.h>

#include "runtime/files.hpp"

namespace multireach {
namespace {

Config cameras(const std::string& left_to_robot) {
  const std::string camera = "{width_px: 320, height_px: 240, fx_px: 300, fy_px: 300, cx_px: 160, cy_px: 120}";
  return Config::parse("vision.yaml",
                       "left: " + camera + "\nright: " + camera +
                           "\nleft_to_right: {translation_m: [-0.06, 0, 0]}\nleft_to_robot: " + left_to_robot + "\n");
}

TEST(RigConfig, ThePoseMayBeUnknown) {
  EXPECT_TRUE(load_rig(cameras("{translation_m: [0, 0, 1]}")).has_robot_pose);
  const std::string camera = "{width_px: 320, height_px: 240, fx_px: 300, fy_px: 300, cx_px: 160, cy_px: 120}";
  const RigConfig config = load_rig(Config::parse(
      "vision.yaml", "left: " + camera + "\nright: " + camera + "\nleft_to_right: {translation_m: [-0.06, 0, 0]}\n"));
  EXPECT_FALSE(config.has_robot_pose);
  EXPECT_TRUE(config.rig.X_WL.isApprox(Eigen::Isometry3d::Identity()));
}

TEST(RigConfig, ACameraLooksAtAPoint) {
  const StereoRig rig = load_rig(cameras("{look_at: {from_m: [1, -2, 1.5], at_m: [0.2, 0.1, 0.3]}}")).rig;
  const Eigen::Vector3d at(0.2, 0.1, 0.3), eye(1, -2, 1.5);
  EXPECT_TRUE(rig.X_WL.translation().isApprox(eye));
  EXPECT_NEAR(rig.X_WL.linear().determinant(), 1, 1e-12);
  // The point is on the optical axis; a point above it is above it in the image (y points down) and not beside it.
  const Eigen::Vector3d p = rig.X_WL.inverse() * at;
  EXPECT_NEAR(p.x(), 0, 1e-12);
  EXPECT_NEAR(p.y(), 0, 1e-12);
  EXPECT_NEAR(p.z(), (at - eye).norm(), 1e-12);
  const Eigen::Vector3d above = rig.X_WL.inverse() * (at + Eigen::Vector3d(0, 0, 0.1));
  EXPECT_NEAR(above.x(), 0, 1e-12);
  EXPECT_LT(above.y(), -0.05);
}

TEST(RigConfig, AGammaCurveIsKnownWhereTheFileSaysIt) {
  const std::string camera = "{width_px: 320, height_px: 240, fx_px: 300, fy_px: 300, cx_px: 160, cy_px: 120}";
  const auto with = [&](const std::string& gamma) {
    const std::string text =
        "left: " + camera + "\nright: " + camera + "\nleft_to_right: {translation_m: [-0.06, 0, 0]}\n" + gamma;
    return load_rig(Config::parse("vision.yaml", text)).rig;
  };
  EXPECT_EQ(with("").left.gamma, std::nullopt);
  EXPECT_EQ(with("gamma: 2.2\n").left.gamma, 2.2);
  EXPECT_EQ(with("gamma: 2.2\n").right.gamma, 2.2);
  EXPECT_THROW(with("gamma: 0.45\n"), InputError) << "1 / 2.2: the other way round";
  EXPECT_THROW(with("gamma: 6\n"), InputError);
}

TEST(RigConfig, RefusesADistortionThatNoLensHas) {
  const auto with = [](const std::string& k2) {
    const std::string size = "{width_px: 320, height_px: 240, fx_px: 300, fy_px: 300, cx_px: 160, cy_px: 120";
    return Config::parse("vision.yaml", "left: " + size + ", distortion: [-0.1, " + k2 + "]}\nright: " + size +
                                            "}\nleft_to_right: {translation_m: [-0.06, 0, 0]}\n");
  };
  EXPECT_NO_THROW(load_rig(with("1e4")));
  EXPECT_THROW(load_rig(with("1e20")), InputError);
}

TEST(RigConfig, RefusesALineOfSightAlongUp) {
  EXPECT_THROW(load_rig(cameras("{look_at: {from_m: [0, 0, 1], at_m: [0, 0, 0]}}")), InputError);
  EXPECT_NO_THROW(load_rig(cameras("{look_at: {from_m: [0, 0, 1], at_m: [0, 0, 0], up: [1, 0, 0]}}")));
  EXPECT_THROW(load_rig(cameras("{look_at: {from_m: [0, 0, 1], at_m: [0, 0, 1]}}")), InputError);
  EXPECT_THROW(load_rig(cameras("{look_at: {from_m: [0, 0, 1], at_m: [0, 0, 0], up: [1, 0, 0]}, rpy_rad: [0, 0, 0]}")),
               InputError);
}

Config with_errors(const std::string& errors) {
  const std::string camera = "{width_px: 320, height_px: 240, fx_px: 300, fy_px: 300, cx_px: 160, cy_px: 120}";
  return Config::parse("vision.yaml", "left: " + camera + "\nright: " + camera +
                                          "\nleft_to_right: {translation_m: [-0.06, 0, 0]}\nerrors: " + errors + "\n");
}

TEST(RigConfig, ErrorsOfTheCalibrationAreKnownWhereTheFileSaysThem) {
  EXPECT_FALSE(load_rig(cameras("{translation_m: [0, 0, 1]}")).rig.errors.known());
  const RigErrors some =
      load_rig(with_errors("{focal_length_relative: 0.002, rotation_rad: [0.001, 0.0003, 0.0005]}")).rig.errors;
  EXPECT_TRUE(some.known());
  const Eigen::Matrix<double, 5, 1> variances =
      (Eigen::Matrix<double, 5, 1>() << 2e-3, 0, 1e-3, 3e-4, 5e-4).finished().cwiseAbs2();
  EXPECT_TRUE(some.covariance.isApprox(Eigen::Matrix<double, 5, 5>(variances.asDiagonal()), 1e-12));
  const RigErrors correlated = load_rig(with_errors("{focal_length_relative: 0.002, baseline_relative: 0.001, "
                                                    "correlation: [[1, -0.5, 0, 0, 0], [-0.5, 1, 0, 0, 0], "
                                                    "[0, 0, 1, 0, 0], [0, 0, 0, 1, 0], [0, 0, 0, 0, 1]]}"))
                                   .rig.errors;
  EXPECT_NEAR(correlated.covariance(RigErrors::kFocalLength, RigErrors::kBaseline), -1e-6, 1e-15);
  EXPECT_NEAR(correlated.covariance(RigErrors::kBaseline, RigErrors::kBaseline), 1e-6, 1e-15);
}

TEST(RigConfig, RefusesErrorsOfACalibrationThatMakeNoSense) {
  const auto fault = [](const std::string& errors) -> std::string {
    try {
      load_rig(with_errors(errors));
    } catch (const InputError& error) {
      return error.what();
    }
    return "nothing was refused";
  };
  const auto refuses = [&](const std::string& errors, const std::string& key) {
    const std::string said = fault(errors);
    EXPECT_NE(said.find("vision.yaml:4"), std::string::npos) << said;
    EXPECT_NE(said.find(key), std::string::npos) << said;
  };
  refuses("{baseline_relative: -0.001}", "baseline_relative");
  refuses("{focal_length_relative: 0.5}", "focal_length_relative");
  refuses("{rotation_rad: [0.001, 0.001]}", "rotation_rad");
  refuses("{rotation_rad: [0.001, -0.001, 0]}", "rotation_rad");
  refuses("{rotation: [0.001, 0.001, 0.001]}", "rotation");
  refuses("{correlation: [1, 0, 0, 0, 1]}", "correlation");
  refuses("{correlation: [[1, 2, 0, 0, 0], [2, 1, 0, 0, 0], [0, 0, 1, 0, 0], [0, 0, 0, 1, 0], [0, 0, 0, 0, 1]]}",
          "positive semidefinite");
  refuses("{correlation: [[1, 0.5, 0, 0, 0], [0, 1, 0, 0, 0], [0, 0, 1, 0, 0], [0, 0, 0, 1, 0], [0, 0, 0, 0, 1]]}",
          "symmetric");
}

TEST(RigConfig, RollPitchAndYawAreAboutFixedAxes) {
  const double roll = 0.3, pitch = -0.4, yaw = 0.5;
  const StereoRig rig = load_rig(cameras("{translation_m: [0, 0, 0], rpy_rad: [0.3, -0.4, 0.5]}")).rig;
  EXPECT_THROW(load_rig(cameras("{translation_m: [0, 0, 0], rpy_rad: [-146, 0, -90]}")), InputError) << "degrees";
  EXPECT_THROW(load_rig(cameras("{translation_m: [-150, 20, 450]}")), InputError) << "millimetres";
  const Eigen::Matrix3d R =
      (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
       Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  EXPECT_LT((rig.X_WL.linear() - R).norm(), 1e-12);
}

}  // namespace
}  // namespace multireach
