#pragma once

#include <fmt/format.h>

#include <concepts>
#include <functional>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "runtime/config.hpp"

namespace multireach {

/// One key of a configuration file, as the reference page (docs/configuration.md) shows it.
struct ConfigKey {
  std::string name;
  std::string value;    ///< type and range, e.g. "number from 0 to 1"
  std::string unit;     ///< empty where there is none
  std::string initial;  ///< the default, or "required"
  std::string meaning;  ///< one sentence or two
};

/// The keys as a Markdown section: heading, sentence, table.
std::string config_reference(const std::string& heading, const std::string& meaning,
                             const std::vector<ConfigKey>& keys);
/// A number as the reference page and the error messages write it.
std::string config_number(double value);
/// "number from 0 to 1", "number of at least 0", "number".
std::string config_range(double min, double max);

/// The keys of one section of a configuration file, each declared once: the declaration reads the key and writes its
/// row of the reference page. `T` receives the values; the members of a default-constructed T are the defaults.
///
///     const auto keys = ConfigKeys<Options>("bridge", "Options of the bridge.")
///         .number("delay_ms", "ms", 0, 1000, [](auto& o) -> auto& { return o.delay_us; }, "How late ...", 1e3);
///     keys.read(config, options);
template <class T>
class ConfigKeys {
 public:
  ConfigKeys(std::string heading, std::string meaning) : heading_(std::move(heading)), meaning_(std::move(meaning)) {}

  /// A number in the file's unit; the member, a double, int or int64_t, or a std::optional of it, holds `scale` times
  /// the number. Where the member is a std::optional, the key has no default; otherwise() can tell what then happens.
  template <class Member>
  ConfigKeys& number(const std::string& name, const std::string& unit, double min, double max, Member member,
                     const std::string& meaning, double scale = 1) {
    const T defaults{};
    const auto& initial = member(defaults);
    std::string text = "none";
    if constexpr (!kIsOptional<std::remove_cvref_t<decltype(initial)>>) {
      text = config_number(static_cast<double>(initial) / scale);
    }
    return add({name, config_range(min, max), unit, text, meaning}, [=](const Config& config, T& options) {
      if (!config.has(name)) return;
      auto& value = member(options);
      using Value = std::remove_cvref_t<decltype(value)>;
      const double read = config.number(name, min, max) * scale;
      if constexpr (std::integral<Value>) {
        value = static_cast<Value>(read);
      } else {
        value = read;
      }
    });
  }

  /// A whole number.
  template <class Member>
  ConfigKeys& integer(const std::string& name, const std::string& unit, int64_t min, int64_t max, Member member,
                      const std::string& meaning) {
    const T defaults{};
    const auto& initial = member(defaults);
    std::string text = "none";
    if constexpr (!kIsOptional<std::remove_cvref_t<decltype(initial)>>) text = fmt::format("{}", initial);
    const std::string type = max == INT64_MAX ? fmt::format("whole number of at least {}", min)
                                              : fmt::format("whole number from {} to {}", min, max);
    return add({name, type, unit, text, meaning}, [=](const Config& config, T& options) {
      if (!config.has(name)) return;
      auto& value = member(options);
      value = static_cast<typename Plain<std::remove_cvref_t<decltype(value)>>::Type>(config.integer(name, min, max));
    });
  }

  template <class Member>
  ConfigKeys& flag(const std::string& name, Member member, const std::string& meaning) {
    const T defaults{};
    return add({name, "true or false", "", member(defaults) ? "true" : "false", meaning},
               [=](const Config& config, T& options) { member(options) = config.flag(name, member(options)); });
  }

  /// A text. Where the member is a std::optional, the key has no default.
  template <class Member>
  ConfigKeys& text(const std::string& name, Member member, const std::string& meaning) {
    const T defaults{};
    const auto& initial = member(defaults);
    std::string text = "none";
    if constexpr (!kIsOptional<std::remove_cvref_t<decltype(initial)>>) text = "`" + initial + "`";
    return add({name, "text", "", text, meaning}, [=](const Config& config, T& options) {
      if (config.has(name)) member(options) = config.text(name);
    });
  }

