#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "runtime/files.hpp"
#include "runtime/image_file.hpp"
#include "tools/calibrate/camera_output.hpp"
#include "tools/calibrate/colour_region.hpp"
#include "tools/calibrate/commands.hpp"
#include "tools/calibrate/object_colour.hpp"
#include "tools/calibrate/picture_window.hpp"
#include "vision/node/colour_config.hpp"

namespace multireach {
namespace {

/// User input for one camera.
struct CameraInput {
  std::string name;
  // Values of the options, in their order.
  std::vector<std::string> files{}, clicks{}, rectangles{}, without{};
  std::string within{};
};

struct ColourOptions {
  CameraInput left{"left"}, right{"right"};
  bool in_window = false;
  std::string output, check_picture, json;
};

/// One picture of the object, and where the object is in it.
struct PictureInput {
  std::string file;
  std::vector<std::string> clicks{}, rectangles{};
};

/// Gives each picture the clicks and rectangles that follow it on the command line, whose options are in `order`. With
/// one picture they may also precede it.
std::vector<PictureInput> pictures_of(const CameraInput& input, const std::vector<std::string>& order) {
  std::vector<PictureInput> pictures;
  if (input.files.size() == 1) return {{input.files[0], input.clicks, input.rectangles}};
  size_t click = 0, rectangle = 0;
  const auto last = [&](const std::string& option, const std::string& value) -> PictureInput& {
    if (pictures.empty()) {
      throw InputError(fmt::format("--{} {}: with several pictures, give it after the --{} that it belongs to", option,
                                   value, input.name));
    }
    return pictures.back();
  };
  for (const std::string& option : order) {
    if (option == input.name) {
      pictures.push_back({input.files[pictures.size()]});
    } else if (option == "click-" + input.name) {
      const std::string& value = input.clicks[click++];
      last(option, value).clicks.push_back(value);
    } else if (option == "rectangle-" + input.name) {
      const std::string& value = input.rectangles[rectangle++];
      last(option, value).rectangles.push_back(value);
    }
  }
  return pictures;
}

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

/// What the user points at in a window: a rectangle around the object, or a click on it.
ObjectRegion region_in_window(const std::string& camera, const std::string& file, const cv::Mat& bgr) {
  if (!windows_can_be_shown()) {
    throw InputError(
        fmt::format("--in-window: windows cannot be shown on this display; give --click-{} X,Y instead", camera));
  }
  const auto chosen = pointed_at(
      fmt::format("{} image {}: click on the object, or draw a rectangle around it; then Enter", camera, file), bgr);
  if (!chosen) throw InputError("--in-window: nothing was chosen in " + file);
  if (chosen->area() == 1) return region_around(bgr, chosen->tl());
  return {*chosen, {}};
}

/// A rectangle that an option gives, inside the picture.
cv::Rect rectangle_of(const std::string& option, const std::string& text, const std::string& file, const cv::Mat& bgr) {
  const std::vector<int> v = integers(option, text, 4, "X,Y,WIDTH,HEIGHT in whole pixels");
  const cv::Rect rectangle(v[0], v[1], v[2], v[3]);
  if (v[2] <= 0 || v[3] <= 0 || (rectangle & cv::Rect({0, 0}, bgr.size())) != rectangle) {
    throw InputError(
        fmt::format("{}: {} is not inside {}, which is {} x {} pixels", option, text, file, bgr.cols, bgr.rows));
  }
  return rectangle;
}

/// Where the object is: a rectangle around it, or also its pixels, as clicks show them.
ObjectRegion region_of(const std::string& camera, const PictureInput& picture, const cv::Mat& bgr, bool in_window) {
  const std::string option = "--rectangle-" + camera;
  if (in_window) return region_in_window(camera, picture.file, bgr);
  if (picture.rectangles.size() > 1 || (!picture.rectangles.empty() && !picture.clicks.empty())) {
    throw InputError(fmt::format("{}: expected one {}, or --click-{} only", picture.file, option, camera));
  }
  if (!picture.rectangles.empty()) return {rectangle_of(option, picture.rectangles[0], picture.file, bgr), {}};
  if (picture.clicks.empty()) {
    throw InputError(
        fmt::format("{}: say where the object is: {} X,Y,WIDTH,HEIGHT, or --click-{} X,Y, or --in-window; a picture "
                    "without the object is --without-{}",
                    picture.file, option, camera, camera));
  }
  std::vector<cv::Point> clicks;
  for (const std::string& click : picture.clicks) {
    const std::vector<int> v = integers("--click-" + camera, click, 2, "X,Y in whole pixels");
    if (!cv::Rect({0, 0}, bgr.size()).contains({v[0], v[1]})) {
      throw InputError(fmt::format("--click-{}: {} is not inside {}, which is {} x {} pixels", camera, click,
                                   picture.file, bgr.cols, bgr.rows));
    }
    clicks.emplace_back(v[0], v[1]);
  }
  return region_around(bgr, clicks);
}

/// Refuses a part of the picture that does not contain the object.
void require_inside(const ObjectPicture& picture, const std::string& option, const std::string& text) {
  const ObjectRegion& region = *picture.region;
  const cv::Rect& box = region.box;
  // A region that clicks propose may reach beyond, into what is alike.
  const bool known = !region.mask.empty();
  const double inside = known ? cv::countNonZero(region.mask(*picture.within)) : (box & *picture.within).area();
  const double all = known ? cv::countNonZero(region.mask) : box.area();
  if (inside >= 0.5 * all) return;
  throw InputError(fmt::format("{}: {} does not contain the object, which is at {},{},{},{} in {}", option, text, box.x,
                               box.y, box.width, box.height, picture.name));
}

/// The pictures of one camera: first those of the object, then those without it.
std::vector<ObjectPicture> read_pictures(const CameraInput& input, const std::vector<std::string>& order,
                                         bool in_window) {
  std::vector<ObjectPicture> pictures;
  const std::string option = "--within-" + input.name;
  const auto add = [&](const std::string& file) -> ObjectPicture& {
    const cv::Mat bgr = read_image(file);
    ObjectPicture& picture = pictures.emplace_back(ObjectPicture{.bgr = bgr, .name = file});
    if (!input.within.empty()) picture.within = rectangle_of(option, input.within, file, bgr);
    return picture;
  };
  for (const PictureInput& shown : pictures_of(input, order)) {
    ObjectPicture& picture = add(shown.file);
    picture.region = region_of(input.name, shown, picture.bgr, in_window);
    if (picture.within) require_inside(picture, option, input.within);
  }
  for (const std::string& file : input.without) add(file);
  return pictures;
}

/// What to do about a fault of several pictures, as the rest of a sentence.
std::string advice(const std::vector<ObjectPicture>& pictures, const ObjectColour& object) {
  constexpr char kTakeAway[] = "; take away what has the object's colours there, or choose another object";
  const auto is_without = [&](const std::optional<size_t>& k) { return k && !pictures[*k].region; };
  if (is_without(object.faulty_picture)) return kTakeAway;
  std::vector<ObjectPicture> objects;
  std::vector<std::string> others;
  for (const ObjectPicture& picture : pictures) {
    if (picture.region)
      objects.push_back(picture);
    else
      others.push_back(picture.name);
  }
  if (!others.empty() && learn_object(objects).fault.empty())
    return fmt::format("; without {} the rest passes{}", fmt::join(others, ", "), kTakeAway);
  if (objects.size() == 1) return {};
  spdlog::info("looking for the pictures that cause this, by learning from one after another");
  const AgreeingPictures agreeing = learn_agreeing(pictures);
  if (!agreeing.object.fault.empty()) {
    if (is_without(agreeing.object.faulty_picture)) return "; " + agreeing.object.fault + kTakeAway;
    if (!others.empty())
      return "; the pictures do not agree: check the clicks or rectangles, and what the pictures without it show";
    return agreeing.left_out.size() + 1 == objects.size()
               ? "; no other picture is accepted either: correct the clicks or rectangles, or choose another object"
               : "; the pictures do not agree: check the clicks or rectangles in each";
  }
  std::vector<std::string> names, kept;
  for (size_t k = 0; k < pictures.size(); ++k) {
    const bool left_out = std::ranges::find(agreeing.left_out, k) != agreeing.left_out.end();
    if (pictures[k].region) (left_out ? names : kept).push_back(pictures[k].name);
  }
  const bool few = kept.size() < names.size();
  const std::string without = few ? fmt::format("; only {} would pass, without the others", fmt::join(kept, ", "))
                                  : fmt::format("; without {} the rest passes", fmt::join(names, ", "));
  if (agreeing.doubt.empty()) return without + ": correct the clicks or rectangles there, or leave them out";
  return fmt::format(
      "{}, but {}: correct the clicks or rectangles there or, if they are right, choose another object or another "
      "light",
      without, agreeing.doubt);
}

struct Learned {
  ObjectColour object;
  std::string fault{};  // why the model is of no use, and what to do; empty when it is of use
};

Learned learn(const std::vector<ObjectPicture>& pictures) {
  for (const ObjectPicture& picture : pictures) {
    const bool clicked = picture.region && !picture.region->mask.empty();
    if (clicked)
      spdlog::info("{}: outlined as the object, {} x {} px: see --picture", picture.name, picture.region->box.width,
                   picture.region->box.height);
  }
  Learned learned{learn_object(pictures)};
  for (const std::string& sentence : learned.object.warnings) spdlog::warn("{}", sentence);
  if (!learned.object.fault.empty()) learned.fault = learned.object.fault + advice(pictures, learned.object);
  if (learned.object.colour.status != vision::LearnedColour::Status::kLearned) throw std::runtime_error(learned.fault);
  return learned;
}

nlohmann::json json_of(const std::vector<ObjectPicture>& pictures, const vision::LearnedColour& colour) {
  nlohmann::json json{
      {"kept", colour.kept}, {"background", colour.background}, {"by_brightness", colour.by_brightness}};
  for (size_t k = 0; k < pictures.size(); ++k) {
    nlohmann::json of_picture{{"file", pictures[k].name}, {"background", colour.rates[k].background}};
    if (pictures[k].region) {
      const cv::Rect& box = pictures[k].region->box;
      of_picture["rectangle_px"] = {box.x, box.y, box.width, box.height};
      of_picture["kept"] = colour.rates[k].kept;
    }
    json["pictures"].push_back(of_picture);
  }
  return json;
}

std::vector<cv::Mat> members_pictures(const std::vector<ObjectPicture>& pictures, const vision::ColourModel& model) {
  std::vector<cv::Mat> shown;
  for (const ObjectPicture& picture : pictures) shown.push_back(members_picture(picture, model));
  return shown;
}

/// The pictures of both cameras side by side, one pair below the other.
cv::Mat side_by_side(const std::vector<cv::Mat>& left, const std::vector<cv::Mat>& right) {
  std::vector<cv::Size> sizes;
  cv::Size whole;
  for (size_t k = 0; k < std::max(left.size(), right.size()); ++k) {
    const cv::Size a = k < left.size() ? left[k].size() : cv::Size(),
                   b = k < right.size() ? right[k].size() : cv::Size();
    sizes.emplace_back(a.width + b.width, std::max(a.height, b.height));
    whole = {std::max(whole.width, sizes.back().width), whole.height + sizes.back().height};
  }
  cv::Mat all(whole, CV_8UC3, cv::Scalar(0, 0, 0));
  int row = 0;
  for (size_t k = 0; k < sizes.size(); ++k) {
    const int width = k < left.size() ? left[k].cols : 0;
    if (k < left.size()) left[k].copyTo(all(cv::Rect({0, row}, left[k].size())));
    if (k < right.size()) right[k].copyTo(all(cv::Rect({width, row}, right[k].size())));
    row += sizes[k].height;
  }
  return all;
}

/// Refuses a camera's picture that is given twice, and an output that is a picture to be read, or another output.
void require_distinct(const ColourOptions& options) {
  const auto same = [](const std::string& a, const std::string& b) {
    std::error_code none;
    return a == b || std::filesystem::equivalent(a, b, none) ||
           std::filesystem::path(a).lexically_normal() == std::filesystem::path(b).lexically_normal();
  };
  std::vector<std::pair<std::string, std::string>> taken;
  for (const CameraInput* input : {&options.left, &options.right}) {
    const auto first = static_cast<ptrdiff_t>(taken.size());
    const auto take = [&](const std::string& option, const std::string& file) {
      for (auto before = taken.begin() + first; before != taken.end(); ++before) {
        if (same(file, before->second))
          throw InputError(fmt::format("{} {}: this picture is given twice, first as {} {}", option, file,
                                       before->first, before->second));
      }
      taken.emplace_back(option, file);
    };
    for (const std::string& file : input->files) take("--" + input->name, file);
    for (const std::string& file : input->without) take("--without-" + input->name, file);
  }
  for (const auto& [option, file] : {std::pair<std::string, std::string>("--output", options.output),
                                     {"--picture", options.check_picture},
                                     {"--json", options.json}}) {
    if (file.empty() || file == "-") continue;
    for (const auto& [other, of_other] : taken) {
      if (same(file, of_other)) throw InputError(fmt::format("{}: {} is also {}", option, file, other));
    }
    taken.emplace_back(option, file);
  }
}

int learn_both(const ColourOptions& options, const std::vector<std::string>& order) {
  require_distinct(options);
  for (const std::string& path : {options.output, options.check_picture, options.json}) check_writable(path);
  const bool one = options.right.files.empty();
  const std::vector<ObjectPicture> left_pictures = read_pictures(options.left, order, options.in_window);
  const std::vector<ObjectPicture> right_pictures =
      one ? std::vector<ObjectPicture>() : read_pictures(options.right, order, options.in_window);
  const Learned left = learn(left_pictures), right = one ? left : learn(right_pictures);
  const vision::LearnedColour &in_left = left.object.colour, &in_right = right.object.colour;
  constexpr double kFew = 0.1;  // share of the object that has the other camera's colours: of the same object, most has
  if (!one && largest_share(right_pictures, in_left.model) < kFew &&
      largest_share(left_pictures, in_right.model) < kFew)
    spdlog::warn(
        "the object has other colours in the left than in the right pictures: correct the clicks or rectangles if they "
        "are on two objects, else the cameras' white balance");
  if (one) spdlog::info("no --right: both cameras are taken to see the same colours");
  if (!options.check_picture.empty()) {
    const std::vector<uint8_t> png = encode_png(
        side_by_side(members_pictures(left_pictures, in_left.model), members_pictures(right_pictures, in_right.model)));
    OutputFile file(options.check_picture);
    file.write(png);
    file.finish();
  }
  if (!options.json.empty()) {
    const nlohmann::json of_left = json_of(left_pictures, in_left);
    write_json_file(options.json, {{"left", of_left}, {"right", one ? of_left : json_of(right_pictures, in_right)}});
  }
  for (const Learned* learned : {&left, &right}) {
    if (learned->fault.empty()) continue;
    const bool old = std::filesystem::exists(options.output);
    throw std::runtime_error(fmt::format("{}; see --picture; {} is {}", learned->fault, options.output,
                                         old ? "left as it was" : "not written"));
  }
  write_text_file(options.output, colour_text({in_left.model, in_right.model}));
  const auto summary = [](const vision::LearnedColour& colour) {
    return fmt::format("{:.0f} % of the outlined object and {:.1f} % of the background", 100 * colour.kept,
                       100 * colour.background);
  };
  if (one) {
    spdlog::info("{}: has {}", options.output, summary(in_left));
  } else {
    spdlog::info("{}: has, of the left pictures, {}; of the right ones, {}", options.output, summary(in_left),
                 summary(in_right));
  }
  return 0;
}

}  // namespace

Command colour_command(CommandLine& cli) {
  const auto options = std::make_shared<ColourOptions>();
  CommandLine app = cli.subcommand("colour", "an object's colours, from one or several pictures of it by each camera");
  CommandOption in_window = app.flag("--in-window", options->in_window,
                                     "show the pictures; click on the object, or draw a rectangle around it");
  for (CameraInput* input : {&options->left, &options->right}) {
    const std::string& name = input->name;
    const bool left = input == &options->left;
    CommandOption file = app.option("--" + name, input->files,
                                    "the " + name +
                                        " camera's picture; several, for several lights and positions: each with "
                                        "its clicks, or its rectangle, after it");
    file.repeated();
    if (left) file.required();
    app.option("--click-" + name, input->clicks, "X,Y: a point on the object, pixels; may be repeated")
        .repeated()
        .needs(file)
        .excludes(in_window);
    app.option("--rectangle-" + name, input->rectangles, "X,Y,WIDTH,HEIGHT: just around the object, pixels")
        .repeated()
        .needs(file)
        .excludes(in_window);
    app.option("--without-" + name, input->without,
               "a picture without the object: nothing in it may have the object's colours; may be repeated")
        .repeated()
        .needs(file);
    app.option("--within-" + name, input->within,
               "X,Y,WIDTH,HEIGHT: the part of the pictures that shows vision's search_region_m, pixels; the rest is "
               "ignored")
        .needs(file);
  }
  app.option("-o,--output", options->output, "YAML for the `colour` section of a vision file: {file: ...}").required();
  app.option("--picture", options->check_picture, "PNG in which pixels of other colours are dark grey");
  app.option("--json", options->json, "quality report of the colour models; - for standard output");
  return {app, [options, app] { return learn_both(*options, app.order()); }};
}

}  // namespace multireach
