#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <charconv>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/highgui.hpp>

#include "runtime/files.hpp"
#include "runtime/image_file.hpp"
#include "tools/calibrate/camera_output.hpp"
#include "tools/calibrate/colour_region.hpp"
#include "tools/calibrate/commands.hpp"
#include "tools/calibrate/object_colour.hpp"
#include "vision/node/colour_config.hpp"

namespace multireach {
namespace {

/// User input for one camera: a picture, and where the object is in it.
struct Picture {
  std::string name, file, rectangle{}, within{};
  std::vector<std::string> clicks{};
};

struct ColourOptions {
  Picture left{"left", {}}, right{"right", {}};
  bool in_window = false;
  std::string output, check_picture, json;
};

std::vector<int> integers(const std::string& option, const std::string& text, size_t count, const char* form) {
  std::vector<int> values;
  const char *at = text.data(), *end = text.data() + text.size();
  while (at <= end) {
    int value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc() || (next != end && *next != ',')) break;
    values.push_back(value);
    if (next == end) break;
    at = next + 1;
  }
  const std::string again = fmt::format("{}", fmt::join(values, ","));
  if (values.size() != count || again != text) {
    throw InputError(fmt::format("{}: '{}' is not {}", option, text, form));
  }
  return values;
}

cv::Rect rectangle_in_window(const Picture& picture, const cv::Mat& bgr) {
  if (!std::getenv("DISPLAY") && !std::getenv("WAYLAND_DISPLAY")) {
    throw InputError("--in-window: there is no display; give --rectangle-left and --rectangle-right instead");
  }
  const std::string title = "multireach: the object in the " + picture.name + " image, then Enter";
  const cv::Rect rectangle = cv::selectROI(title, bgr, false, false);
  cv::destroyAllWindows();
  if (rectangle.empty()) throw std::runtime_error("nothing was chosen in the " + picture.name + " image");
  return rectangle;
}

/// A rectangle that an option gives, inside the picture.
cv::Rect rectangle_of(const std::string& option, const std::string& text, const Picture& picture, const cv::Mat& bgr) {
  const std::vector<int> v = integers(option, text, 4, "X,Y,WIDTH,HEIGHT in pixels");
  const cv::Rect rectangle(v[0], v[1], v[2], v[3]);
  if (v[2] <= 0 || v[3] <= 0 || (rectangle & cv::Rect({0, 0}, bgr.size())) != rectangle) {
    throw InputError(fmt::format("{}: {} is not inside {}, which is {} x {} pixels", option, text, picture.file,
                                 bgr.cols, bgr.rows));
  }
  return rectangle;
}

/// Where the object is: a rectangle around it, or also its pixels, as clicks show them.
ObjectRegion region_of(const Picture& picture, const cv::Mat& bgr, bool in_window) {
  const std::string option = "--rectangle-" + picture.name;
  if (in_window) return {rectangle_in_window(picture, bgr), {}};
  if (!picture.rectangle.empty()) {
    return {rectangle_of(option, picture.rectangle, picture, bgr), {}};
  }
  if (picture.clicks.empty()) {
    throw InputError(fmt::format("say where the object is: {} X,Y,WIDTH,HEIGHT, or --click-{} X,Y, or --in-window",
                                 option, picture.name));
  }
  std::vector<cv::Point> clicks;
  for (const std::string& click : picture.clicks) {
    const std::vector<int> v = integers("--click-" + picture.name, click, 2, "X,Y in pixels");
    if (!cv::Rect({0, 0}, bgr.size()).contains({v[0], v[1]})) {
      throw InputError(fmt::format("--click-{}: {} is not inside {}, which is {} x {} pixels", picture.name, click,
                                   picture.file, bgr.cols, bgr.rows));
    }
    clicks.emplace_back(v[0], v[1]);
  }
  return region_around(bgr, clicks);
}

struct Learned {
  vision::LearnedColour colour;
  nlohmann::json json;
  cv::Mat shown;
  std::string fault;  // why the model is of no use; empty when it is
};

Learned learn(const Picture& picture, const ColourOptions& options) {
  const cv::Mat bgr = read_image(picture.file);
  const ObjectRegion region = region_of(picture, bgr, options.in_window);
  const cv::Rect& rectangle = region.box;
  const std::string within_option = "--within-" + picture.name;
  const cv::Rect within =
      picture.within.empty() ? cv::Rect({0, 0}, bgr.size()) : rectangle_of(within_option, picture.within, picture, bgr);
  // A region that clicks propose may reach beyond, into what is alike.
  const double inside = region.mask.empty() ? (rectangle & within).area() : cv::countNonZero(region.mask(within));
  const double all = region.mask.empty() ? rectangle.area() : cv::countNonZero(region.mask);
  if (inside < 0.5 * all) {
    throw InputError(fmt::format("{}: {} does not contain the object, which is at {},{},{},{} in {}", within_option,
                                 picture.within, rectangle.x, rectangle.y, rectangle.width, rectangle.height,
                                 picture.file));
  }
  Learned learned;
  ObjectColour object;
  try {
    object = learn_object(bgr, region, within);
  } catch (const std::runtime_error& fault) {
    throw std::runtime_error(picture.file + ": " + fault.what());
  }
  learned.colour = object.colour;
  const vision::LearnedColour& colour = learned.colour;
  for (const std::string& sentence : object.warnings) spdlog::warn("{}: {}", picture.file, sentence);
  learned.json = {{"file", picture.file},
                  {"rectangle_px", {rectangle.x, rectangle.y, rectangle.width, rectangle.height}},
                  {"kept", colour.kept},
                  {"background", colour.background},
                  {"by_brightness", colour.by_brightness}};
  if (!options.check_picture.empty()) learned.shown = members_picture(bgr, colour.model, region);
  if (!object.fault.empty()) learned.fault = picture.file + ": " + object.fault;
  return learned;
}

int learn_both(const ColourOptions& options) {
  for (const std::string& path : {options.output, options.check_picture, options.json}) check_writable(path);
  const Learned left = learn(options.left, options);
  const Learned right = options.right.file.empty() ? left : learn(options.right, options);
  if (options.right.file.empty()) spdlog::info("no --right: both cameras are taken to see the same colours");
  if (!options.check_picture.empty()) {
    cv::Mat both(std::max(left.shown.rows, right.shown.rows), left.shown.cols + right.shown.cols, CV_8UC3,
                 cv::Scalar(0, 0, 0));
    left.shown.copyTo(both(cv::Rect({0, 0}, left.shown.size())));
    right.shown.copyTo(both(cv::Rect({left.shown.cols, 0}, right.shown.size())));
    const std::vector<uint8_t> png = encode_png(both);
    OutputFile file(options.check_picture);
    file.write(png);
    file.finish();
  }
  if (!options.json.empty()) write_json_file(options.json, {{"left", left.json}, {"right", right.json}});
  for (const Learned* learned : {&left, &right}) {
    if (!learned->fault.empty()) throw std::runtime_error(learned->fault + "; see --picture");
  }
  write_text_file(options.output, colour_text({left.colour.model, right.colour.model}));
  return 0;
}

}  // namespace

