#include "bench/real/real_set.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "runtime/config.hpp"
#include "runtime/image_file.hpp"
#include "runtime/rig_config.hpp"

namespace multireach::bench {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> images_in(const Config& config, const std::string& key, const fs::path& set_folder) {
  std::vector<std::string> images;
  const fs::path folder = set_folder / config.text(key);
  if (!fs::is_directory(folder)) config.fail(key, "a folder of images");
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string ending = entry.path().extension().string();
    if (ending == ".jpg" || ending == ".png") images.push_back(entry.path().string());
  }
  if (images.empty()) config.fail(key, "a folder with images: files .jpg or .png");
  std::ranges::sort(images);
  const auto keep = config.numbers("range", 2, std::vector<double>{0, 1e9});
  const auto count = static_cast<double>(images.size());
  const auto first = static_cast<ptrdiff_t>(std::clamp(keep[0], 0.0, count));
  const auto end = static_cast<ptrdiff_t>(std::clamp(keep[1], 0.0, count));
  if (first >= end) config.fail("range", "numbers of the first image and of the one after the last");
  return {images.begin() + first, images.begin() + end};
}

/// The numbers of images by their file names.
std::map<std::string, size_t> numbers_of(const std::vector<std::string>& images) {
  std::map<std::string, size_t> number;
  for (size_t k = 0; k < images.size(); ++k) number[fs::path(images[k]).filename().string()] = k;
  return number;
}

/// A line of a table: names, then numbers.
struct Row {
  int line;
  std::vector<std::string> names;
  std::vector<double> numbers;
};

/// Reads the lines of a table after the first one, which must be `header`. The first `names` columns are names, the
/// others numbers.
std::vector<Row> rows_of(const std::string& path, const std::string& header, size_t names) {
  if (fs::is_directory(path)) throw InputError(path + ": is a folder; expected a table with the columns " + header);
  std::ifstream file(path);
  if (!file || file.peek() == std::ifstream::traits_type::eof())
    throw InputError(path + ": cannot be read, or is empty");
  const auto columns = static_cast<size_t>(std::ranges::count(header, ',')) + 1;
  std::vector<Row> rows;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    if (line.ends_with('\r')) line.pop_back();
    if (number == 1 && line != header) throw InputError(fmt::format("{}, line 1: expected {}", path, header));
    if (number == 1 || line.empty()) continue;
    std::istringstream cells(line);
    Row row{.line = number, .names = std::vector<std::string>(names), .numbers = std::vector<double>(columns - names)};
    for (std::string& name : row.names) std::getline(cells, name, ',');
    bool valid = true;
    for (size_t k = 0; k < row.numbers.size(); ++k) {
      char comma = ',';
      valid = valid && (k == 0 || cells >> comma) && comma == ',' && cells >> row.numbers[k];
    }
    if (!valid || !(cells >> std::ws).eof())
      throw InputError(fmt::format("{}, line {}: '{}' is not {}", path, number, line, header));
    rows.push_back(std::move(row));
  }
  return rows;
}

/// Reads labels of images that are there.
std::vector<LabelledObject> labels_from(const std::string& path, const std::vector<std::string>& images) {
  const std::map<std::string, size_t> number = numbers_of(images);
  std::map<std::string, LabelledObject> objects;
  for (const Row& row : rows_of(path, "image,object,x_px,y_px", 2)) {
    const auto found = number.find(row.names[0]);
    if (found == number.end()) continue;  // outside `range`
    const std::string& object = row.names[1];
    objects[object].name = object;
    objects[object].centres[found->second].push_back({row.numbers[0], row.numbers[1]});
  }
  std::vector<LabelledObject> list;
  for (auto& [name, object] : objects) list.push_back(std::move(object));
  if (list.empty()) throw InputError(path + ": has no label of an image that is there");
  return list;
}

