#include "runtime/command_line.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <iostream>

namespace multireach {
namespace {

constexpr double kPlausible = 1e6;  // a range as wide as this only keeps typing errors away: --help leaves it out

/// What is wrong with the command line. For an unknown subcommand CLI11 only says that one is missing.
std::string fault_of(const CLI::App& app, const CLI::ParseError& error) {
  const std::vector<std::string> unknown = app.remaining();
  const auto subcommands = app.get_subcommands([](const CLI::App*) { return true; });
  if (error.get_exit_code() != static_cast<int>(CLI::ExitCodes::RequiredError) || unknown.empty() ||
      subcommands.empty() || !app.get_subcommands().empty())
    return error.what();
  std::string names;
  for (const CLI::App* each : subcommands) names += (names.empty() ? "" : ", ") + each->get_name();
  return fmt::format("'{}' is unknown; expected one of {}", unknown.front(), names);
}

}  // namespace

CommandOption& CommandOption::required() {
  option_->required();
  return *this;
}

CommandOption& CommandOption::show_default() {
  option_->capture_default_str();
  return *this;
}

CommandOption& CommandOption::finite(double min, double max) {
  // CLI::Range accepts NaN.
  option_->check(CLI::Validator(
      [=](std::string& text) {
        double value = 0;
        const bool number = CLI::detail::lexical_cast(text, value);
        if (number && std::isfinite(value) && value >= min && value <= max) return std::string();
        return fmt::format("'{}' is not a finite number from {} to {}", text, min, max);
      },
      min <= -kPlausible && max >= kPlausible ? std::string() : fmt::format("FROM {} TO {}", min, max)));
  return *this;
}

CommandOption& CommandOption::whole(int64_t min, int64_t max) {
  option_->check(CLI::Range(min, max));
  return *this;
}

CommandOption& CommandOption::one_of(const std::vector<std::string>& words) {
  option_->check(CLI::IsMember(words));
  return *this;
}

CommandOption& CommandOption::values(int count, const std::string& names) {
  option_->expected(count)->type_name(names);
  return *this;
}

CommandOption& CommandOption::values(int least, int most, const std::string& names) {
  option_->expected(least, most)->type_name(names);
  return *this;
}

CommandOption& CommandOption::comma_separated() {
  option_->delimiter(',');
  return *this;
}

CommandOption& CommandOption::repeated() {
  option_->allow_extra_args(false)->take_all();
  return *this;
}

CommandOption& CommandOption::environment(const std::string& variable) {
  option_->envname(variable);
  return *this;
}

CommandOption& CommandOption::needs(const CommandOption& other) {
  option_->needs(other.option_);
  return *this;
}

CommandOption& CommandOption::excludes(const CommandOption& other) {
  option_->excludes(other.option_);
  return *this;
}

CommandLine::CommandLine(const std::string& program, const std::string& description, const std::string& version)
    : app_(std::make_shared<CLI::App>(description, program)) {
  app_->set_version_flag("--version", version);
  app_->get_formatter()->column_width(34);
}

template <class Value>
CommandOption CommandLine::option(const std::string& name, Value& value, const std::string& help) {
  return CommandOption(app_->add_option(name, value, help));
}
template CommandOption CommandLine::option(const std::string&, std::string&, const std::string&);
template CommandOption CommandLine::option(const std::string&, double&, const std::string&);
template CommandOption CommandLine::option(const std::string&, int&, const std::string&);
template CommandOption CommandLine::option(const std::string&, int64_t&, const std::string&);
template CommandOption CommandLine::option(const std::string&, uint64_t&, const std::string&);
template CommandOption CommandLine::option(const std::string&, std::optional<std::string>&, const std::string&);
template CommandOption CommandLine::option(const std::string&, std::optional<double>&, const std::string&);
template CommandOption CommandLine::option(const std::string&, std::optional<int>&, const std::string&);
template CommandOption CommandLine::option(const std::string&, std::optional<int64_t>&, const std::string&);
template CommandOption CommandLine::option(const std::string&, std::vector<std::string>&, const std::string&);
template CommandOption CommandLine::option(const std::string&, std::vector<double>&, const std::string&);

CommandOption CommandLine::flag(const std::string& name, bool& value, const std::string& help) {
  return CommandOption(app_->add_flag(name, value, help));
}

void CommandLine::information(const std::string& name, std::function<std::string()> text, const std::string& help) {
  const auto print = [text = std::move(text)] {
    std::cout << text();
    throw CLI::Success();
  };
  app_->add_flag_callback(name, print, help);
}

CommandLine CommandLine::subcommand(const std::string& name, const std::string& help) {
  return CommandLine(std::shared_ptr<CLI::App>(app_, app_->add_subcommand(name, help)));
}

void CommandLine::require_subcommand() {
  app_->require_subcommand(1);
}

void CommandLine::fallthrough() {
  app_->fallthrough();
}

std::vector<std::string> CommandLine::order() const {
  std::vector<std::string> names;
  for (const CLI::Option* option : app_->parse_order()) names.push_back(option->get_single_name());
  return names;
}

bool CommandLine::given() const {
  return app_->parsed();
}

std::optional<int> CommandLine::parse(int argc, char** argv) {
  try {
    app_->parse(argc, argv);
  } catch (const CLI::Success& asked) {
    const int code = app_->exit(asked);
    if (std::cout.flush()) return code;
    std::cerr << app_->get_name() << ": standard output: cannot be written\n";
    return 1;
  } catch (const CLI::ParseError& error) {
    const std::string name = app_->get_name();
    std::cerr << name << ": " << fault_of(*app_, error) << "; see " << name << " --help\n";
    return 2;
  }
  return std::nullopt;
}

}  // namespace multireach
