#include "runtime/config.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "runtime/config_keys.hpp"

namespace multireach {
namespace {

constexpr size_t kMaxText = size_t{4} << 20;  // bytes; parsed, it takes some hundred times as much memory

std::optional<double> finite_number(const YAML::Node& node) {
  double value = 0;
  if (!node.IsScalar() || !YAML::convert<double>::decode(node, value) || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// One step of an override's key: a key of a map and, if it holds a list, the index of an entry.
struct KeyStep {
  std::string name;
  std::optional<size_t> index;
};

std::vector<KeyStep> steps_of(const std::string& key, const std::string& fault) {
  std::vector<KeyStep> steps;
  for (size_t begin = 0; begin <= key.size();) {
    const size_t end = std::min(key.find('.', begin), key.size());
    KeyStep step{key.substr(begin, end - begin), {}};
    if (const size_t bracket = step.name.find('['); bracket != std::string::npos) {
      size_t index = 0;
      if (bracket + 2 >= step.name.size()) throw InputError(fault);
      const char* const last = step.name.data() + step.name.size() - 1;
      const auto [stopped, error] = std::from_chars(step.name.data() + bracket + 1, last, index);
      if (error != std::errc() || stopped != last || *last != ']') throw InputError(fault);
      step.index = index;
      step.name.resize(bracket);
    }
    if (step.name.empty()) throw InputError(fault);
    steps.push_back(std::move(step));
    begin = end + 1;
  }
  return steps;
}

/// Puts the value into the tree; maps that are missing on the way are made.
void apply(const ConfigOverride& given, const std::string& path, YAML::Node node) {
  const std::string name = path + ": '" + given.key + "' ";
  for (const KeyStep& step : steps_of(given.key, name + "is not a key; expected one as controller.gamma_rad2_m2")) {
    if (node.IsDefined() && !node.IsNull() && !node.IsMap())
      throw InputError(name + "cannot be set: '" + step.name + "' would be in a value that has no keys");
    node.reset(node[step.name]);
    if (!step.index) continue;
    if (!node.IsSequence() || *step.index >= node.size())
      throw InputError(name + "cannot be set: the list has " +
                       std::to_string(node.IsSequence() ? node.size() : size_t{0}) + " entries, counted from 0");
    node.reset(node[*step.index]);
  }
  try {
    node = YAML::Load(given.value);
  } catch (const YAML::Exception& error) {
    throw InputError(path + ": key '" + given.key + "' is '" + given.value +
                     "'; expected a value in YAML: " + error.msg);
  }
}

}  // namespace

ConfigOverride config_override_from(const std::string& option, const std::string& text) {
  const size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
    throw InputError(option + " is '" + text + "'; expected KEY=VALUE, as controller.gamma_rad2_m2=350");
  return {text.substr(0, equals), text.substr(equals + 1)};
}

std::string text_of(const ConfigOverrides& overrides) {
  std::string text;
  for (const ConfigOverride& given : overrides) text += "\n" + given.key + "=" + given.value;
  return text;
}

Config::Config(std::string file, std::string path, const YAML::Node& node, OverriddenKeys overridden)
    : file_(std::move(file)),
      path_(std::move(path)),
      node_(node),
      overridden_(std::move(overridden)),
      asked_(std::make_shared<std::set<std::string>>()) {
  if (!node_.IsMap())
    throw InputError(file_ + ": " + (path_.empty() ? "the file" : "'" + path_ + "'") + " must hold keys and values");
  std::set<std::string> seen;
  for (const auto& item : node_) {
    if (!item.first.IsScalar()) {
      throw InputError(file_ + ":" + std::to_string(item.first.Mark().line + 1) + ": a key must be a word");
    }
    const std::string key = item.first.as<std::string>();
    if (!seen.insert(key).second) {
      throw InputError(file_ + ":" + std::to_string(item.first.Mark().line + 1) + ": key '" + full(key) +
                       "' stands twice");
    }
  }
}

Config Config::load(const std::string& path, const ConfigOverrides& overrides) {
  return parse(path, read_text_file(path), overrides);
}

Config Config::parse(const std::string& path, const std::string& text, const ConfigOverrides& overrides) {
  if (text.size() > kMaxText) throw InputError(path + ": is larger than 4 MB, the most that a configuration may have");
  try {
    const YAML::Node node = YAML::Load(text);
    auto keys = std::make_shared<std::vector<std::string>>();
    for (const ConfigOverride& given : overrides) {
      apply(given, path, node);
      keys->push_back(given.key);
    }
    return Config(path, "", node, std::move(keys));
  } catch (const YAML::Exception& error) {
    throw InputError(path + ":" + std::to_string(error.mark.line + 1) + ": is not valid YAML: " + error.msg);
  }
}

std::string Config::full(const std::string& key) const {
  return path_.empty() ? key : path_ + "." + key;
}

std::string Config::place_of(const std::string& key, const YAML::Node& node) const {
  const std::string name = full(key);
  const auto covers = [&](const std::string& set) {
    return name.starts_with(set) && (name.size() == set.size() || name[set.size()] == '.' || name[set.size()] == '[');
  };
  if (std::ranges::any_of(*overridden_, covers)) return file_;
  return file_ + ":" + std::to_string(node.Mark().line + 1);
}

void Config::fail(const std::string& key, const std::string& expected) const {
  const YAML::Node node = static_cast<const YAML::Node&>(node_)[key];
  std::string value;
  if (node.IsDefined() && node.IsScalar()) value = " is '" + node.Scalar() + "';";
  throw InputError(place_of(key, node.IsDefined() ? node : node_) + ": key '" + full(key) + "'" + value + " expected " +
                   expected);
}

void Config::refuse(const std::string& key, const std::string& condition) const {
  const YAML::Node node = static_cast<const YAML::Node&>(node_)[key];
  throw InputError(place_of(key, node) + ": key '" + full(key) + "' is allowed only " + condition);
}

std::optional<YAML::Node> Config::find(const std::string& key) const {
  asked_->insert(key);
  const YAML::Node node = static_cast<const YAML::Node&>(node_)[key];
  if (!node.IsDefined() || node.IsNull()) return std::nullopt;
  return node;
}

YAML::Node Config::get(const std::string& key) const {
  const auto node = find(key);
  if (!node) throw InputError(place_of(key, node_) + ": key '" + full(key) + "' is missing");
  return *node;
}

bool Config::has(const std::string& key) const {
  return find(key).has_value();
}

double Config::number(const std::string& key, double min, double max, std::optional<double> otherwise) const {
  if (otherwise && !has(key)) return *otherwise;
  const auto value = finite_number(get(key));
  if (!value || *value < min || *value > max) fail(key, "a " + config_range(min, max));
  return *value;
}

int64_t Config::integer(const std::string& key, int64_t min, int64_t max, std::optional<int64_t> otherwise) const {
  if (otherwise && !has(key)) return *otherwise;
  const YAML::Node node = get(key);
  int64_t value = 0;
  if (!node.IsScalar() || !YAML::convert<int64_t>::decode(node, value) || value < min || value > max) {
    fail(key, "a whole number from " + std::to_string(min) + " to " + std::to_string(max));
  }
  return value;
}

bool Config::flag(const std::string& key, std::optional<bool> otherwise) const {
  if (otherwise && !has(key)) return *otherwise;
  bool value = false;
  const YAML::Node node = get(key);
  if (!node.IsScalar() || !YAML::convert<bool>::decode(node, value)) fail(key, "true or false");
  return value;
}

std::string Config::text(const std::string& key, std::optional<std::string> otherwise) const {
  if (otherwise && !has(key)) return *otherwise;
  const YAML::Node node = get(key);
  if (!node.IsScalar()) fail(key, "a text");
  return node.Scalar();
}

std::string Config::choice(const std::string& key, std::initializer_list<std::string_view> words,
                           std::optional<std::string> otherwise) const {
  std::string value = text(key, std::move(otherwise));
  if (std::ranges::find(words, value) == words.end()) {
    std::string list;
    for (const std::string_view word : words) list += (list.empty() ? "one of " : ", ") + std::string(word);
    fail(key, list);
  }
  return value;
}

std::vector<double> Config::numbers(const std::string& key, int size,
                                    std::optional<std::vector<double>> otherwise) const {
  if (otherwise && !has(key)) return *otherwise;
  const std::string expected = "a list of " + (size < 0 ? "" : std::to_string(size) + " ") + "finite numbers";
  const YAML::Node node = get(key);
  if (!node.IsSequence() || (size >= 0 && static_cast<int>(node.size()) != size)) fail(key, expected);
  std::vector<double> values;
  for (const YAML::Node& item : node) {
    const auto value = finite_number(item);
    if (!value) fail(key, expected);
    values.push_back(*value);
  }
  return values;
}

std::vector<double> Config::matrix(const std::string& key, int rows, int columns) const {
  const std::string expected = std::to_string(rows) + " lists of " + std::to_string(columns) + " finite numbers";
  const YAML::Node node = get(key);
  if (!node.IsSequence() || static_cast<int>(node.size()) != rows) fail(key, expected);
  std::vector<double> values;
  for (const YAML::Node& row : node) {
    if (!row.IsSequence() || static_cast<int>(row.size()) != columns) fail(key, expected);
    for (const YAML::Node& item : row) {
      const auto value = finite_number(item);
      if (!value) fail(key, expected);
      values.push_back(*value);
    }
  }
  return values;
}

std::vector<std::string> Config::texts(const std::string& key) const {
  const YAML::Node node = get(key);
  if (!node.IsSequence()) fail(key, "a list of texts");
  std::vector<std::string> values;
  for (const YAML::Node& item : node) {
    if (!item.IsScalar()) fail(key, "a list of texts");
    values.push_back(item.Scalar());
  }
  return values;
}

std::map<std::string, double> Config::named_numbers(const std::string& key) const {
  const YAML::Node node = get(key);
  if (!node.IsMap()) fail(key, "names with finite numbers");
  std::map<std::string, double> values;
  for (const auto& item : node) {
    const auto value = finite_number(item.second);
    if (!value || !item.first.IsScalar()) fail(key, "names with finite numbers");
    values[item.first.as<std::string>()] = *value;
  }
  return values;
}

Config Config::section(const std::string& key) const {
  return Config(file_, full(key), get(key), overridden_);
}

std::vector<Config> Config::sections(const std::string& key) const {
  const YAML::Node node = get(key);
  if (!node.IsSequence()) fail(key, "a list");
  std::vector<Config> list;
  for (size_t i = 0; i < node.size(); ++i)
    list.push_back(Config(file_, full(key) + "[" + std::to_string(i) + "]", node[i], overridden_));
  return list;
}

void Config::finish(std::initializer_list<std::string_view> others) const {
  for (const auto& item : node_) {
    const std::string key = item.first.as<std::string>();
    if (asked_->contains(key) || std::ranges::find(others, key) != others.end()) continue;
    std::string known;
    for (const std::string& name : *asked_) known += (known.empty() ? "" : ", ") + name;
    throw InputError(place_of(key, item.first) + ": key '" + full(key) + "' is not known; known here: " + known);
  }
}

}  // namespace multireach