Command colour_command(CommandLine& cli) {
  const auto options = std::make_shared<ColourOptions>();
  CommandLine app = cli.subcommand("colour", "an object's colours, from a picture of it by each camera");
  for (Picture* picture : {&options->left, &options->right}) {
    const std::string& name = picture->name;
    CommandOption file = app.option("--" + name, picture->file, "the " + name + " camera's picture");
    if (picture == &options->left) file.required();
    app.option("--rectangle-" + name, picture->rectangle, "X,Y,WIDTH,HEIGHT: filled by the object, pixels").needs(file);
    app.option(
           "--within-" + name, picture->within,
           "X,Y,WIDTH,HEIGHT: the part of the picture that shows vision's search_region_m, pixels; the rest is ignored")
        .needs(file);
    app.option("--click-" + name, picture->clicks, "X,Y: a point on the object, pixels; may be repeated").needs(file);
  }
  app.flag("--in-window", options->in_window, "show the pictures; the rectangles are drawn with the mouse");
  app.option("-o,--output", options->output, "YAML for the `colour` section of a vision file: {file: ...}").required();
  app.option("--picture", options->check_picture, "PNG in which pixels of other colours are dark grey");
  app.option("--json", options->json, "quality report of the colour models; - for standard output");
  return {app, [options] { return learn_both(*options); }};
}

}  // namespace multireach
