#include "runtime/camera_files.hpp"
#include "tools/calibrate/camera_file_texts.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>

#include "numeric/random.hpp"
#include "tests/temporary_folder.hpp"
#include "vision/node/vision_node.hpp"

namespace multireach {
namespace {

using RowMatrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

class CameraFilesTest : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_ / name; }
  std::string written(const std::string& name, const std::string& text) const {
    write_text_file(path(name), text);
    return path(name);
  }
  std::vector<std::string> written(CameraFormat format, const StereoRig& rig) const {
    std::vector<std::string> paths;
    for (const std::string& text : camera_file_texts(rig, format))
      paths.push_back(written("rig" + std::to_string(paths.size()) + ".yaml", text));
    return paths;
  }
  static std::string fault(const std::function<void()>& action) {
    try {
      action();
    } catch (const InputError& error) {
      return error.what();
    }
    return "nothing was refused";
  }

  const StereoRig rig_ = VisionConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/vision.yaml").rig;
  const testing::TemporaryFolder folder_;
};

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

void expect_same(const StereoRig& a, const StereoRig& b, double tolerance) {
  EXPECT_TRUE(a.X_RL.isApprox(b.X_RL, tolerance)) << a.X_RL.matrix() << "\n" << b.X_RL.matrix();
  for (const auto& [x, y] : {std::pair(&a.left, &b.left), std::pair(&a.right, &b.right)}) {
    EXPECT_EQ(x->width, y->width);
    EXPECT_EQ(x->height, y->height);
    EXPECT_EQ(x->fx, y->fx);
    EXPECT_EQ(x->fy, y->fy);
    EXPECT_EQ(x->cx, y->cx);
    EXPECT_EQ(x->cy, y->cy);
    EXPECT_EQ(x->distortion, y->distortion);
  }
}

TEST_F(CameraFilesTest, EveryFormatGivesTheSameRigBack) {
  for (const CameraFormat format :
       {CameraFormat::kVision, CameraFormat::kOpenCv, CameraFormat::kRos, CameraFormat::kKalibr}) {
    SCOPED_TRACE(static_cast<int>(format));
    const CameraFiles back = read_camera_files(written(format, rig_));
    EXPECT_EQ(back.format, format);
    EXPECT_FALSE(back.has_robot_pose);
    // ROS's rotation is a product of two.
    expect_same(rig_, back.rig, 1e-12);
  }
  StereoRig rational = rig_;
  rational.left.distortion = {-0.3, 0.1, 0.001, -0.002, 0.05, 0.2, 0.03, 0.004};
  for (const CameraFormat format : {CameraFormat::kVision, CameraFormat::kOpenCv, CameraFormat::kRos}) {
    SCOPED_TRACE(static_cast<int>(format));
    expect_same(rational, read_camera_files(written(format, rational)).rig, 1e-12);
  }
  EXPECT_NE(fault([&] { camera_file_texts(rational, CameraFormat::kKalibr); }).find("--lens radtan"),
            std::string::npos);
}

TEST_F(CameraFilesTest, AVisionFileKeepsHowUncertainTheCalibrationIs) {
  EXPECT_EQ(camera_file_texts(rig_, CameraFormat::kVision)[0].find("errors:"), std::string::npos);
  StereoRig rig = rig_;
  const CounterRandom random(3);
  Eigen::Matrix<double, 5, 5> any;
  for (Eigen::Index k = 0; k < any.size(); ++k) any(k) = 1e-3 * random.uniform(static_cast<uint64_t>(k), -1, 1);
  any.row(RigErrors::kBaseline) *= 1e-3;
  rig.errors.covariance = any * any.transpose();
  const RigErrors back = read_camera_files(written(CameraFormat::kVision, rig)).rig.errors;
  const Eigen::Matrix<double, 5, 1> sigma = rig.errors.covariance.diagonal().cwiseSqrt();
  EXPECT_LT(((back.covariance - rig.errors.covariance).array() / (sigma * sigma.transpose()).array()).abs().maxCoeff(),
            1e-3)
      << "a few digits are enough";
  EXPECT_FALSE(read_camera_files(written(CameraFormat::kOpenCv, rig)).rig.errors.known());
}

