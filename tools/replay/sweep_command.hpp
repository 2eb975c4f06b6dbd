#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/replay/request.hpp"

namespace multireach {

/// The subcommand `sweep`.
class SweepCommand {
 public:
  explicit SweepCommand(CommandLine& program);
  bool given() const { return command_.given(); }
  /// Returns the exit code.
  int run();

 private:
  int sweep() const;
  void write(const nlohmann::ordered_json& result) const;

  CommandLine command_;
  std::optional<CommandLine> merging_;
  RunRequest request_;
  std::vector<std::string> parts_;
  std::string shard_ = "0/1", table_, json_;
  int jobs_;
};

}  // namespace multireach
