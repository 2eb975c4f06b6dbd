#include "vision/node/vision_config.hpp"

#include <set>
#include <stdexcept>

#include "runtime/config.hpp"
#include "runtime/digest.hpp"
#include "runtime/files.hpp"
#include "runtime/rig_config.hpp"
#include "vision/node/colour_config.hpp"

namespace multireach {
namespace {

/// The tracker's options of one target: `colour`, `rig`, and all other keys except `name` from `keys`.
vision::TrackerOptions tracker_options_from(const Config& keys, const ColourConfig& colour, const StereoRig& rig) {
  vision::TrackerOptions options;
  options.rig = rig;
  options.colour = colour.models;
  vision::MatchOptions& match = options.match;
  match.radius_m = keys.number("ball_radius_m", 0, 10, match.radius_m);
  match.radius_tolerance_m = keys.number("ball_radius_tolerance_m", 0, 10, match.radius_tolerance_m);
  match.max_epipolar_px = keys.number("max_epipolar_px", 1e-6, 1e6, match.max_epipolar_px);
  match.max_occlusion = keys.number("max_occlusion", 0.01, 1, match.max_occlusion);
  options.sigma_px = keys.number("sigma_px", 0, 1000, options.sigma_px);
  options.min_area_px = keys.number("min_area_px", 1, 1e9, options.min_area_px);
  options.adapt_colour = keys.flag("adapt_colour", options.adapt_colour);
  vision::TargetTrack::Options& track = options.track;
  track.coast_s = keys.number("coast_s", 0, 1e3, track.coast_s);
  track.coast_sigma_m = keys.number("coast_sigma_m", 1e-6, 1e3, track.coast_sigma_m);
  track.confirmations = static_cast<int>(keys.integer("confirmations", 1, 1000, track.confirmations));
  track.max_process_noise_m2_s3 =
      keys.number("max_process_noise_m2_s3", track.coasting_process_noise_m2_s3, 1e6, track.max_process_noise_m2_s3);
  return options;
}

VisionConfig::Target target_from(const Config& keys, const Config& colour_keys, const std::string& otherwise,
                                 const StereoRig& rig, std::string& files) {
  const ColourConfig colour = colour_config_from(colour_keys);
  files += colour.file;
  VisionConfig::Target target{keys.text("name", otherwise), tracker_options_from(keys, colour, rig)};
  if (target.name.empty()) keys.fail("name", "a name");
  return target;
}

}  // namespace

VisionConfig VisionConfig::load(const std::string& path) {
  const Config file = Config::load(path);
  VisionConfig vision;
  const RigConfig cameras = load_rig(file.section("cameras"));
  vision.rig = cameras.rig;
  std::string files = cameras.files;
  if (file.has("targets")) {
    std::set<std::string> names;
    for (const Config& section : file.sections("targets")) {
      vision.targets.push_back(target_from(section, section.section("colour"), "", vision.rig, files));
      if (!names.insert(vision.targets.back().name).second) section.fail("name", "another name than the targets above");
      section.finish();
    }
    if (vision.targets.empty()) file.fail("targets", "at least one target");
  } else {
    const Config keys = file.has("tracker") ? file.section("tracker") : Config::parse(path, "{}");
    const std::string name = keys.text("target_name", "target");
    vision.targets.push_back(target_from(keys, file.section("colour"), name, vision.rig, files));
    keys.finish();
  }
  file.finish();
  vision.digest = digest_of(read_text_file(path) + files);
  for (const Target& target : vision.targets) {
    try {
      const vision::StereoTracker check(target.options);
    } catch (const std::invalid_argument& fault) {
      throw InputError(path + ": " + fault.what());
    }
  }
  return vision;
}

}  // namespace multireach
