#include "tools/replay/sweep.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <set>

#include "tests/input_fault.hpp"
#include "tests/temporary_folder.hpp"
#include "tools/log/run_report.hpp"
#include "tools/replay/request.hpp"

namespace multireach {
namespace {

using Json = nlohmann::ordered_json;

class Sweep : public ::testing::Test {
 protected:
  Sweep() {
    request_.session = MULTIREACH_SOURCE_DIR "/logs/reach.lcm";
    request_.setup.config = MULTIREACH_SOURCE_DIR "/robots/hoap2";
    request_.setup.vision = MULTIREACH_SOURCE_DIR "/robots/hoap2/vision.yaml";
    request_.until_s = 3;
  }

  SweepJob job(const std::vector<std::string>& set, int jobs = 1, const std::string& shard = "0/1") const {
    std::vector<SweptKey> keys;
    for (const std::string& text : set) keys.push_back(swept_key_from(text));
    return {SweepGrid(keys),
            [this](const ConfigOverrides& overrides) { return request_.options(ReplayFrom::kImages, overrides); },
            shard_from(shard), jobs};
  }
  Json sweep(const SweepJob& job, const std::string& shard) const {
    return {{"session", "reach.lcm"},
            {"combinations", job.grid.size()},
            {"shard", shard},
            {"rows", sweep_rows(job, nullptr)}};
  }
  std::string written(const std::string& name, const Json& json) const {
    write_text_file(folder_ / name, json.dump());
    return folder_ / name;
  }