/// Reads which images the colours are learned from: a map from objects to images, where the set names them.
void read_clicks(const Config& config, RealSet& set) {
  if (!config.has("clicks")) return;
  const Config clicks = config.section("clicks");
  for (LabelledObject& object : set.labelled) {
    if (!clicks.has(object.name)) continue;
    for (const std::string& image : clicks.texts(object.name)) {
      const auto at = std::ranges::find_if(
          set.images, [&](const std::string& path) { return fs::path(path).filename().string() == image; });
      const auto number = static_cast<size_t>(at - set.images.begin());
      if (!object.centres.contains(number)) clicks.fail(object.name, "names of images with a label of this object");
      object.clicks.push_back(number);
    }
  }
  clicks.finish();
}

/// Reads how many targets are tracked of each object of which the images show several.
void read_targets(const Config& config, RealSet& set) {
  if (!config.has("targets")) return;
  const Config targets = config.section("targets");
  for (LabelledObject& object : set.labelled) {
    if (targets.has(object.name)) object.targets = static_cast<size_t>(targets.integer(object.name, 1, 100));
  }
  targets.finish();
}

StereoRig rig_of(const Config& config, const cv::Size& size, double fx, double baseline_m) {
  if (size.empty()) config.fail("images", "images that can be read");
  return parallel_rig(size.width, size.height, fx, baseline_m);
}

void load_video(const Config& config, const fs::path& folder, RealSet& set) {
  set.images = images_in(config, "images", folder);
  set.labelled = labels_from((folder / config.text("labels")).string(), set.images);
  read_clicks(config, set);
  read_targets(config, set);
  set.frames_per_s = config.number("frames_per_s", 0.1, 1e4, 30);
  const double disparity_px = config.number("disparity_px", 1, 1000, 10);
  const double fx = config.number("fx_px", 1, 1e6, 600), baseline = config.number("baseline_m", 1e-3, 10, 0.06);
  const cv::Size size = read_image(set.images.front()).size();
  set.rig = rig_of(config, size, fx, baseline);
  set.rig.left.fy = set.rig.right.fy = config.number("fy_px", 1, 1e6, fx);  // differs where pixels are not square
  set.rig.right.width += kAddedColumns;
  set.rig.right.cx += kAddedColumns + disparity_px;
}

/// Reads points in both images of pairs that are there.
std::map<std::string, std::map<size_t, StereoPoint>> stereo_points_from(const std::string& path,
                                                                        const std::vector<std::string>& images) {
  const std::map<std::string, size_t> number = numbers_of(images);
  std::map<std::string, std::map<size_t, StereoPoint>> points;
  for (const auto& [line, names, v] : rows_of(path, "image,object,left_x_px,left_y_px,right_x_px,right_y_px", 2)) {
    const auto found = number.find(names[0]);
    if (found == number.end()) continue;
    if (!points[names[1]].emplace(found->second, StereoPoint{{v[0], v[1]}, {v[2], v[3]}}).second)
      throw InputError(fmt::format("{}, line {}: a second point of '{}' in {}", path, line, names[1], names[0]));
  }
  return points;
}

void load_stereo_video(const Config& config, const fs::path& folder, RealSet& set) {
  set.images = images_in(config, "left_images", folder);
  set.right_images = images_in(config, "right_images", folder);
  const auto name = [](const std::string& path) { return fs::path(path).filename(); };
  if (!std::ranges::equal(set.images, set.right_images, {}, name, name))
    config.fail("right_images", "a folder with images of the same names as left_images");
  set.rig = load_rig(config.section("cameras")).rig;
  read_image_of(set.rig.left, set.images.front());
  read_image_of(set.rig.right, set.right_images.front());
  set.frames_per_s = config.number("frames_per_s", 0.1, 1e4, 30);
  set.radius_m = config.number("ball_radius_m", 0, 10, 0);
  const auto labels = stereo_points_from((folder / config.text("labels")).string(), set.images);
  const std::string key = config.has("clicks") ? "clicks" : "labels";
  const auto clicks = stereo_points_from((folder / config.text(key)).string(), set.images);
  for (const auto& [object, points] : clicks) {
    if (!labels.contains(object)) config.fail(key, "only objects that have labels, not '" + object + "'");
  }
  for (const auto& [object, centres] : labels) {
    const auto clicked = clicks.find(object);
    if (clicked == clicks.end()) config.fail(key, "a file with clicks on '" + object + "'");
    const cv::Rect in_left(0, 0, set.rig.left.width, set.rig.left.height);
    const cv::Rect in_right(0, 0, set.rig.right.width, set.rig.right.height);
    for (const auto& [image, at] : clicked->second) {
      if (!in_left.contains(cv::Point(at.left)) || !in_right.contains(cv::Point(at.right)))
        config.fail(key, fmt::format("points of '{}' that are inside {}", object, name(set.images[image]).string()));
    }
    set.stereo.push_back({object, centres, clicked->second});
  }
}