TEST_F(CameraFilesTest, AVisionFileKeepsTheGammaCurve) {
  StereoRig rig = rig_;
  rig.left.gamma = rig.right.gamma = 1.8;
  const StereoRig back = read_camera_files(written(CameraFormat::kVision, rig)).rig;
  EXPECT_EQ(back.left.gamma, 1.8);
  EXPECT_EQ(back.right.gamma, 1.8);
  EXPECT_EQ(read_camera_files(written(CameraFormat::kOpenCv, rig)).rig.left.gamma, std::nullopt);
  rig.left.gamma = rig.right.gamma = std::nullopt;
  EXPECT_EQ(read_camera_files(written(CameraFormat::kVision, rig)).rig.left.gamma, std::nullopt);
}

TEST_F(CameraFilesTest, OpenCvReadsWhatIsWritten) {
  const std::vector<std::string> paths = written(CameraFormat::kOpenCv, rig_);
  cv::FileStorage file(paths[0], cv::FileStorage::READ);
  ASSERT_TRUE(file.isOpened());
  cv::Mat M1, D2, R, T, P2, Q;
  file["M1"] >> M1;
  file["D2"] >> D2;
  file["R"] >> R;
  file["T"] >> T;
  file["P2"] >> P2;
  file["Q"] >> Q;
  ASSERT_EQ(M1.size(), cv::Size(3, 3));
  EXPECT_EQ(M1.at<double>(0, 2), rig_.left.cx);
  EXPECT_EQ(D2.at<double>(0, 1), rig_.right.distortion[1]);
  EXPECT_EQ(R.at<double>(0, 2), rig_.X_RL.linear()(0, 2));
  EXPECT_EQ(T.at<double>(0), rig_.X_RL.translation().x());
  EXPECT_NEAR(P2.at<double>(0, 3), -P2.at<double>(0, 0) * rig_.baseline_m(), 1e-9);
  EXPECT_NEAR(Q.at<double>(3, 2), 1 / rig_.baseline_m(), 1e-9);
}

TEST_F(CameraFilesTest, ReadsWhatOpenCvWrites) {
  // As OpenCV's sample stereo_calib writes it: two files, millimetres, no size.
  const RowMatrix3 R = rig_.X_RL.linear();
  const Eigen::Vector3d T = 1000 * rig_.X_RL.translation();
  {
    cv::FileStorage intrinsics(path("intrinsics.yml"), cv::FileStorage::WRITE);
    int number = 0;
    for (const CameraModel* camera : {&rig_.left, &rig_.right}) {
      const std::string n = std::to_string(++number);
      const cv::Mat K = (cv::Mat_<double>(3, 3) << camera->fx, 0, camera->cx, 0, camera->fy, camera->cy, 0, 0, 1);
      intrinsics << "M" + n << K << "D" + n << cv::Mat(camera->distortion, true).t();
    }
    cv::FileStorage extrinsics(path("extrinsics.yml"), cv::FileStorage::WRITE);
    extrinsics << "R" << cv::Mat(cv::Matx33d(R.data())) << "T" << cv::Mat(cv::Vec3d(T.data()));
  }
  const std::vector<std::string> paths{path("intrinsics.yml"), path("extrinsics.yml")};
  expect_same(rig_, read_camera_files(paths, {320, 240, 0.001}).rig, 1e-12);
  const auto refusal = [&](const CameraFileHints& hints) { return fault([&] { read_camera_files(paths, hints); }); };
  EXPECT_NE(refusal({{}, {}, 0.001}).find("does not say the images' size"), std::string::npos);
  EXPECT_NE(refusal({320, 240, {}}).find("does not say the unit"), std::string::npos);
  EXPECT_NE(refusal({320, 240, 1.0}).find("the baseline is 60.11 m"), std::string::npos);
  EXPECT_NE(refusal({640, 480, 0.001}).find("images of another size"), std::string::npos);
  EXPECT_NE(refusal({160, 120, 0.001}).find("images of another size"), std::string::npos);
  EXPECT_NE(fault([&] { read_camera_files({paths[0]}, {320, 240, 0.001}); }).find("has no 'R'"), std::string::npos);
}