  const std::vector<std::string> set_{"controller.gamma_rad2_m2=100,350", "tracker.sigma_px=0.1,0.5,1"};
  RunRequest request_;
  const testing::TemporaryFolder folder_;
};

TEST_F(Sweep, ValuesAreSplitAtCommasOutsideOfBracketsAndQuotes) {
  const SweptKey key = swept_key_from("robot.joint_jerk_limits=[1, 2],{a: [3, 4]},'5,6',7");
  EXPECT_EQ(key.key, "robot.joint_jerk_limits");
  EXPECT_EQ(key.values, (std::vector<std::string>{"[1, 2]", "{a: [3, 4]}", "'5,6'", "7"}));
  for (const char* wrong : {"a=1,", "a=,1", "a=1,,2"})
    EXPECT_NE(testing::input_fault([&] { swept_key_from(wrong); }).find("empty value"), std::string::npos) << wrong;
  EXPECT_NE(testing::input_fault([] { swept_key_from("a=1,2,1"); }).find("the value 1 twice"), std::string::npos);
}

TEST_F(Sweep, TheLastKeysValueChangesFastest) {
  const SweepGrid grid = job(set_).grid;
  ASSERT_EQ(grid.size(), 6);
  std::vector<std::string> values;
  for (int64_t k = 0; k < grid.size(); ++k)
    values.push_back(grid.overrides(k)[0].value + " " + grid.overrides(k)[1].value);
  EXPECT_EQ(values, (std::vector<std::string>{"100 0.1", "100 0.5", "100 1", "350 0.1", "350 0.5", "350 1"}));
  EXPECT_NE(testing::input_fault([&] { job({"a.b=1", "a.b=2"}); }).find("'a.b' is given twice"), std::string::npos);
  EXPECT_NE(testing::input_fault([&] { job({"a=1", "a.b=2"}); }).find("'a' is given twice"), std::string::npos);
  EXPECT_EQ(testing::input_fault([&] { job({"a=1", "ab=2"}); }), "");
  std::string many = "0";
  for (int i = 1; i < 101; ++i) many.append(",").append(std::to_string(i));
  EXPECT_NE(testing::input_fault([&] {
              job({"a=" + many, "b=" + many, "c=" + many});
            }).find("a million"),
            std::string::npos);
}

TEST_F(Sweep, WrongValuesAreFoundBeforeAnyReplay) {
  const auto said = [&](const std::string& text) { return testing::input_fault([&] { check_sweep(job({text})); }); };
  const std::string robot = MULTIREACH_SOURCE_DIR "/robots/hoap2/robot.yaml";
  EXPECT_EQ(said("controller.alpha_per_step=0.08,-1"),
            robot +
                ": key 'controller.alpha_per_step' is '-1'; expected a number from 1e-06 to 1, with --set "
                "controller.alpha_per_step=-1");
  EXPECT_NE(said("controller.alpha_per_step=0.08,0.05").find("alpha is too small for beta"), std::string::npos);
  EXPECT_NE(said("tracker.agile_m2_s3=5,10").find("key 'tracker.agile_m2_s3' is not known"), std::string::npos);
  EXPECT_NE(said("tracker.max_process_noise_m2_s3=5,x").find("'tracker.max_process_noise_m2_s3' is 'x'; expected"),
            std::string::npos);
  EXPECT_NE(said("gamma=5").find("'gamma' is no key of a replay"), std::string::npos);
  EXPECT_NE(said("robot_sim.x=5").find("--robot-model sim"), std::string::npos);
  EXPECT_NE(said("bridge.delay_ms=5,900").find("three times tick_ms"), std::string::npos);
  request_.session = "nowhere.lcm";
  EXPECT_EQ(said(set_[0]), "") << "the session is not read";
  EXPECT_NE(testing::input_fault([&] { sweep_rows(job({set_[0]}, 2), nullptr); }).find("nowhere.lcm"),
            std::string::npos);
}

TEST_F(Sweep, IsTheSameWithAnyNumberOfJobsAndShards) {
  const Json one = sweep(job(set_), "0/1");
  ASSERT_EQ(one["rows"].size(), 6U);
  for (const int jobs : {3, 16}) EXPECT_EQ(sweep(job(set_, jobs), "0/1").dump(), one.dump()) << jobs;
  std::vector<std::string> parts;
  for (const char* shard : {"3/4", "1/4", "0/4", "2/4"})
    parts.push_back(written(std::to_string(parts.size()), sweep(job(set_, 2, shard), shard)));
  const Json merged = merged_sweep(parts);
  EXPECT_EQ(merged.dump(), one.dump());
  const std::string table = sweep_table(one);
  EXPECT_EQ(sweep_table(merged), table);
  EXPECT_TRUE(table.starts_with("index,controller.gamma_rad2_m2,tracker.sigma_px,succeeded,reaches,"));
  EXPECT_EQ(std::ranges::count(table, '\n'), 7);
  std::set<std::string> digests;
  for (const Json& row : one["rows"]) digests.insert(row["figures"]["digest"].get<std::string>());
  EXPECT_EQ(digests.size(), 6U) << "the values matter";

  const auto said = [&](const std::vector<std::string>& paths) {
    return testing::input_fault([&] { merged_sweep(paths); });
  };
  EXPECT_NE(said({parts[0], parts[1]}).find("only 2 of the 4 shards"), std::string::npos);
  EXPECT_NE(said({parts[0], parts[0]}).find("shard 3 once more"), std::string::npos);
  EXPECT_NE(said({written("one", one)}).find("is a whole sweep"), std::string::npos);
  Json other = Json::parse(read_text_file(parts[1]));
  other["session"] = "other.lcm";
  EXPECT_NE(said({parts[0], written("other", other)}).find("is of another sweep"), std::string::npos);
  Json short_one = Json::parse(read_text_file(parts[1]));
  short_one["rows"].erase(0);
  EXPECT_NE(said({written("short", short_one)}).find("is missing"), std::string::npos);
  for (const char* text : {"", "{}", "[]", R"({"rows": 1, "shard": "0/2", "combinations": 3})"}) {
    write_text_file(folder_ / "wrong", text);
    EXPECT_NE(said({folder_ / "wrong"}), "") << text;
  }
}

/// A row holds what `run` and `multireach-log report` give for files with these values.
TEST_F(Sweep, ARowIsTheReportOnARunWithTheseValuesInTheFiles) {
  request_.until_s = 7;
  const Json rows = sweep_rows(job({"controller.alpha_per_step=0.12,0.08", "tick_ms=25,50"}, 2), nullptr);
  std::string text = read_text_file(MULTIREACH_SOURCE_DIR "/robots/hoap2/robot.yaml");
  const auto put = [&](const std::string& old_text, const std::string& new_text) {
    const size_t at = text.find(old_text);
    ASSERT_NE(at, std::string::npos) << old_text;
    text.replace(at, old_text.size(), new_text);
  };
  put("alpha_per_step: 0.08", "alpha_per_step: 0.12");
  put("urdf: ", "urdf: " MULTIREACH_SOURCE_DIR "/robots/hoap2/");
  write_text_file(folder_ / "robot.yaml", text);  // whose tick_ms is 50
  RunRequest request = request_;
  request.setup.config = folder_.path();
  const ReplayOptions options = request.options(ReplayFrom::kImages, {});
  ASSERT_EQ(options.config.tick_us, 50000);
  LogWriter log(folder_ / "run.lcm");
  const int64_t origin = Session(options.session, options.from, false).recorded_utime();
  const ReplayResult result = replay(
      options,
      [&](int64_t at, std::string_view channel, std::span<const uint8_t> bytes, bool) {
        log.write(origin + at, channel, bytes);
      },
      nullptr);
  log.close();
  const nlohmann::json report = report_on(folder_ / "run.lcm", options.config).json;
  const Json& row = rows.at(1);
  EXPECT_EQ(row["index"], 1);
  EXPECT_EQ(row["set"], (Json{{"controller.alpha_per_step", "0.12"}, {"tick_ms", "50"}}));
  const Json& figures = row["figures"];
  char digest[20];
  std::snprintf(digest, sizeof digest, "%016llx", static_cast<unsigned long long>(result.digest));
  EXPECT_EQ(figures["digest"], digest);
  for (const char* key : {"targets", "setpoints", "commands", "max_command_speed_share", "max_command_jerk_share"})
    EXPECT_EQ(Json(report[key]), figures[key]) << key;
  EXPECT_EQ(figures["vision_error_mm_p95"], Json(report["vision_error_mm"]["p95"]));
  ASSERT_EQ(report["reaches"].size(), 2U);
  EXPECT_EQ(figures["reaches"], 2);
  double worst = 0;
  for (const auto& reach : report["reaches"]) worst = std::max(worst, reach["hand_error_mm"].get<double>());
  EXPECT_EQ(figures["hand_error_mm_max"], worst);
  EXPECT_NE(rows.at(3)["figures"]["digest"], figures["digest"]);
}

}  // namespace
}  // namespace multireach
