#pragma once

#include <yaml-cpp/yaml.h>

#include <initializer_list>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/files.hpp"

namespace multireach {

/// A value that replaces one of a configuration file: `key` with its path, as `controller.gamma_rad2_m2` or
/// `targets[0].sigma_px`, and `value` in YAML.
struct ConfigOverride {
  std::string key, value;
};
/// "KEY=VALUE" as given to `option`. Throws InputError.
ConfigOverride config_override_from(const std::string& option, const std::string& text);
using ConfigOverrides = std::vector<ConfigOverride>;
/// All of them as one text, for digests; empty without any.
std::string text_of(const ConfigOverrides& overrides);

/// A YAML map that is read key by key. Every error is an InputError that names file, line and key, and says what was
/// expected. `finish` refuses keys that were never read, so a misspelt key is never ignored.
class Config {
 public:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();

  /// Errors in a value that `overrides` gives name its key, without a line.
  static Config load(const std::string& path, const ConfigOverrides& overrides = {});
  /// Parses `text`; errors call it `path`.
  static Config parse(const std::string& path, const std::string& text, const ConfigOverrides& overrides = {});

  const std::string& file() const { return file_; }
  bool has(const std::string& key) const;
  /// Throws InputError when the key is missing.
  void require(const std::string& key) const { get(key); }

  /// A finite number from `min` to `max`. The key is required unless `otherwise` gives a default.
  double number(const std::string& key, double min, double max, std::optional<double> otherwise = {}) const;
  int64_t integer(const std::string& key, int64_t min, int64_t max, std::optional<int64_t> otherwise = {}) const;
  bool flag(const std::string& key, std::optional<bool> otherwise = {}) const;
  std::string text(const std::string& key, std::optional<std::string> otherwise = {}) const;
  /// A text that must be one of `words`.
  std::string choice(const std::string& key, std::initializer_list<std::string_view> words,
                     std::optional<std::string> otherwise = {}) const;
  /// A list of `size` finite numbers; -1 accepts any length.
  std::vector<double> numbers(const std::string& key, int size,
                              std::optional<std::vector<double>> otherwise = {}) const;
  /// A matrix, row by row: a list with one list for each row.
  std::vector<double> matrix(const std::string& key, int rows, int columns) const;
  /// A list of texts.
  std::vector<std::string> texts(const std::string& key) const;
  /// A map from names to finite numbers.
  std::map<std::string, double> named_numbers(const std::string& key) const;
  /// A required map, or a required list of maps.
  Config section(const std::string& key) const;
  std::vector<Config> sections(const std::string& key) const;

  /// Throws when the map has a key that was neither read nor listed in `others`.
  void finish(std::initializer_list<std::string_view> others = {}) const;
  /// Throws InputError: the value of `key` is not what was `expected`.
  [[noreturn]] void fail(const std::string& key, const std::string& expected) const;
  /// Throws InputError: `key` is allowed only as `condition` states, e.g. "with law: paper".
  [[noreturn]] void refuse(const std::string& key, const std::string& condition) const;

 private:
  using OverriddenKeys = std::shared_ptr<const std::vector<std::string>>;
  Config(std::string file, std::string path, const YAML::Node& node, OverriddenKeys overridden);
  std::optional<YAML::Node> find(const std::string& key) const;
  YAML::Node get(const std::string& key) const;
  std::string full(const std::string& key) const;
  /// Where a key stands, for errors: "file:line", or "file" with its value set by an override.
  std::string place_of(const std::string& key, const YAML::Node& node) const;

  std::string file_;
  std::string path_;  // dotted path of keys from the top of the file to this map
  YAML::Node node_;
  OverriddenKeys overridden_;
  std::shared_ptr<std::set<std::string>> asked_;
};

}  // namespace multireach