TEST_F(CameraFilesTest, TheProjectionMatricesOfRosProjectAlike) {
  // Both rectified images show a point in the same row, fx B / Z apart.
  const std::vector<std::string> paths = written(CameraFormat::kRos, rig_);
  const Config left = Config::load(paths[0]), right = Config::load(paths[1]);
  const auto matrix = [](const Config& file, const std::string& key, int columns) {
    const std::vector<double> data = file.section(key).numbers("data", 3 * columns);
    return Eigen::MatrixXd(
        Eigen::Map<const Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>>(data.data(), 3, columns));
  };
  const Eigen::MatrixXd P1 = matrix(left, "projection_matrix", 4), P2 = matrix(right, "projection_matrix", 4);
  const Eigen::MatrixXd R1 = matrix(left, "rectification_matrix", 3), R2 = matrix(right, "rectification_matrix", 3);
  const CounterRandom random(3);
  for (uint64_t k = 0; k < 20; ++k) {
    const Eigen::Vector3d p_L(random.uniform(3 * k, -0.2, 0.2), random.uniform(3 * k + 1, -0.2, 0.2),
                              random.uniform(3 * k + 2, 0.3, 1));
    const Eigen::Vector3d in_left = R1 * p_L, in_right = R2 * (rig_.X_RL * p_L);
    const Eigen::Vector3d from_left = P2 * in_left.homogeneous(), from_right = P2.leftCols(3) * in_right;
    EXPECT_TRUE(from_left.isApprox(from_right, 1e-9)) << "seed 3, point " << k;
    const Eigen::Vector3d seen = P1 * in_left.homogeneous();
    EXPECT_NEAR(seen.y() / seen.z(), from_left.y() / from_left.z(), 1e-9);
    EXPECT_NEAR(seen.x() / seen.z() - from_left.x() / from_left.z(), P1(0, 0) * rig_.baseline_m() / in_left.z(), 1e-9);
  }
}

