#include "tools/figures/protocol_scenes.hpp"

#include <gtest/gtest.h>

#include <map>
#include <sstream>

#include "tests/test_arms.hpp"

namespace multireach {
namespace {

/// The rows of a table by the law in their first column, each by the names of its columns.
std::map<int, std::map<std::string, double>> rows_of(const Table& table) {
  std::istringstream lines(table.csv());
  std::string line, cell;
  std::getline(lines, line);
  std::vector<std::string> names;
  for (std::istringstream header(line); std::getline(header, cell, ',');) names.push_back(cell);
  std::map<int, std::map<std::string, double>> rows;
  while (std::getline(lines, line)) {
    std::map<std::string, double> row;
    size_t column = 0;
    for (std::istringstream cells(line); std::getline(cells, cell, ',');) row[names.at(column++)] = std::stod(cell);
    rows[static_cast<int>(row.at("law"))] = row;
  }
  return rows;
}

TEST(ProtocolScenes, TheDefaultLawArrivesInsideTheLimitsInOneStroke) {
  for (const auto& file : testing::all_arm_files()) {
    if (file.tip != "right_hand" && file.tip != "panda_hand" && file.tip != "iiwa_link_ee") continue;
    auto rows = rows_of(protocol_reaches_measures_scene(testing::load(file)));
    ASSERT_TRUE(rows.contains(0) && rows.contains(-1)) << file.path;
    EXPECT_EQ(rows[0]["reaches"], 20) << file.path;
    EXPECT_LT(rows[0]["error_max"], 1e-9) << file.path;
    EXPECT_LT(rows[0]["path_ratio_max"], 1.03) << file.path;
    EXPECT_EQ(rows[0]["speed_peaks_max"], 1) << file.path;
    EXPECT_EQ(rows[0]["limit_excess"], 0) << file.path;
    EXPECT_LE(rows[0]["speed_part"], 1 + 1e-9) << file.path;
    EXPECT_EQ(rows[-1]["path_ratio_max"], 1) << file.path;
    EXPECT_GT(rows[0]["normalised_jerk_p50"], rows[-1]["normalised_jerk_p50"]) << file.path;
    if (!rows.contains(4)) continue;
    EXPECT_LT(rows[4]["turned_max"], 1e-6) << file.path;
  }
}

TEST(ProtocolScenes, AnArmThatDoesNotReachThePointsIsRefused) {
  std::vector<Joint> joints = testing::hoap2().joints();
  for (Joint& joint : joints) joint.lower = joint.upper = 0.5 * (joint.lower + joint.upper);
  const Chain arm = testing::hoap2();
  std::vector<Eigen::Isometry3d> fixed;
  for (int i = 0; i <= arm.size(); ++i) fixed.push_back(arm.fixed(i));
  EXPECT_THROW(protocol_reaches_scene(Chain(joints, fixed, "torso", "right_hand")), std::invalid_argument);
}

}  // namespace
}  // namespace multireach
