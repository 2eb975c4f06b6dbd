#include "tools/calibrate/camera_output.hpp"
#include "tools/calibrate/camera_file_texts.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cstdio>

namespace multireach {

void CameraOutput::add_options(CommandLine& app) {
  app.option("-o,--output", paths, "file to write; for ROS twice: -o LEFT -o RIGHT").required().repeated();
  app.option("--format", word,
             "vision, opencv, ros or kalibr; unless given: two files are ros, *camchain* is kalibr, .yml opencv, "
             "others vision (section `cameras` of a vision file)");
}

CameraFormat CameraOutput::format() const {
  return word.empty() ? format_from_names(paths) : camera_format_of("--format", word);
}

void CameraOutput::check() const {
  const size_t wanted = format() == CameraFormat::kRos ? 2 : 1;
  if (paths.size() != wanted) {
    throw InputError(wanted == 2 ? "-o: ROS's camera_info is one file for each camera; expected -o LEFT -o RIGHT"
                                 : "-o: this format is one file; expected one name");
  }
  if (wanted == 2 && paths[0] == paths[1]) throw InputError("-o: '" + paths[0] + "' is named for both cameras");
  for (const std::string& path : paths) check_writable(path);
}

void CameraOutput::write(const StereoRig& rig, bool robot) const {
  const std::vector<std::string> texts = camera_file_texts(rig, format(), robot);
  if (rig.errors.known() && format() != CameraFormat::kVision) {
    spdlog::info("{}: this format does not contain how uncertain the calibration is; a file of the format vision does",
                 paths.front());
  }
  for (size_t k = 0; k < texts.size(); ++k) write_text_file(paths[k], texts[k]);
}

void check_writable(const std::string& path) {
  if (!path.empty() && path != "-" && !path.starts_with("/dev/")) OutputFile probe(path);
}

std::pair<int, int> parse_size(const std::string& option, const std::string& text, int min, int max) {
  int width = 0, height = 0, end = 0;
  if (std::sscanf(text.c_str(), "%dx%d%n", &width, &height, &end) != 2 || end != static_cast<int>(text.size()) ||
      std::min(width, height) < min || std::max(width, height) > max) {
    throw InputError(fmt::format("{} is '{}'; expected WxH, two whole numbers from {} to {}", option, text, min, max));
  }
  return {width, height};
}

}  // namespace multireach