TEST_F(CameraFilesTest, SaysWhatIsWrong) {
  struct Case {
    CameraFormat format;
    const char *from, *to, *sentence;
  };
  const std::vector<Case> cases{
      {CameraFormat::kOpenCv, "[-0.0601", "[0.0601", "sign is wrong"},
      {CameraFormat::kOpenCv, "data: [300,", "data: [-300,", "key 'M1' expected focal lengths above 0"},
      {CameraFormat::kOpenCv, "M2:", "N2:", "has no 'M2'"},
      {CameraFormat::kOpenCv, "image_width: 320", "image_width: 1280", "another size"},
      {CameraFormat::kOpenCv, "unit: m", "unit: furlong", "expected one of m, cm, mm, inch"},
      {CameraFormat::kOpenCv, "unit: m", "unit: mm", "the baseline is 6.011e-05 m"},
      {CameraFormat::kOpenCv, "data: [0.9999", "data: [0.8", "key 'R' expected a rotation matrix"},
      {CameraFormat::kOpenCv, "data: [300, 0,", "data: [300, 0.5,", "no skew"},
      {CameraFormat::kOpenCv, "data: [300, 0,", "data: [many, 0,", "a list of 9 finite numbers"},
      {CameraFormat::kOpenCv, "rows: 3", "rows: 2", "a matrix of 3 x 3, not of 2 x 3"},
      {CameraFormat::kOpenCv, "unit: m", "unit: [", "is not valid YAML"},
      {CameraFormat::kKalibr, "radtan", "equidistant", "fisheye lenses are not supported"},
      {CameraFormat::kKalibr, "[300,", "[0,", "focal lengths above 0"},
      {CameraFormat::kKalibr, "pinhole", "omni", "expected one of pinhole"},
      {CameraFormat::kKalibr, "  T_cn_cnm1", "  T_other", "'cam1.T_cn_cnm1' is missing"},
      {CameraFormat::kKalibr, "-0.0601", "0.0601", "sign is wrong"},
      {CameraFormat::kKalibr, "cam1:", "cam2:", "'cam1' is missing"},
      {CameraFormat::kVision, "width_px: 320", "width_px: 0", "cameras.left.width_px"},
      {CameraFormat::kVision, "[-0.0601", "[-60.1", "the baseline is 60.1 m"},
      {CameraFormat::kVision, "  left:", "  middle:", "'cameras.left' is missing"},
      {CameraFormat::kVision, "cameras:", "kameras:", "is no calibration of two cameras"},
  };
  for (const Case& c : cases) {
    const std::string text = camera_file_texts(rig_, c.format).front();
    const std::string file = written("bad.yaml", replaced(text, c.from, c.to));
    const std::string sentence = fault([&] { read_camera_files({file}); });
    EXPECT_NE(sentence.find(c.sentence), std::string::npos) << c.from << " -> " << c.to << ": " << sentence;
    EXPECT_NE(sentence.find("bad.yaml"), std::string::npos) << sentence;
  }
  const std::vector<std::string> ros = written(CameraFormat::kRos, rig_);
  EXPECT_NE(fault([&] { read_camera_files({ros[1], ros[0]}); }).find("left and right are swapped"), std::string::npos);
  EXPECT_NE(fault([&] { read_camera_files({ros[0]}); }).find("give two files, left and right"), std::string::npos);
  EXPECT_NE(fault([&] { read_camera_files({ros[0], ros[0]}); }).find("calibrated one by one"), std::string::npos);
  const std::string text = read_text_file(ros[1]);
  const auto right_with = [&](const char* from, const char* to) {
    return fault([&] { read_camera_files({ros[0], written("right.yaml", replaced(text, from, to))}); });
  };
  EXPECT_NE(right_with("plumb_bob", "fisheye").find("plumb_bob, rational_polynomial"), std::string::npos);
  EXPECT_NE(right_with(", -1", ", 1").find("sign is wrong"), std::string::npos) << text;
  EXPECT_NE(fault([&] { read_camera_files({MULTIREACH_SOURCE_DIR "/README.md"}); }).find("README.md"),
            std::string::npos);
  EXPECT_NE(fault([&] {
              read_camera_files(ros, {640, 480, {}});
            }).find("the given size is 640 x 480"),
            std::string::npos);
}

TEST_F(CameraFilesTest, DamagedFilesAreRefusedOrMakeSense) {
  const CounterRandom random(12);
  uint64_t counter = 0;
  int refused = 0, taken = 0;
  for (const CameraFormat format :
       {CameraFormat::kVision, CameraFormat::kOpenCv, CameraFormat::kRos, CameraFormat::kKalibr}) {
    const std::vector<std::string> paths = written(format, rig_);
    const std::string whole = read_text_file(paths.back());
    for (int round = 0; round < 300; ++round) {
      std::string text = whole;
      for (uint64_t k = 0; k <= random.bits(counter) % 3; ++k) {
        const size_t at = random.bits(++counter) % text.size(), length = random.bits(++counter) % 12;
        const auto byte = static_cast<char>(random.bits(++counter));
        if (random.bits(++counter) % 2 == 0) {
          text.erase(at, length);
        } else {
          text[at] = byte;
        }
      }
      ++counter;
      write_text_file(paths.back(), text);
      try {
        check_rig(read_camera_files(paths).rig, "");
        ++taken;
      } catch (const InputError& error) {
        ++refused;
        EXPECT_NE(std::string(error.what()).find("rig"), std::string::npos) << error.what();
      } catch (const std::exception& error) {
        FAIL() << "seed 12, round " << round << ": " << error.what() << "\n" << text;
      }
    }
  }
  EXPECT_GT(refused, 300);
  EXPECT_GT(taken, 100) << "most digits may change";
}

