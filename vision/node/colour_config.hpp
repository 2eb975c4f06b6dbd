#pragma once

#include <array>
#include <string>

#include "runtime/config.hpp"
#include "vision/colour/colour_model.hpp"

namespace multireach {

/// The colours of one target, as the left and the right camera see it.
struct ColourConfig {
  std::array<vision::ColourModel, 2> models;
  std::string file;  ///< content of the file that the section names, to be included in the digest; "" for none
};

/// Reads section `colour` of a vision file. The section has one of: `references` with `tolerance`, `min_luma` and
/// `max_luma`, for both cameras; `file`, written by `multireach-calibrate colour`, its path relative to the vision
/// file; or that file's content, `left` and `right`. Throws InputError.
ColourConfig colour_config_from(const Config& colour);

/// The sections on colours of the reference page.
std::string colour_config_reference();

/// The YAML text of both models, readable as `file`.
std::string colour_text(const std::array<vision::ColourModel, 2>& models);

}  // namespace multireach
