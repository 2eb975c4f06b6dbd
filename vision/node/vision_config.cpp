#include "vision/node/vision_config.hpp"

#include <set>
#include <stdexcept>

#include "runtime/config.hpp"
#include "runtime/config_keys.hpp"
#include "runtime/digest.hpp"
#include "runtime/files.hpp"
#include "runtime/rig_config.hpp"
#include "vision/node/colour_config.hpp"

namespace multireach {
namespace {

/// What the section of one target says.
struct TrackerSection {
  std::string name{};
  vision::TrackerOptions options{};
};

/// What the section of one target that is a tag says.
struct TagSection {
  std::string name{};
  vision::TagOptions options{};
};

/// Declares the keys of the track, which coloured objects and tags share. `on_bounces`: a sentence on them, or empty.
template <class Section>
void add_track_keys(ConfigKeys<Section>& keys, const std::string& on_bounces) {
  keys.number(
          "coast_s", "s", 0, 1e3, [](auto& s) -> auto& { return s.options.track.coast_s; },
          "Longest time without a match before the target is lost.")
      .number(
          "coast_sigma_m", "m", 1e-6, 1e3, [](auto& s) -> auto& { return s.options.track.coast_sigma_m; },
          "The target is lost when √tr(Σ) of its predicted position, without the bias of centroids, exceeds this.")
      .integer(
          "confirmations", "", 1, 1000, [](auto& s) -> auto& { return s.options.track.confirmations; },
          "Consecutive matches that confirm a jump; one less, but at least two, for one that the target's speed allows "
          "(docs/vision.md)." +
              on_bounces)
      .number(
          "max_process_noise_m2_s3", "m²/s³", vision::TargetTrack::Options{}.coasting_process_noise_m2_s3, 1e6,
          [](auto& s) -> auto& { return s.options.track.max_process_noise_m2_s3; },
          "Largest spectral density of the target's acceleration; the default suits a thrown ball.");
}

void read_search_region(const Config& config, vision::TrackerOptions& options) {
  if (!config.has("search_region_m")) return;
  const Config section = config.section("search_region_m");
  const auto corner = [&](const char* key) { return Eigen::Vector3d(section.numbers(key, 3).data()); };
  const Eigen::Vector3d min = corner("min"), max = corner("max");
  if (!(min.array() < max.array()).all()) section.fail("max", "three numbers, each larger than that of 'min'");
  section.finish();
  options.search_region = vision::SearchRegion(min, max);
}

ConfigKeys<TrackerSection> tracker_keys(bool several) {
  ConfigKeys<TrackerSection> keys("vision.yaml, sections tracker and targets",
                                  "How a target is tracked. For several targets, `targets` is a list of such sections, "
                                  "each with `name` and `colour`, or with `name` and `tag` (see below).");
  if (several) {
    keys.text(
            "name", [](auto& s) -> auto& { return s.name; }, "The target's name.")
        .required();
    keys.other("colour", "section", "", "required", "Its colours.",
               [](const Config& config, auto&) { config.has("colour"); });
  } else {
    keys.text(
            "target_name", [](auto& s) -> auto& { return s.name; }, "In `tracker`: the target's name.")
        .otherwise("`target`");
  }
  keys.number(
          "ball_radius_m", "m", 0, 10, [](auto& s) -> auto& { return s.options.match.radius_m; },
          "Radius of the ball; 0 where it is unknown or the object is no ball.")
      .number(
          "ball_radius_tolerance_m", "m", 0, 10, [](auto& s) -> auto& { return s.options.match.radius_tolerance_m; },
          "Standard deviation of `ball_radius_m`.")
      .number(
          "max_epipolar_px", "pixels", 1e-6, 1e6, [](auto& s) -> auto& { return s.options.match.max_epipolar_px; },
          "Largest epipolar error of a match, in addition to three standard deviations.")
      .number(
          "max_size_ratio", "", 1.0001, 100, [](auto& s) -> auto& { return s.options.match.max_size_ratio; },
          "Largest ratio of the radii that the two images give, in addition to their errors. After a bounce, the "
          "radius may differ from that before by the square of this ratio.")
      .number(
          "max_occlusion", "", 0.01, 1, [](auto& s) -> auto& { return s.options.match.max_occlusion; },
          "Largest share of the target's area that may be occluded or beyond the image's border.")
      .number(
          "max_prediction_sigmas", "", 0.1, 100, [](auto& s) -> auto& { return s.options.match.max_prediction_sigmas; },
          "Largest distance of a match from the predicted position, in standard deviations of both; beyond, it is a "
          "jump.")
      .number(
          "sigma_px", "pixels", 0, 1000, [](auto& s) -> auto& { return s.options.sigma_px; },
          "Standard deviation of additional noise of every image point, e.g. calibration error.")
      .number(
          "min_area_px", "pixels", 1, 1e9, [](auto& s) -> auto& { return s.options.min_area_px; },
          "Smaller blobs are ignored.")
      .other(
          "search_region_m", "section with `min` and `max`, three numbers each", "m", "everywhere",
          "Box in the robot's base frame that the target's centre never leaves. Objects of its colour outside the box "
          "are not the target, and the images are searched only where they show the box.",
          [](const Config& config, TrackerSection& s) { read_search_region(config, s.options); })
      .flag(
          "adapt_colour", [](auto& s) -> auto& { return s.options.adapt_colour; },
          "Whether to follow slow changes of white balance.");
  add_track_keys(keys,
                 " With 3 or fewer, a bounce is accepted at once if nothing else of the target's colour is in view.");
  return keys;
}

ConfigKeys<vision::TagOptions> tag_keys() {
  ConfigKeys<vision::TagOptions> keys("vision.yaml, section tag", "An AprilTag of the family 36h11 as a target.");
  keys.integer(
          "id", "", 0, vision::kTagIds - 1, [](auto& o) -> auto& { return o.id; }, "Its number in the family.")
      .required()
      .number(
          "size_m", "m", 1e-3, 10, [](auto& o) -> auto& { return o.size.side_m; },
          "Side of its black square, without the white margin, as measured on the print.")
      .required()
      .number(
          "size_tolerance_m", "m", 0, 10, [](auto& o) -> auto& { return o.size.tolerance_m; },
          "Standard deviation of `size_m`.");
  return keys;
}

ConfigKeys<TagSection> tag_target_keys() {
  ConfigKeys<TagSection> keys("vision.yaml, section targets, entries with a tag",
                              "How a tag is tracked. `TARGET` then has an orientation, too.");
  keys.text(
          "name", [](auto& s) -> auto& { return s.name; }, "The target's name.")
      .required()
      .other("tag", "section", "", "required", "Which tag.",
             [](const Config& config, TagSection& s) { tag_keys().read(config.section("tag"), s.options); })
      .number(
          "sigma_px", "pixels", 0, 1000, [](auto& s) -> auto& { return s.options.sigma_px; },
          "Standard deviation of additional noise of every image point, e.g. calibration error.");
  add_track_keys(keys, "");
  return keys;
}

/// Messages end a text at a NUL.
void require_name(const std::string& name, const Config& section, const char* key) {
  if (name.empty() || name.find('\0') != std::string::npos) section.fail(key, "a name, without NUL characters");
}

VisionConfig::Tag tag_from(const Config& section, const StereoRig& rig) {
  if (section.has("colour")) section.fail("colour", "either 'colour' or 'tag', not both");
  TagSection tag;
  tag_target_keys().read(section, tag);
  require_name(tag.name, section, "name");
  tag.options.rig = rig;
  return {tag.name, tag.options};
}

/// Reads one target: from a section of `targets`, or from `tracker`, whose colour stands at the top of the file.
VisionConfig::Target target_from(const Config& section, bool several, const Config& colour_section,
                                 const StereoRig& rig, std::string& files) {
  TrackerSection tracker;
  if (!several) tracker.name = "target";
  tracker_keys(several).read(section, tracker);
  require_name(tracker.name, section, several ? "name" : "target_name");
  const ColourConfig colour = colour_config_from(colour_section);
  files += colour.file;
  tracker.options.rig = rig;
  tracker.options.colour = colour.models;
  return {tracker.name, tracker.options};
}

}  // namespace

VisionConfig VisionConfig::load(const std::string& path, const ConfigOverrides& overrides) {
  const Config file = Config::load(path, overrides);
  VisionConfig vision;
  const RigConfig cameras = load_rig(file.section("cameras"));
  vision.rig = cameras.rig;
  vision.calibrated = cameras.has_robot_pose;
  std::string files = cameras.files;
  if (file.has("targets")) {
    std::set<std::string> names;
    for (const Config& section : file.sections("targets")) {
      std::string name;
      if (section.has("tag")) {
        name = vision.tags.emplace_back(tag_from(section, vision.rig)).name;
      } else {
        const Config colour = section.section("colour");
        name = vision.targets.emplace_back(target_from(section, true, colour, vision.rig, files)).name;
      }
      if (!names.insert(name).second) section.fail("name", "another name than the targets above");
    }
    if (names.empty()) file.fail("targets", "at least one target");
  } else {
    const Config section = file.has("tracker") ? file.section("tracker") : Config::parse(path, "{}");
    vision.targets.push_back(target_from(section, false, file.section("colour"), vision.rig, files));
  }
  file.finish();
  vision.digest = digest_of(read_text_file(path) + files + text_of(overrides));
  const auto check = [&](const std::string& name, const auto& construct) {
    try {
      construct();
    } catch (const std::invalid_argument& fault) {
      throw InputError(path + ": target '" + name + "': " + fault.what());
    }
  };
  for (const Target& target : vision.targets) {
    if (target.options.search_region && !vision.calibrated) {
      throw InputError(
          path + ": target '" + target.name +
          "': search_region_m is in the robot's base frame, and needs cameras.left_to_robot; without a robot, "
          "{translation_m: [0, 0, 0]} makes it the left camera's frame");
    }
    check(target.name, [&] { const vision::StereoTracker tracker(target.options); });
  }
  for (const Tag& tag : vision.tags) check(tag.name, [&] { const vision::TagTracker tracker(tag.options); });
  return vision;
}

std::string vision_config_reference() {
  const ConfigKey cameras{"cameras", "section", "", "required", "The two cameras."};
  const ConfigKey colour{"colour", "section", "", "required without `targets`", "The target's colours."};
  const ConfigKey tracker{"tracker", "section", "", "all defaults", "How the target is tracked."};
  const ConfigKey targets{"targets", "list of sections", "", "none",
                          "Instead of `colour` and `tracker`: several targets."};
  return config_reference("vision.yaml", "Two cameras and the targets to track. Paths are relative to the file.",
                          {cameras, colour, tracker, targets}) +
         "\n" + rig_config_reference() + "\n" + colour_config_reference() + "\n" + tracker_keys(true).reference() +
         "\n" + tag_target_keys().reference() + "\n" + tag_keys().reference();
}

}  // namespace multireach