  /// One of several words, each with its value.
  template <class Value, class Member>
  ConfigKeys& choice(const std::string& name, std::vector<std::pair<std::string, Value>> words, Member member,
                     const std::string& meaning) {
    const T defaults{};
    const Value initial = member(defaults);
    std::string list, text;
    for (const auto& [word, value] : words) {
      list += (list.empty() ? "`" : ", `") + word + "`";
      if (value == initial) text = "`" + word + "`";
    }
    return add({name, list, "", text, meaning}, [=](const Config& config, T& options) {
      if (!config.has(name)) return;
      const std::string given = config.text(name);
      for (const auto& [word, value] : words) {
        if (word == given) {
          member(options) = value;
          return;
        }
      }
      std::string expected = "one of ";
      for (const auto& [word, value] : words) expected += (word == words.front().first ? "" : ", ") + word;
      config.fail(name, expected);
    });
  }

  /// Any other value; `reader`, a function of (const Config&, T&), reads it and handles its absence.
  template <class Read>
  ConfigKeys& other(const std::string& name, const std::string& value, const std::string& unit,
                    const std::string& initial, const std::string& meaning, Read reader) {
    return add({name, value, unit, initial, meaning}, std::move(reader));
  }

  /// States the default of the key declared last, where the member's own value does not tell it.
  ConfigKeys& otherwise(const std::string& initial) {
    entries_.back().key.initial = initial;
    return *this;
  }
  /// The key declared last must be given.
  ConfigKeys& required() {
    auto& entry = entries_.back();
    entry.key.initial = "required";
    entry.read = [name = entry.key.name, reader = entry.read](const Config& config, T& options) {
      config.require(name);
      reader(config, options);
    };
    return *this;
  }
  /// Keys declared from here on are allowed only while `condition` holds for the values read so far; `words` state it,
  /// as "with law: guarded".
  ConfigKeys& only(const std::string& words, std::function<bool(const T&)> condition) {
    condition_ = std::move(condition);
    condition_words_ = words;
    return *this;
  }

  /// Reads all keys in the order of their declaration. Throws InputError for a bad value, a missing required key, and a
  /// key that is not allowed here; `finish` also refuses all keys that were never read.
  void read(const Config& config, T& options, bool finish = true) const {
    for (const Entry& entry : entries_) {
      if (entry.condition && !entry.condition(options)) {
        if (config.has(entry.key.name)) config.refuse(entry.key.name, entry.condition_words);
        continue;
      }
      entry.read(config, options);
    }
    if (finish) config.finish();
  }

  /// The section of the reference page.
  std::string reference() const {
    std::vector<ConfigKey> keys;
    for (const Entry& entry : entries_) {
      keys.push_back(entry.key);
      if (!entry.condition_words.empty()) keys.back().meaning += " Only " + entry.condition_words + ".";
    }
    return config_reference(heading_, meaning_, keys);
  }

 private:
  template <class Value>
  struct Plain {
    using Type = Value;
  };
  template <class Value>
  struct Plain<std::optional<Value>> {
    using Type = Value;
  };
  template <class Value>
  static constexpr bool kIsOptional = !std::is_same_v<typename Plain<Value>::Type, Value>;

  struct Entry {
    ConfigKey key;
    std::function<void(const Config&, T&)> read;
    std::function<bool(const T&)> condition;
    std::string condition_words;
  };

  ConfigKeys& add(ConfigKey key, std::function<void(const Config&, T&)> reader) {
    entries_.push_back({std::move(key), std::move(reader), condition_, condition_words_});
    return *this;
  }

  std::string heading_, meaning_;
  std::vector<Entry> entries_;
  std::function<bool(const T&)> condition_;
  std::string condition_words_;
};

}  // namespace multireach
