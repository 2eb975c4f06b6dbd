#pragma once

#include <array>
#include <string>

#include "runtime/config.hpp"
#include "vision/colour/colour_model.hpp"

namespace multireach {

/// The colours of one target, as the left and the right camera see it.
struct ColourConfig {
  std::array<vision::ColourModel, 2> models;
  std::string file;  ///< the bytes of the file that the section names, which belong to its digest; "" for none
};

/// Section `colour` of a vision file. Either `references` with tolerance, darkest and brightest, for both cameras; or
/// the `file` that `multireach-calibrate colour` wrote (as seen from the vision file), or what is in it: `left` and
/// `right`. Throws InputError.
ColourConfig colour_config_from(const Config& colour);

/// The text of a file of both models.
std::string colour_text(const std::array<vision::ColourModel, 2>& models);

}  // namespace multireach
