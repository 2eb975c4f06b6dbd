#include "runtime/config_keys.hpp"

#include <cmath>

namespace multireach {

std::string config_number(double value) {
  // %g keeps six digits, which hides the rounding of a conversion of units, as of 0.2 s kept as microseconds.
  return fmt::format("{:g}", value);
}

std::string config_range(double min, double max) {
  if (std::isinf(min) && std::isinf(max)) return "finite number";
  if (std::isinf(max)) return "number of at least " + config_number(min);
  if (std::isinf(min)) return "number of at most " + config_number(max);
  return "number from " + config_number(min) + " to " + config_number(max);
}

std::string config_reference(const std::string& heading, const std::string& meaning,
                             const std::vector<ConfigKey>& keys) {
  std::string page =
      "## " + heading + "\n\n" + meaning + "\n\n| key | value | unit | default | meaning |\n|---|---|---|---|---|\n";
  for (const ConfigKey& key : keys) {
    page +=
        "| `" + key.name + "` | " + key.value + " | " + key.unit + " | " + key.initial + " | " + key.meaning + " |\n";
  }
  return page;
}

}  // namespace multireach
