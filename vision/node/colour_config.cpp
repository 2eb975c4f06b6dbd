#include "vision/node/colour_config.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "runtime/files.hpp"

namespace multireach {
namespace {

using vision::ChromaComponent;
using vision::ColourModel;

vision::ColourClass class_from(const Config& config) {
  vision::ColourClass colours;
  for (const Config& reference : config.sections("references")) {
    const std::vector<double> rgb = reference.numbers("rgb", 3);
    for (const double channel : rgb) {
      if (channel < 0 || channel > 255) reference.fail("rgb", "three numbers from 0 to 255");
    }
    if (rgb[0] + rgb[1] + rgb[2] < 1) reference.fail("rgb", "a colour that is not black");
    reference.finish();
    colours.references.push_back({rgb[0], rgb[1], rgb[2]});
  }
  if (colours.references.empty()) config.fail("references", "at least one colour");
  colours.tolerance = config.number("tolerance", 1e-6, 100, colours.tolerance);
  colours.min_luma = config.number("min_luma", 0, 255, colours.min_luma);
  colours.max_luma = config.number("max_luma", 0, 255, colours.max_luma);
  config.finish();
  return colours;
}

std::vector<ChromaComponent> components_from(const Config& config, const std::string& key) {
  std::vector<ChromaComponent> components;
  if (!config.has(key)) return components;
  for (const Config& section : config.sections(key)) {
    ChromaComponent component;
    component.mean = Eigen::Map<const Eigen::Vector2d>(section.numbers("mean", 2).data());
    const std::vector<double> covariance = section.numbers("covariance", 3);  // uu, uv, vv
    component.covariance << covariance[0], covariance[1], covariance[1], covariance[2];
    if (!(covariance[0] > 0 && component.covariance.determinant() > 0))
      section.fail("covariance", "three numbers uu, uv, vv with uu > 0 and uu vv > uv^2");
    component.weight = section.number("weight", 1e-12, 1e12, 1);
    section.finish();
    components.push_back(component);
  }
  return components;
}

ColourModel model_from(const Config& config) {
  ColourModel model;
  model.object = components_from(config, "object");
  if (model.object.empty()) config.fail("object", "at least one component");
  model.background = components_from(config, "background");
  model.tolerance = config.number("tolerance", 1e-6, 100, model.tolerance);
  model.min_luma = config.number("min_luma", 0, 255, model.min_luma);
  model.max_luma = config.number("max_luma", 0, 255, model.max_luma);
  model.noise_grey_levels = config.number("noise_grey_levels", 0, 100, model.noise_grey_levels);
  config.finish();
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
  if (colour.has("references")) {
    config.models.fill(vision::model_of(class_from(colour)));
  } else if (colour.has("file")) {
    const std::string path = beside(colour.file(), colour.text("file"));
    colour.finish();
    config.file = read_text_file(path);
    config.models = both_from(Config::parse(path, config.file));
  } else if (colour.has("left")) {
    config.models = both_from(colour);
  } else {
    colour.fail("references", "'references' with colours, or 'file' with what multireach-calibrate colour wrote");
  }
  for (const ColourModel& model : config.models) {
    try {
      vision::check(model);
    } catch (const std::invalid_argument& fault) {
      throw InputError(colour.file() + ": section 'colour': " + fault.what());
    }
  }
  return config;
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
