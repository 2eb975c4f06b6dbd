// multireach-vision: stereo images in, targets out; or processes one pair of image files and exits.
#include <iostream>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "runtime/image_file.hpp"
#include "runtime/program.hpp"
#include "vision/node/vision_node.hpp"

namespace multireach {
namespace {

nlohmann::json vector(const auto& values) {
  return std::vector<double>(values.begin(), values.end());
}

const VisionConfig::Target& target_named(const VisionConfig& config, const std::string& name) {
  std::string names;
  for (const VisionConfig::Target& target : config.targets) {
    if (name.empty() || target.name == name) return target;
    names += " " + target.name;
  }
  throw InputError("--target-name: there is no target '" + name + "'; there are:" + names);
}

int answer_once(const VisionConfig& config, const std::vector<std::string>& pair, const std::string& name,
                const std::string& json_path) {
  const VisionConfig::Target& target = target_named(config, name);
  const cv::Mat left = read_image(pair[0]), right = read_image(pair[1]);
  const StereoRig& rig = config.rig;
  for (const auto& [image, camera, path] :
       {std::tuple(&left, &rig.left, pair[0]), std::tuple(&right, &rig.right, pair[1])}) {
    if (image->cols == camera->width && image->rows == camera->height) continue;
    throw InputError(path + ": is " + std::to_string(image->cols) + " x " + std::to_string(image->rows) +
                     " pixels; the calibration is for " + std::to_string(camera->width) + " x " +
                     std::to_string(camera->height));
  }
  vision::StereoTracker tracker(target.options);
  const vision::StereoMatch match = tracker.find(left, right);
  const bool seen = match.status == vision::StereoMatch::Status::kSeen;
  nlohmann::json answer{{"name", target.name},
                        {"status", seen ? "tracked" : "lost"},
                        {"reason", description(match.status)},
                        {"left_px", vector(match.left_px)},
                        {"right_px", vector(match.right_px)},
                        {"occlusion", match.occlusion}};
  if (seen) {
    const vision::Triangulation& point = match.point;
    answer["position_m"] = vector(point.p_W);
    for (int row = 0; row < 3; ++row) answer["covariance_m2"].push_back(vector(point.covariance.row(row)));
    answer["depth_m"] = point.depth_left_m;
    answer["epipolar_error_px"] = point.epipolar_error_px;
  }
  write_json_file(json_path, answer);
  return seen ? 0 : 1;
}

}  // namespace
}  // namespace multireach

int main(int argc, char** argv) {
  using namespace multireach;
  Program program("multireach-vision",
                  "Stereo colour tracking: STEREO_IMAGES in, TARGET out; or --pair, once, without LCM.");
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
    return run_live([&] { return std::make_unique<VisionNode>(config, 2); }, live);
  });
}
