#include <gtest/gtest.h>
#include <matio.h>

#include <cmath>
#include <filesystem>
#include <multireach/images_t.hpp>
#include <multireach/joint_setpoint_t.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "runtime/files.hpp"
#include "runtime/log_file.hpp"
#include "runtime/message.hpp"
#include "tests/temporary_folder.hpp"
#include "tools/log/export.hpp"

namespace multireach {
namespace {

class LogExport : public ::testing::Test {
 protected:
  LogExport() {
    LogWriter log(path("log"));
    for (int64_t k = 0; k < 10; ++k) {
      joint_setpoint_t message{};
      message.sequence = k;
      message.num_joints = k < 5 ? 1 : 2;
      message.joint_name = {"a \"quoted\", joint"};
      message.joint_position = {0.1 * static_cast<double>(k)};
      message.joint_velocity = {NAN};
      if (k >= 5) {
        message.joint_name.emplace_back("b");
        message.joint_position.push_back(1);
        message.joint_velocity.push_back(2);
      }
      log.write(1000 + k, "JOINT_SETPOINT", *encode(message));
    }
    log.write(1010, "JOINT_SETPOINT", std::vector<uint8_t>{1, 2, 3});
    log.write(1011, "THEIRS", std::vector<uint8_t>{1, 2, 3});
    log.close();
  }
  std::string path(const std::string& name) const { return folder_ / name; }

  const testing::TemporaryFolder folder_;
};

TEST_F(LogExport, TablesHaveAColumnForEveryElement) {
  EXPECT_EQ(export_csv(path("log"), path("csv"), {}), 10);
  std::istringstream table(read_text_file(path("csv") + "/JOINT_SETPOINT.csv"));
  std::string header, first, line;
  std::getline(table, header);
  std::getline(table, first);
  EXPECT_EQ(header,
            "log_utime,utime,sequence,run,tick,target_sequence,robot_state_sequence,obstacles_sequence,num_joints,"
            "joint_name[0],joint_position[0],joint_velocity[0],joint_name[1],joint_position[1],joint_velocity[1]");
  EXPECT_EQ(first, "1000,0,0,0,0,0,0,0,1,\"a \"\"quoted\"\", joint\",0,nan,,,");
  int lines = 1;
  while (std::getline(table, line)) ++lines;
  EXPECT_EQ(lines, 10);
  EXPECT_FALSE(std::filesystem::exists(path("csv") + "/THEIRS.csv"));
  EXPECT_EQ(export_csv(path("log"), path("none"), {"NOTHING"}), 0);
}

TEST_F(LogExport, MatlabGetsAStructPerChannel) {
  EXPECT_EQ(export_mat(path("log"), path("log.mat"), {}), 10);
  mat_t* mat = Mat_Open(path("log.mat").c_str(), MAT_ACC_RDONLY);
  ASSERT_NE(mat, nullptr);
  matvar_t* channel = Mat_VarRead(mat, "JOINT_SETPOINT");
  ASSERT_NE(channel, nullptr);
  const matvar_t* angles = Mat_VarGetStructFieldByName(channel, "joint_position", 0);
  ASSERT_NE(angles, nullptr);
  EXPECT_EQ(angles->dims[0], 10U);
  EXPECT_EQ(angles->dims[1], 2U);
  const auto* numbers = static_cast<const double*>(angles->data);
  EXPECT_EQ(numbers[3], 0.1 * 3);
  EXPECT_TRUE(std::isnan(numbers[10])) << "the second joint was not there yet";
  EXPECT_EQ(numbers[19], 1);
  Mat_VarFree(channel);
  Mat_Close(mat);
  EXPECT_THROW(export_mat(path("log"), "/nowhere/log.mat", {}), InputError);
}

TEST_F(LogExport, ImagesBecomeFiles) {
  std::vector<std::string> warnings;
  const std::string session = MULTIREACH_SOURCE_DIR "/logs/reach.lcm";
  LogReader reader(session);
  LogWriter writer(path("images"));
  int pairs = 0;
  while (const auto event = reader.next()) {
    auto images = decode<images_t>(event->data);
    if (!images || pairs == 3) continue;
    if (++pairs == 2) {
      images->images[1].data.resize(100);
      images->images[1].size = 100;
    }
    writer.write(event->utime, event->channel, *encode(*images));
  }
  writer.close();
  EXPECT_EQ(export_images(path("images"), path("png"), {}, warnings), 5);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0], "event 1: the right image cannot be decoded");
  const cv::Mat image = cv::imread(path("png") + "/000002_left.png");
  EXPECT_EQ(image.cols, 320);
  EXPECT_EQ(image.rows, 240);
}

TEST_F(LogExport, McapHasItsMarks) {
  EXPECT_EQ(export_mcap(path("log"), path("log.mcap"), {}), 10);
  const std::string file = read_text_file(path("log.mcap"));
  const std::string magic("\x89MCAP0\r\n");
  EXPECT_TRUE(file.starts_with(magic) && file.ends_with(magic));
  EXPECT_NE(file.find("multireach.joint_setpoint_t"), std::string::npos);
}

}  // namespace
}  // namespace multireach
