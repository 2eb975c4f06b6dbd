#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <array>
#include <memory>
#include <nlohmann/json.hpp>

#include "runtime/files.hpp"
#include "runtime/image_file.hpp"
#include "runtime/program.hpp"
#include "runtime/progress.hpp"
#include "tools/calibrate/board_images.hpp"
#include "tools/calibrate/calibration_errors.hpp"
#include "tools/calibrate/camera_output.hpp"
#include "tools/calibrate/commands.hpp"
#include "tools/calibrate/reprojection_picture.hpp"

namespace multireach {
namespace {

struct CamerasOptions {
  std::string left, right, pattern, lens, picture, json;
  double square_m = 0, square_sigma_m = 0;
  bool leave_out_poor = false, leave_one_out = false;
  CameraOutput output;
};

Lens lens_of(const CamerasOptions& options) {
  const CameraFormat format = options.output.format();
  if (options.lens.empty()) return format == CameraFormat::kKalibr ? Lens::kRadtan : Lens::kPlumbBob;
  if (format == CameraFormat::kKalibr && options.lens != "radtan")
    throw InputError("--lens " + options.lens + ": Kalibr's files have radtan only");
  return options.lens == "radtan" ? Lens::kRadtan : options.lens == "rational" ? Lens::kRational : Lens::kPlumbBob;
}

constexpr const char* kContradiction =
    "the two images of the pairs fit each other far worse than the images of each camera alone: the board or the "
    "cameras moved between the two exposures; take the pairs again with the board held still, or with synchronised "
    "cameras";
constexpr std::array kDistances{0.5, 1.0, 2.0};  // m, for the report

nlohmann::json errors_json(const StereoRig& rig, double view_factor) {
  constexpr int kCount = RigErrors::kCount;
  const Eigen::Matrix<double, kCount, 1> sigma = rig.errors.covariance.diagonal().cwiseSqrt();
  const Eigen::Matrix<double, kCount, kCount> correlation =
      sigma.cwiseInverse().asDiagonal() * rig.errors.covariance * sigma.cwiseInverse().asDiagonal();
  nlohmann::json json{{"focal_length_relative", sigma[RigErrors::kFocalLength]},
                      {"baseline_relative", sigma[RigErrors::kBaseline]},
                      {"rotation_rad", {sigma[2], sigma[3], sigma[4]}},
                      {"view_factor", view_factor}};
  for (int row = 0; row < kCount; ++row) {
    const Eigen::Matrix<double, 1, kCount> values = correlation.row(row);
    json["correlation"].push_back(std::vector<double>(values.begin(), values.end()));
  }
  for (const double distance_m : kDistances)
    json["positions"].push_back({{"distance_m", distance_m}, {"sigma_m", axial_sigma_m(rig, distance_m)}});
  return json;
}

nlohmann::json result_json(const BoardImages& images, const StereoCalibration& calibration,
                           const std::vector<double>& left_out) {
  nlohmann::json json{{"stereo_rms_px", calibration.stereo_rms_px},
                      {"left_rms_px", calibration.left_rms_px},
                      {"right_rms_px", calibration.right_rms_px},
                      {"left_fx_sigma_px", calibration.left_fx_sigma_px},
                      {"right_fx_sigma_px", calibration.right_fx_sigma_px},
                      {"baseline_m", calibration.rig.baseline_m()},
                      {"width_px", images.size.width},
                      {"height_px", images.size.height},
                      {"pairs_given", images.left_files.size()},
                      {"views", nlohmann::json::array()},
                      {"complaints", images.warnings}};
  if (calibration.pairs_contradict()) json["complaints"].push_back(kContradiction);
  int64_t used = 0;
  std::vector<Corners> left, right;
  for (size_t k = 0; k < images.pairs.size(); ++k) {
    const PairFit& fit = calibration.fits[k];
    json["views"].push_back({{"left", images.left_files[images.pair_index[k]]},
                             {"right", images.right_files[images.pair_index[k]]},
                             {"left_rms_px", fit.left_rms_px},
                             {"right_rms_px", fit.right_rms_px},
                             {"poor", fit.poor},
                             {"used", fit.used}});
    if (!fit.used) continue;
    ++used;
    left.push_back(images.pairs[k].left);
    right.push_back(images.pairs[k].right);
  }
  json["pairs_used"] = used;
  json["left_coverage"] = coverage(left, images.size);
  json["right_coverage"] = coverage(right, images.size);
  if (!left_out.empty()) {
    json["leave_one_out"] = {{"median_squares", left_out[left_out.size() / 2]},
                             {"p95_squares", left_out[left_out.size() * 95 / 100]},
                             {"max_squares", left_out.back()},
                             {"corners", left_out.size()}};
  }
  return json;
}

void warn_about_fit(const BoardImages& images, const StereoCalibration& calibration) {
  if (calibration.pairs_contradict()) spdlog::warn("{}", kContradiction);
  for (size_t k = 0; k < images.pairs.size(); ++k) {
    const PairFit& fit = calibration.fits[k];
    if (!fit.poor) continue;
    spdlog::warn("{} and {}: fit far worse than the others ({:.2f} px){}", images.left_files[images.pair_index[k]],
                 images.right_files[images.pair_index[k]], fit.rms_px(),
                 fit.used ? "; leave them out with --leave-out-poor" : "; left out");
  }
  const auto warn_if_uncertain = [](double sigma, double fx, const char* side) {
    if (sigma > 0.01 * fx)
      spdlog::warn("the {} camera's focal length is known to {:.1f} % only: tilt the board more", side,
                   100 * sigma / fx);
  };
  warn_if_uncertain(calibration.left_fx_sigma_px, calibration.rig.left.fx, "left");
  warn_if_uncertain(calibration.right_fx_sigma_px, calibration.rig.right.fx, "right");
}

std::string table_of(const nlohmann::json& json) {
  std::string text = fmt::format(
      "pairs used      {} of {}\nstereo rms      {:.4f} px (left alone {:.4f}, right alone {:.4f})\nbaseline        "
      "{:.3f} "
      "mm\nfields covered  left {:.0f} %, right {:.0f} %\n",
      json["pairs_used"].get<int>(), json["pairs_given"].get<int>(), json["stereo_rms_px"].get<double>(),
      json["left_rms_px"].get<double>(), json["right_rms_px"].get<double>(), 1e3 * json["baseline_m"].get<double>(),
      100 * json["left_coverage"].get<double>(), 100 * json["right_coverage"].get<double>());
  const nlohmann::json& positions = json["errors"]["positions"];
  const auto millimetres = [&](size_t k) { return 1e3 * positions[k]["sigma_m"].get<double>(); };
  text += fmt::format(
      "positions       at 0.5 m, 1 m and 2 m this calibration leaves errors of {:.2g}, {:.2g} and {:.2g} mm (standard "
      "deviations)\n",
      millimetres(0), millimetres(1), millimetres(2));
  if (json.contains("leave_one_out")) {
    const nlohmann::json& out = json["leave_one_out"];
    text += fmt::format("left-out boards median {:.4f}, 95 % {:.4f}, max {:.4f} squares\n",
                        out["median_squares"].get<double>(), out["p95_squares"].get<double>(),
                        out["max_squares"].get<double>());
  }
  return text;
}

int calibrate_cameras(const CamerasOptions& options) {
  const auto [columns, rows] = parse_size("--pattern", options.pattern, 3, 50);
  const Board board{columns, rows, options.square_m};
  const Lens lens = lens_of(options);
  const double square_sigma = options.square_sigma_m / options.square_m;
  constexpr double kMostSigma = 0.1;  // largest relative error of a baseline that a vision file may have
  if (square_sigma > kMostSigma)
    throw InputError("--square-sigma: at most a tenth of --square; measure the board over many squares");
  options.output.check();
  for (const std::string& path : {options.picture, options.json}) check_writable(path);

  // Approximate shares of the run time, for the progress line.
  const double finding = options.leave_one_out ? 0.3 : 0.7, calibrating = 0.9 * (1 - finding);
  Progress progress;
  const BoardImages images =
      find_boards(options.left, options.right, board, [&](double part) { progress.show(finding * part); });
  progress.end();
  if (!images.pairs.empty()) {
    for (const std::string& sentence : images.warnings) spdlog::warn("{}", sentence);
  }
  if (images.pairs.size() < 3) {
    throw std::runtime_error(
        fmt::format("of {} pairs, {} show the whole board in both images; at least 3 must. --pattern {} counts inner "
                    "corners, where "
                    "four squares meet: a board of 10 x 7 squares is 9x6",
                    images.left_files.size(), images.pairs.size(), options.pattern));
  }
  progress.show(finding);
  StereoCalibration calibration = calibrate(images.pairs, board, images.size, lens, options.leave_out_poor);
  calibration.rig.errors.covariance(RigErrors::kBaseline, RigErrors::kBaseline) += square_sigma * square_sigma;
  std::vector<double> left_out;
  if (options.leave_one_out) {
    left_out = leave_one_out(images.pairs, board, images.size, lens, calibration,
                             [&](double part) { progress.show(1 - calibrating * (1 - part)); });
  }
  progress.end();
  check_rig(calibration.rig, "--left, --right");
  warn_about_fit(images, calibration);

  nlohmann::json json = result_json(images, calibration, left_out);
  json["errors"] = errors_json(calibration.rig, errors_of(calibration, board, lens).view_factor);
  if (!options.picture.empty()) {
    const std::vector<uint8_t> png = encode_png(reprojection_picture(images.pairs, calibration, images.size));
    OutputFile file(options.picture);
    file.write(png);
    file.finish();
  }
  if (!options.json.empty()) write_json_file(options.json, json);
  options.output.write(calibration.rig, false);
  if (options.json != "-") write_text_file("-", table_of(json));
  return 0;
}

}  // namespace

Command cameras_command(CommandLine& cli) {
  const auto options = std::make_shared<CamerasOptions>();
  CommandLine app = cli.subcommand("cameras", "two cameras from pairs of photographs of a chessboard");
  app.option("--left", options->left, "the left camera's photographs: folder, or pattern in quotes").required();
  app.option("--right", options->right, "the right camera's, paired in the order of their names").required();
  app.option("--pattern", options->pattern, "COLUMNSxROWS of inner corners, as 9x6").required();
  app.option("--square", options->square_m, "side of a square, m, as 0.025").required().finite(1e-5, 1);
  app.option("--square-sigma", options->square_sigma_m,
             "standard deviation of this side, m, as 0.00005: how well all squares together are measured")
      .finite(0, 0.1)
      .show_default();
  app.option("--lens", options->lens,
             "distortion: radtan (k1 k2 p1 p2), plumb_bob (and k3; default except Kalibr) or rational (k1 to k6)")
      .one_of({"radtan", "plumb_bob", "rational"});
  app.flag("--leave-out-poor", options->leave_out_poor, "do not use pairs that fit far worse than the others");
  app.flag("--leave-one-out", options->leave_one_out,
           "cross-validate: calibrate without each pair in turn and measure its board");
  app.option("--picture", options->picture, "PNG of all corners and their residuals");
  app.option("--json", options->json, "where to write numbers for each pair; - for standard output");
  options->output.add_options(app);
  return {app, [options] { return calibrate_cameras(*options); }};
}

}  // namespace multireach
