// multireach-vision: stereo images in, targets out; or processes one pair of image files and exits.
#include <iostream>
#include <multireach/images_t.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "imaging/image_codec.hpp"
#include "imaging/jpeg_decoder.hpp"
#include "runtime/channels.hpp"
#include "runtime/image_file.hpp"
#include "runtime/program.hpp"
#include "vision/node/vision_node.hpp"
#include "vision/reported_covariance.hpp"

namespace multireach {
namespace {

nlohmann::json vector(const auto& values) {
  return std::vector<double>(values.begin(), values.end());
}

/// Which of the targets has this name, the tags after the coloured ones; the first for no name.
size_t target_named(const VisionConfig& config, const std::string& name) {
  std::vector<std::string> names;
  for (const VisionConfig::Target& target : config.targets) names.push_back(target.name);
  for (const VisionConfig::Tag& tag : config.tags) names.push_back(tag.name);
  const auto at = name.empty() ? names.begin() : std::ranges::find(names, name);
  if (at != names.end()) return static_cast<size_t>(at - names.begin());
  std::string list;
  for (const std::string& each : names) list += " " + each;
  throw InputError("--target-name: there is no target '" + name + "'; there are:" + list);
}

nlohmann::json rows_of(const Eigen::Matrix3d& matrix) {
  nlohmann::json rows;
  for (int row = 0; row < 3; ++row) rows.push_back(vector(matrix.row(row)));
  return rows;
}

/// Things that could be the target, best first, as in TARGET_CANDIDATES.
nlohmann::json rows_of(const std::vector<vision::Candidate>& candidates) {
  nlohmann::json rows = nlohmann::json::array();
  for (const vision::Candidate& candidate : candidates) {
    rows.push_back({{"left_px", vector(candidate.match.left_px)},
                    {"right_px", vector(candidate.match.right_px)},
                    {"position_m", vector(candidate.match.point.p_W)},
                    {"score", candidate.evidence.sum()},
                    {"reason", candidate.reason}});
  }
  return rows;
}

nlohmann::json coloured_answer(const VisionConfig::Target& target, const cv::Mat& left, const cv::Mat& right,
                               bool chroma_subsampled) {
  vision::StereoTracker tracker(target.options);
  const vision::TargetMatch found = tracker.find(left, right, chroma_subsampled);
  const vision::StereoMatch& match = found.match;
  using Status = vision::StereoMatch::Status;
  const bool seen = match.status == Status::kSeen;
  nlohmann::json answer{{"name", target.name},
                        {"status", seen                                 ? "tracked"
                                   : match.status == Status::kAmbiguous ? "ambiguous"
                                                                        : "lost"},
                        {"reason", seen ? description_of_seen(match, target.options.match) : description(match.status)},
                        {"left_px", vector(match.left_px)},
                        {"right_px", vector(match.right_px)},
                        {"occlusion", match.occlusion}};
  if (seen) {
    answer["position_m"] = vector(match.point.p_W);
    answer["covariance_m2"] =
        rows_of(vision::reported_covariance(target.options.rig, {match.point.p_W, match.covariance()}));
    answer["depth_m"] = match.point.depth_left_m;
    answer["epipolar_error_px"] = match.point.epipolar_error_px;
  }
  if (found.candidates.size() > 1) answer["candidates"] = rows_of(found.candidates);
  return answer;
}

nlohmann::json tag_answer(const VisionConfig::Tag& tag, const cv::Mat& left, const cv::Mat& right) {
  vision::TagVision stage({tag.options});
  vision::DecodedImages images({}, left, right);
  const char* fault = stage.update(images);
  const vision::TagVision::Target& target = stage.targets().front();
  const vision::TagReport& report = target.report;
  const bool seen = report.status == vision::TargetTrack::Status::kTracked;
  nlohmann::json answer{{"name", tag.name},
                        {"status", seen ? "tracked" : "lost"},
                        {"reason", fault ? fault : report.reason},
                        {"left_px", vector(target.match.centre_px[0])},
                        {"right_px", vector(target.match.centre_px[1])}};
  if (seen) {
    answer["position_m"] = vector(report.estimate.position);
    answer["covariance_m2"] = rows_of(report.estimate.covariance);
    answer["epipolar_error_px"] = target.match.epipolar_error_px;
    if (const auto& q = report.R_WT) {
      answer["orientation_wxyz"] = {q->w(), q->x(), q->y(), q->z()};
      answer["orientation_covariance_rad2"] = rows_of(report.orientation_covariance);
    }
  }
  return answer;
}

int answer_once(const VisionConfig& config, const std::vector<std::string>& pair, const std::string& name,
                const std::string& json_path) {
  const size_t target = target_named(config, name), coloured = config.targets.size();
  const cv::Mat left = read_image(pair[0]), right = read_image(pair[1]);
  const bool subsampled =
      std::ranges::any_of(pair, [](const std::string& path) { return jpeg_chroma_subsampled(read_binary_file(path)); });
  const StereoRig& rig = config.rig;
  for (const auto& [image, camera, path] :
       {std::tuple(&left, &rig.left, pair[0]), std::tuple(&right, &rig.right, pair[1])}) {
    if (image->cols == camera->width && image->rows == camera->height) continue;
    throw InputError(path + ": is " + std::to_string(image->cols) + " x " + std::to_string(image->rows) +
                     " pixels; the calibration is for " + std::to_string(camera->width) + " x " +
                     std::to_string(camera->height));
  }
  if (left.size() == right.size() && cv::norm(left, right, cv::NORM_INF) == 0)
    throw InputError("--pair: " + pair[0] + " and " + pair[1] + " are the same image");
  nlohmann::json answer = target < coloured ? coloured_answer(config.targets[target], left, right, subsampled)
                                            : tag_answer(config.tags[target - coloured], left, right);
  if (!config.calibrated) answer["frame"] = "left camera";  // the camera pose is unknown
  write_json_file(json_path, answer);
  return answer["status"] == "tracked" ? 0 : 1;
}

/// The first pair that a process sees takes several times as long as the others, since code and memory are touched for
/// the first time: the first target, and with it the first set-point, would come late. A node of its own sees a
/// chessboard before.
void warm_up(const VisionConfig& config) {
  constexpr int kSquarePx = 32;
  ImageCodec codec;
  images_t pair{.utime = 0, .n_images = 2, .image_types = {images_t::LEFT, images_t::RIGHT}, .images = {}};
  for (const CameraModel* camera : {&config.rig.left, &config.rig.right}) {
    cv::Mat board(camera->height, camera->width, CV_8UC3);
    for (int y = 0; y < board.rows; ++y) {
      for (int x = 0; x < board.cols; ++x)
        board.at<cv::Vec3b>(y, x) = cv::Vec3b::all((x / kSquarePx + y / kSquarePx) % 2 == 0 ? 230 : 20);
    }
    image_t image{};
    image.width = board.cols;
    image.height = board.rows;
    image.pixelformat = image_t::PIXEL_FORMAT_MJPEG;
    image.data = codec.encode_jpeg(board, 85);
    image.size = static_cast<int32_t>(image.data.size());
    pair.images.push_back(std::move(image));
  }
  VisionNode node(config, 2);
  Outbox out;
  if (const auto bytes = encode(pair)) node.receive(channel::kStereoImages, *bytes, out);
}

}  // namespace
}  // namespace multireach

int main(int argc, char** argv) {
  using namespace multireach;
  Program program(
      "multireach-vision",
      "Stereo tracking of coloured objects and tags: STEREO_IMAGES in, TARGET out; or --pair, once, without LCM.");
  std::string config_path, target, json = "-";
  std::vector<std::string> pair;
  program.cli()
      .option("--config", config_path, "vision.yaml: cameras and targets, as robots/hoap2/vision.yaml")
      .required();
  program.cli().option("--pair", pair, "answer once for a LEFT and a RIGHT image file").values(2, "LEFT RIGHT");
  program.cli().option("--target-name", target, "with --pair: which of several targets; default the first");
  program.cli().option("--json", json, "with --pair: where to write the answer; - for standard output").show_default();
  const LiveOptions& live = program.add_live_options();
  program.add_config_reference(vision_config_reference);
  return program.run(argc, argv, [&] {
    cv::setNumThreads(1);  // for identical output on every machine
    const VisionConfig config = VisionConfig::load(config_path);
    if (!pair.empty()) return answer_once(config, pair, target, json);
    warm_up(config);
    return run_live([&] { return std::make_unique<VisionNode>(config, 2); }, live);
  });
}
