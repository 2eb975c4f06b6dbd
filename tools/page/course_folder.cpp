#include "tools/page/course_folder.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "runtime/files.hpp"

namespace multireach {
namespace {

using nlohmann::json;

constexpr const char* kSettings = "/course.json";

}  // namespace

CourseFolder::CourseFolder(std::string path) : path_(std::move(path)) {
  std::error_code error;
  std::filesystem::create_directories(boards(), error);
  if (!std::filesystem::is_directory(boards(), error)) throw InputError("'" + path_ + "' cannot be made");
  if (!exists(path_ + kSettings)) return;
  const json file = json::parse(read_text_file(path_ + kSettings), nullptr, false);
  if (!file.is_object()) throw InputError(path_ + kSettings + ": is not what the set-up course writes; remove it");
  settings_.columns = file.value("columns", 0);
  settings_.rows = file.value("rows", 0);
  settings_.square_m = file.value("square_m", settings_.square_m);
  settings_.radius_m = file.value("radius_m", settings_.radius_m);
  if (const auto offset = file.find("offset_m"); offset != file.end() && offset->is_array() && offset->size() == 3)
    settings_.p_HT =
        Eigen::Vector3d((*offset)[0].get<double>(), (*offset)[1].get<double>(), (*offset)[2].get<double>());
}

bool CourseFolder::exists(const std::string& file) {
  std::error_code error;
  return std::filesystem::is_regular_file(file, error);
}

void CourseFolder::remove(const std::string& file_or_folder) {
  std::error_code error;
  std::filesystem::remove_all(file_or_folder, error);
}

void CourseFolder::change(const Settings& settings) {
  settings_ = settings;
  json file{{"columns", settings_.columns},
            {"rows", settings_.rows},
            {"square_m", settings_.square_m},
            {"radius_m", settings_.radius_m}};
  if (const auto& p = settings_.p_HT) file["offset_m"] = {p->x(), p->y(), p->z()};
  write_json_file(path_ + kSettings, file);
}

void CourseFolder::write_vision() const {
  if (!exists(stereo()) || !exists(colour())) return;
  std::string text = "# Written by the set-up course of multireach-page.\ncameras:\n  file: stereo.yaml\n";
  if (exists(pose())) text += "  left_to_robot: {file: pose.yaml}\n";
  text += "colour: {file: ball.colour.yaml}\ntracker:\n  target_name: ball\n";
  if (settings_.radius_m > 0) text += fmt::format("  ball_radius_m: {}\n", settings_.radius_m);
  write_text_file(vision(), text);
}

}  // namespace multireach
