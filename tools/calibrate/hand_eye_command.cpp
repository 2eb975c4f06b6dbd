#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "runtime/camera_files.hpp"
#include "runtime/program.hpp"
#include "runtime/robot_config.hpp"
#include "tools/calibrate/commands.hpp"
#include "tools/calibrate/hand_eye_output.hpp"
#include "tools/calibrate/hand_eye_samples.hpp"
#include "vision/node/vision_config.hpp"

namespace multireach {
namespace {

struct HandEyeArguments {
  std::string log, pairs, config, vision, output, json, offset = "0,0,0";
  LogChoice choice;
  double still_m = 0.002, target_sigma_m = 0.001, hand_sigma_m = 0.001;
};

HandEyeOptions options_of(const HandEyeArguments& arguments) {
  HandEyeOptions options{.hand_sigma_m = arguments.hand_sigma_m};
  options.estimate_offset = arguments.offset == "estimate";
  if (options.estimate_offset) return options;
  const std::vector<double> values = parse_numbers("--offset", arguments.offset);
  if (values.size() != 3 || !(std::hypot(values[0], values[1], values[2]) < 10))
    throw InputError("--offset is '" + arguments.offset + "'; expected x,y,z in metres, or estimate");
  options.p_HT = {values[0], values[1], values[2]};
  return options;
}

std::vector<HandEyeSample> samples_of(const HandEyeArguments& arguments) {
  if (arguments.log.empty() == arguments.pairs.empty()) throw InputError("hand-eye: give either --log or --pairs");
  if (!arguments.pairs.empty()) return samples_from_csv(arguments.pairs, arguments.target_sigma_m);
  if (arguments.config.empty() || arguments.vision.empty())
    throw InputError(
        "hand-eye: --log needs the robot's file (--robot) and the vision file that the log was made with (--vision)");
  const RobotConfig robot = RobotConfig::load(arguments.config);
  LogChoice choice = arguments.choice;
  choice.still_m = arguments.still_m;
  const VisionConfig vision = VisionConfig::load(arguments.vision);
  choice.rig = vision.rig;
  return samples_from_log(arguments.log, robot.chain, vision.calibrated ? std::optional(vision.rig.X_WL) : std::nullopt,
                          choice);
}

nlohmann::json list(const auto& values) {
  return std::vector<double>(values.begin(), values.end());
}

nlohmann::json json_of(const HandEye& result, const HandEyeOptions& options) {
  const Eigen::Matrix3d R = result.X_WL.linear();
  nlohmann::json json{{"translation_m", list(result.X_WL.translation().eval())},
                      {"rms_m", result.rms_m},
                      {"chi2_per_dof", result.chi2_per_dof},
                      {"measurements", result.outlier.size()},
                      {"measurements_used", std::ranges::count(result.outlier, false)},
                      {"distances_m", result.distances_m},
                      {"outlier", result.outlier},
                      {"offset_m", list(result.p_HT)},
                      {"offset_estimated", options.estimate_offset}};
  for (int row = 0; row < 3; ++row) json["rotation"].push_back(list(R.row(row)));
  // Rotation (rad, about W's axes), then translation (m, in W).
  for (int row = 0; row < 6; ++row) json["covariance"].push_back(list(result.covariance.row(row)));
  for (int row = 0; row < 3; ++row) json["offset_covariance_m2"].push_back(list(result.offset_covariance.row(row)));
  return json;
}

int hand_eye(const HandEyeArguments& arguments) {
  const HandEyeOptions options = options_of(arguments);
  const HandEye result = solve_hand_eye(samples_of(arguments), options);
  if (result.chi2_per_dof > 4) {
    spdlog::warn("the residuals are {:.1f} times what the covariances predict{}", std::sqrt(result.chi2_per_dof),
                 options.estimate_offset ? "" : "; is --offset wrong?");
  }
  const std::string summary = hand_eye_summary(result, options);
  write_text_file(arguments.output, hand_eye_text(result, options));
  if (!arguments.json.empty()) write_json_file(arguments.json, json_of(result, options));
  if (arguments.json != "-" && arguments.output != "-") write_text_file("-", summary);
  return 0;
}

}  // namespace

Command hand_eye_command(CommandLine& cli) {
  const auto arguments = std::make_shared<HandEyeArguments>();
  CommandLine app = cli.subcommand("hand-eye", "the left camera's pose in W, from a target in the robot's hand");
  app.option("--log", arguments->log, "log with TARGET and ROBOT_STATE; the hand stands still at each position");
  app.option("--robot", arguments->config, "with --log: robot.yaml or its folder");
  app.option("--vision", arguments->vision, "with --log: the vision file that it was made with");
  app.option("--target-name", arguments->choice.target, "with --log: the target's name, where it has several");
  app.option("--still", arguments->still_m, "with --log: largest motion of the hand during a standstill, m")
      .finite(1e-5, 1)
      .show_default();
  app.option("--pairs", arguments->pairs,
             "instead: CSV with seen_x_m,... (left camera's frame), hand_x_m,... (robot's base) [, hand_qw,..., "
             "sigma_m]");
  app.option("--target-sigma", arguments->target_sigma_m,
             "with --pairs: standard deviation of the target's coordinates, m, where there is no sigma_m")
      .finite(1e-6, 1)
      .show_default();
  app.option("--hand-sigma", arguments->hand_sigma_m, "standard deviation of the hand's coordinates, m")
      .finite(1e-6, 1)
      .show_default();
  app.option("--offset", arguments->offset, "x,y,z: the target in the hand's frame, m; or estimate").show_default();
  app.option("-o,--output", arguments->output, "left_to_robot, for a vision file").required();
  app.option("--json", arguments->json, "where to write all numbers, covariances too; - for standard output");
  return {app, [arguments] { return hand_eye(*arguments); }};
}

}  // namespace multireach