/// Depths of the region's pixels whose disparity is within a few pixels of that at the click.
void set_true_depths(const Config& config, const cv::Mat& disparity_px, double offset_px, double fx_baseline,
                     StillObject& object) {
  object.click.disparity_px = disparity_px.at<double>(object.click.left_px);
  if (!(object.click.disparity_px > 0 && object.click.disparity_px < object.click.left_px.x))
    config.fail("click", "a point whose true disparity is known and that is inside the right image too");
  if (!(object.click.disparity_px + offset_px > 0))
    config.fail("click", fmt::format("a point whose disparity, {:g} px, is positive with disparity_offset_px ({:g})",
                                     object.click.disparity_px, offset_px));
  std::vector<double> depths;
  for (int row = object.region.y; row < object.region.br().y; ++row) {
    for (int column = object.region.x; column < object.region.br().x; ++column) {
      const double d = disparity_px.at<double>(row, column);
      if (d > 0 && d + offset_px > 0 && std::abs(d - object.click.disparity_px) < StillObject::kSameObject_px)
        depths.push_back(fx_baseline / (d + offset_px));
    }
  }
  std::ranges::sort(depths);
  object.least_m = depths[depths.size() / 20];
  object.most_m = depths[depths.size() * 19 / 20];
}

void load_still(const Config& config, const fs::path& folder, RealSet& set) {
  set.left = read_image((folder / config.text("left")).string());
  set.right = read_image((folder / config.text("right")).string());
  const std::string path = (folder / config.text("disparity")).string();
  cv::Mat coded = cv::imread(path, cv::IMREAD_UNCHANGED);
  if (coded.size() != set.left.size() || coded.channels() != 1 || (coded.depth() != CV_8U && coded.depth() != CV_16U))
    config.fail("disparity", "an image of the left image's size, of one channel with 8 or 16 bits");
  coded.convertTo(coded, CV_16U);
  const double scale = config.number("disparity_scale", 1e-3, 1e6, 1);
  const double offset = config.number("disparity_offset_px", -1e6, 1e6, 0);
  const double fx = config.number("fx_px", 1, 1e6), baseline = config.number("baseline_m", 1e-3, 10);
  cv::Mat& disparity_px = set.true_disparity_px;
  disparity_px.create(coded.size(), CV_64F);
  for (int row = 0; row < coded.rows; ++row) {
    for (int column = 0; column < coded.cols; ++column) {
      const int value = coded.at<uint16_t>(row, column);
      disparity_px.at<double>(row, column) = value > 0 ? value / scale : -1;
    }
  }
  set.rig = rig_of(config, set.left.size(), fx, baseline);
  set.rig.right.cx += offset;
  set.disparity_offset_px = offset;
  const cv::Rect image({0, 0}, set.left.size());
  for (const Config& section : config.sections("objects")) {
    StillObject object;
    object.name = section.text("name");
    const auto click = section.numbers("click", 2), region = section.numbers("region", 4);
    object.click.left_px = {cvRound(click[0]), cvRound(click[1])};
    object.region = cv::Rect(cvRound(region[0]), cvRound(region[1]), cvRound(region[2]), cvRound(region[3])) & image;
    object.whole = section.flag("whole", true);
    if (!object.region.contains(object.click.left_px)) section.fail("click", "a point inside `region` and the image");
    section.finish();
    set_true_depths(section, disparity_px, offset, fx * baseline, object);
    set.still.push_back(object);
  }
}

