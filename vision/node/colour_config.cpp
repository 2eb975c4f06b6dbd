#include "vision/node/colour_config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "runtime/config_keys.hpp"
#include "runtime/files.hpp"

namespace multireach {
namespace {

using vision::ChromaComponent;
using vision::ColourModel;

Rgb rgb_from(const Config& reference) {
  const std::vector<double> rgb = reference.numbers("rgb", 3);
  for (const double channel : rgb) {
    if (channel < 0 || channel > 255) reference.fail("rgb", "three numbers from 0 to 255");
  }
  if (rgb[0] + rgb[1] + rgb[2] < 1) reference.fail("rgb", "a colour that is not black");
  reference.finish();
  return {rgb[0], rgb[1], rgb[2]};
}

/// Declares the keys that a class of colours and a learned model share.
template <class T>
void add_tolerance_keys(ConfigKeys<T>& keys, const std::string& meaning) {
  keys.number(
          "tolerance", "", 1e-6, 100, [](auto& c) -> auto& { return c.tolerance; }, meaning)
      .number(
          "min_luma", "grey levels", 0, 255, [](auto& c) -> auto& { return c.min_luma; },
          "Darker pixels have no colour; luma Y = (R + 2G + B)/4.")
      .number(
          "max_luma", "grey levels", 0, 255, [](auto& c) -> auto& { return c.max_luma; },
          "Brighter pixels have no colour.");
}

ConfigKeys<vision::ColourClass> class_keys() {
  ConfigKeys<vision::ColourClass> keys("vision.yaml, section colour",
                                       "An object's colours, as a few named ones or as learned from pictures.");
  keys.other("references", "list of maps `{rgb: [R, G, B]}`", "0 to 255", "none",
             "Colours of the object; at least one, unless `file` is given.",
             [](const Config& config, vision::ColourClass& colours) {
               for (const Config& reference : config.sections("references"))
                 colours.references.push_back(rgb_from(reference));
               if (colours.references.empty()) config.fail("references", "at least one colour");
             });
  add_tolerance_keys(keys, "Largest distance in chroma ratios ((R - G)/Y, (B - G)/Y) from a reference.");
  // Only references are read here; a file or its content instead of them is read without this table.
  const auto refuse = [](const char* key) {
    return [=](const Config& config, vision::ColourClass&) {
      if (config.has(key)) config.fail(key, std::string("either 'references' or '") + key + "', not both");
    };
  };
  keys.other("file", "text", "", "none",
             "Instead of all other keys: the file that `multireach-calibrate colour` wrote.", refuse("file"))
      .other("left", "section", "", "none", "With `right`, instead of all other keys: the content of such a file.",
             refuse("left"))
      .other("right", "section", "", "none", "See `left`.", refuse("right"));
  return keys;
}

// Of (R - G)/Y and (B - G)/Y, Y = (R + 2G + B)/4: of green alone, and of red or blue alone; and the variance of numbers
// that are as often the one as the other.
constexpr double kLeastChroma = -2, kLargestChroma = 4, kLargestVariance = 9;

std::vector<ChromaComponent> components_from(const Config& config, const std::string& key) {
  std::vector<ChromaComponent> components;
  if (!config.has(key)) return components;
  for (const Config& section : config.sections(key)) {
    ChromaComponent component;
    const std::vector<double> mean = section.numbers("mean", 2);
    component.mean = Eigen::Vector2d(mean[0], mean[1]);
    if (std::min(mean[0], mean[1]) < kLeastChroma || std::max(mean[0], mean[1]) > kLargestChroma)
      section.fail("mean", fmt::format("two numbers from {} to {}", kLeastChroma, kLargestChroma));
    const std::vector<double> covariance = section.numbers("covariance", 3);  // uu, uv, vv
    component.covariance << covariance[0], covariance[1], covariance[1], covariance[2];
    const bool inside = covariance[0] > 0 && std::max(covariance[0], covariance[2]) <= kLargestVariance;
    if (!(inside && component.covariance.determinant() > 0))
      section.fail("covariance",
                   fmt::format("three numbers uu, uv, vv with 0 < uu, vv <= {} and uu vv > uv^2", kLargestVariance));
    component.weight = section.number("weight", 1e-12, 1e12, 1);
    section.finish();
    components.push_back(component);
  }
  return components;
}

ConfigKeys<ColourModel> model_keys() {
  ConfigKeys<ColourModel> keys("Colour file, sections left and right",
                               "Colours as one camera sees them, in chroma ratios ((R - G)/Y, (B - G)/Y): what "
                               "`multireach-calibrate colour` writes.");
  const std::string components = "list of maps `{mean: [u, v], covariance: [uu, uv, vv], weight: w}`";
  keys.other("object", components, "", "required", "Normal distributions of the object's chroma.",
             [](const Config& config, ColourModel& model) {
               model.object = components_from(config, "object");
               if (model.object.empty()) config.fail("object", "at least one component");
             })
      .other(
          "background", components, "", "none", "The same for everything else.",
          [](const Config& config, ColourModel& model) { model.background = components_from(config, "background"); });
  add_tolerance_keys(keys, "Largest Mahalanobis distance from a component of `object`.");
  keys.number(
      "noise_grey_levels", "grey levels", 0, 100, [](auto& m) -> auto& { return m.noise_grey_levels; },
      "Standard deviation of the camera's noise.");
  return keys;
}

ColourModel model_from(const Config& config) {
  ColourModel model;
  model_keys().read(config, model);
  return model;
}

std::array<ColourModel, 2> both_from(const Config& config) {
  std::array<ColourModel, 2> models{model_from(config.section("left")), model_from(config.section("right"))};
  config.finish();
  return models;
}

std::string text_of(const std::vector<ChromaComponent>& components) {
  std::string text;
  for (const ChromaComponent& c : components) {
    text += fmt::format("    - {{mean: [{}, {}], covariance: [{}, {}, {}], weight: {}}}\n", c.mean.x(), c.mean.y(),
                        c.covariance(0, 0), c.covariance(0, 1), c.covariance(1, 1), c.weight);
  }
  return text;
}

}  // namespace

ColourConfig colour_config_from(const Config& colour) {
  ColourConfig config;
  std::string where = colour.file() + ": section 'colour'";
  std::optional<vision::ColourClass> colours;
  if (colour.has("references")) {
    class_keys().read(colour, colours.emplace());
  } else if (colour.has("file")) {
    const std::string path = resolve_relative(colour.file(), colour.text("file"));
    colour.finish();
    config.file = read_text_file(path);
    where = path;
    config.models = both_from(Config::parse(path, config.file));
  } else if (colour.has("left")) {
    config.models = both_from(colour);
  } else {
    colour.fail("references", "'references' with colours, or 'file' with what multireach-calibrate colour wrote");
  }
  try {
    if (colours) config.models.fill(vision::model_of(*colours));
    for (const ColourModel& model : config.models) vision::check(model);
  } catch (const std::invalid_argument& fault) {
    throw InputError(where + ": " + fault.what());
  }
  return config;
}

std::string colour_config_reference() {
  return class_keys().reference() + "\n" + model_keys().reference();
}

std::string colour_text(const std::array<ColourModel, 2>& models) {
  std::string text =
      "# Colours of an object as each camera sees it: normal distributions of the chroma ((R - G)/Y, (B - G)/Y), "
      "Y = (R + 2G + B)/4.\n";
  for (size_t side = 0; side < 2; ++side) {
    const ColourModel& model = models[side];
    text += side == 0 ? "left:\n" : "right:\n";
    text += fmt::format("  tolerance: {}\n  min_luma: {}\n  max_luma: {}\n  noise_grey_levels: {}\n", model.tolerance,
                        model.min_luma, model.max_luma, model.noise_grey_levels);
    text += "  object:\n" + text_of(model.object);
    if (!model.background.empty()) text += "  background:\n" + text_of(model.background);
  }
  return text;
}

}  // namespace multireach
