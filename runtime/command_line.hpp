#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

// CLI11 stays behind this interface: a source that includes it takes some seconds more to compile.
namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace multireach {

/// An option or an argument of a command line, for further properties: `.required()`.
class CommandOption {
 public:
  explicit CommandOption(CLI::Option* option) : option_(option) {}

  CommandOption& required();
  /// --help shows the value from before parsing.
  CommandOption& show_default();
  /// Refuses values that are not finite numbers from `min` to `max`.
  CommandOption& finite(double min, double max);
  /// Refuses values that are not whole numbers from `min` to `max`.
  CommandOption& whole(int64_t min, int64_t max);
  CommandOption& one_of(const std::vector<std::string>& words);
  /// Takes exactly this many values, which --help calls `names`.
  CommandOption& values(int count, const std::string& names);
  CommandOption& values(int least, int most, const std::string& names);
  /// One argument holds all values, with commas between them.
  CommandOption& comma_separated();
  /// May be given several times, each time with one value.
  CommandOption& repeated();
  /// Unless given, the value is that of this environment variable.
  CommandOption& environment(const std::string& variable);
  CommandOption& needs(const CommandOption& other);
  CommandOption& excludes(const CommandOption& other);

 private:
  CLI::Option* option_;
};

/// The command line of a program, or of one of its subcommands. Copies refer to the same command line.
class CommandLine {
 public:
  CommandLine(const std::string& program, const std::string& description, const std::string& version);

  /// Adds an option (a name with dashes) or an argument (without) that sets `value`: a std::string, double, int,
  /// int64_t or uint64_t, a std::optional of one of them, or several std::strings or doubles.
  template <class Value>
  CommandOption option(const std::string& name, Value& value, const std::string& help);
  CommandOption flag(const std::string& name, bool& value, const std::string& help);
  /// Adds an option that prints `text()` and ends the program.
  void information(const std::string& name, std::function<std::string()> text, const std::string& help);

  CommandLine subcommand(const std::string& name, const std::string& help);
  /// One of the subcommands must be given.
  void require_subcommand();
  /// Options of the whole program may also follow the subcommand; of a subcommand: this one lets them.
  void fallthrough();
  /// The names, without dashes, of the options and arguments that were given to this command line, in their order: a
  /// name once for each word that is a value of it.
  std::vector<std::string> order() const;
  /// Whether this subcommand was given.
  bool given() const;

  /// Reads the arguments. Returns an exit code where the program must end: after --help and the like, and, with a
  /// sentence on standard error, after a mistake.
  [[nodiscard]] std::optional<int> parse(int argc, char** argv);

 private:
  explicit CommandLine(std::shared_ptr<CLI::App> app) : app_(std::move(app)) {}

  std::shared_ptr<CLI::App> app_;
};

}  // namespace multireach