/// Reads images of objects, and their positions in W.
std::vector<MeasuredObject> positions_from(const std::string& path, const StereoRig& rig) {
  std::vector<MeasuredObject> objects;
  for (const auto& [line, names, v] : rows_of(path, "left_x_px,left_y_px,right_x_px,right_y_px,x_m,y_m,z_m", 0)) {
    const MeasuredObject object{{v[0], v[1]}, {v[2], v[3]}, {v[4], v[5], v[6]}};
    const auto inside = [](const CameraModel& camera, const cv::Point2d& px) {
      return cv::Rect(0, 0, camera.width, camera.height).contains(cv::Point(px));
    };
    if (!inside(rig.left, object.left_px) || !inside(rig.right, object.right_px))
      throw InputError(fmt::format("{}, line {}: a pixel is outside its image", path, line));
    const Eigen::Vector3d p_L = rig.X_WL.inverse() * object.p_W, p_R = rig.X_RL * p_L;
    const auto shown = [&](const CameraModel& camera, const Eigen::Vector3d& p_C, const cv::Point2d& px) {
      constexpr double kNear = 0.25;  // of the image's width, from the click
      return p_C.z() > 0 && (camera.project(p_C) - Eigen::Vector2d(px.x, px.y)).norm() < kNear * camera.width;
    };
    if (!shown(rig.left, p_L, object.left_px) || !shown(rig.right, p_R, object.right_px)) {
      throw InputError(
          fmt::format("{}, line {}: by `cameras`, the position is not seen near its clicks: metres? left and right? "
                      "left_to_robot?",
                      path, line));
    }
    objects.push_back(object);
  }
  if (objects.empty()) throw InputError(path + ": has no position");
  return objects;
}

void load_measured(const Config& config, const fs::path& folder, RealSet& set) {
  const RigConfig cameras = load_rig(config.section("cameras"));
  if (!cameras.has_robot_pose) config.fail("cameras", "a left_to_robot: the frame of the measured positions");
  set.rig = cameras.rig;
  const auto image = [&](const std::string& key, const std::string& otherwise, const CameraModel& camera) {
    return read_image_of(camera, (folder / config.text(config.has(key) ? key : otherwise)).string());
  };
  set.left = image("left", "left", set.rig.left);
  set.right = image("right", "right", set.rig.right);
  if (config.has("learn_left") != config.has("learn_right"))
    config.fail(config.has("learn_left") ? "learn_left" : "learn_right", "both learn_left and learn_right, or none");
  set.learn_left = image("learn_left", "left", set.rig.left);
  set.learn_right = image("learn_right", "right", set.rig.right);
  set.measured = positions_from((folder / config.text("positions")).string(), set.rig);
  set.radius_m = config.number("ball_radius_m", 0, 10, 0);
}

}  // namespace

cv::Mat read_image_of(const CameraModel& camera, const std::string& path) {
  cv::Mat image = read_image(path);
  if (image.size() != cv::Size(camera.width, camera.height))
    throw InputError(fmt::format("{}: is of {} x {} pixels; expected {} x {}", path, image.cols, image.rows,
                                 camera.width, camera.height));
  return image;
}

cv::Mat second_image(const cv::Mat& image) {
  cv::Mat second;
  cv::copyMakeBorder(image, second, 0, 0, kAddedColumns, 0, cv::BORDER_REPLICATE);
  return second;
}

RealSet RealSet::load(const std::string& folder) {
  const Config config = Config::load((fs::path(folder) / "set.yaml").string());
  RealSet set;
  set.name = config.text("name");
  set.for_test = config.choice("use", {"tuning", "test"}) == "test";
  if (config.has("images")) {
    load_video(config, folder, set);
  } else if (config.has("left_images")) {
    load_stereo_video(config, folder, set);
  } else if (config.has("positions")) {
    load_measured(config, folder, set);
  } else if (config.has("disparity")) {
    load_still(config, folder, set);
  } else {
    throw InputError(folder +
                     "/set.yaml: expected one of the keys images (a video), left_images (a video of two cameras), "
                     "disparity and positions (a pair)");
  }
  config.finish();
  return set;
}

}  // namespace multireach::bench