TEST_F(CameraFilesTest, AVisionFileNamesAnother) {
  const std::string colour = "colour: {references: [{rgb: [220, 40, 110]}]}\n";
  const std::string extrinsics = "  left_to_robot: {translation_m: [1, 2, 3]}\n";
  write_text_file(path("stereo.yml"), camera_file_texts(rig_, CameraFormat::kOpenCv).front());
  write_text_file(path("pose.yaml"), "left_to_robot:\n" + transform_text(rig_.X_WL, "  "));
  const VisionConfig named =
      VisionConfig::load(written("vision.yaml", colour + "cameras:\n  file: stereo.yml\n" + extrinsics));
  expect_same(rig_, named.rig, 1e-12);
  EXPECT_EQ(named.rig.X_WL.translation(), Eigen::Vector3d(1, 2, 3));
  const VisionConfig both = VisionConfig::load(
      written("vision.yaml", colour + "cameras:\n  file: stereo.yml\n  left_to_robot: {file: pose.yaml}\n"));
  EXPECT_TRUE(both.rig.X_WL.isApprox(rig_.X_WL, 1e-15));

  const auto gamma_of = [&](const std::string& cameras) {
    return VisionConfig::load(written("vision.yaml", colour + "cameras:\n" + cameras)).rig.right.gamma;
  };
  StereoRig curved = rig_;
  curved.left.gamma = curved.right.gamma = 1.8;
  write_text_file(path("stereo.yaml"), camera_file_texts(curved, CameraFormat::kVision).front());
  EXPECT_EQ(gamma_of("  file: stereo.yml\n"), std::nullopt);
  EXPECT_EQ(gamma_of("  file: stereo.yaml\n"), 1.8);
  EXPECT_EQ(gamma_of("  file: stereo.yaml\n  gamma: 2.2\n"), 2.2) << "counts instead of the file's";
  written("vision.yaml", colour + "cameras:\n  file: stereo.yml\n  left_to_robot: {file: pose.yaml}\n");

  // What the named files hold belongs to the digest.
  write_text_file(path("pose.yaml"), "left_to_robot:\n  translation_m: [0, 0, 0]\n");
  EXPECT_NE(VisionConfig::load(path("vision.yaml")).digest, both.digest);

  const std::vector<std::string> ros = written(CameraFormat::kRos, rig_);
  expect_same(
      rig_,
      VisionConfig::load(written("vision.yaml", colour + "cameras:\n  files: [rig0.yaml, rig1.yaml]\n" + extrinsics))
          .rig,
      1e-12);

  const auto refusal = [&](const std::string& cameras) {
    return fault([&] { VisionConfig::load(written("vision.yaml", colour + "cameras:\n" + cameras)); });
  };
  EXPECT_NE(refusal("  file: nothing.yml\n" + extrinsics).find("nothing.yml: cannot be opened"), std::string::npos);
  EXPECT_NE(refusal("  file: vision.yaml\n" + extrinsics).find("another file than this one"), std::string::npos);
  EXPECT_FALSE(VisionConfig::load(written("vision.yaml", colour + "cameras:\n  file: stereo.yml\n")).calibrated)
      << "the camera pose is not known";
  EXPECT_NE(refusal("  file: stereo.yml\n  width_px: 640\n" + extrinsics).find("the given size is 640 x 240"),
            std::string::npos);
  EXPECT_NE(
      refusal("  file: stereo.yml\n  left: {}\n" + extrinsics).find("'cameras.left' is allowed only without file"),
      std::string::npos);
  EXPECT_NE(refusal("  file: stereo.yml\n  unit: mm\n" + extrinsics).find("another unit"), std::string::npos);
}

}  // namespace
}  // namespace multireach
