#include "tools/replay/sweep_command.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "runtime/progress.hpp"
#include "tools/replay/sweep.hpp"

namespace multireach {

SweepCommand::SweepCommand(CommandLine& program)
    : command_(program.subcommand("sweep",
                                  "replay a session with every combination of some keys' values: a table of "
                                  "the report's figures")),
      jobs_(request_.threads) {
  request_.add_to(command_, false);
  command_
      .option("--set", request_.setup.set,
              "KEY=V1,V2,...: values of a key of robot.yaml or vision.yaml, as controller.gamma_rad2_m2=100,350; may "
              "be repeated")
      .repeated();
  command_.option("--jobs", jobs_, "replays at the same time; does not affect the result (default: all processors)")
      .whole(1, 1024);
  command_.option("--shard", shard_, "i/n: run only part i of n; i from 0 to n - 1").show_default();
  command_.option("-o,--output", table_, "CSV file of the table; - for standard output, the default without --json");
  command_.option("--json", json_, "JSON file of the table, which merge reads; - for standard output");
  merging_ = command_.subcommand("merge", "merge the results of all shards of a sweep");
  merging_->option("files", parts_, "JSON files of the shards").required();
  merging_->option("-o,--output", table_, "CSV file of the table; - for standard output, the default without --json");
  merging_->option("--json", json_, "JSON file of the table; - for standard output");
}

int SweepCommand::run() {
  if (table_.empty() && json_.empty()) table_ = std::string(1, '-');
  check_outputs({table_, json_});
  if (!merging_->given()) return sweep();
  write(merged_sweep(parts_));
  return 0;
}

void SweepCommand::write(const nlohmann::ordered_json& result) const {
  const std::string table = [&] {
    try {
      return sweep_table(result);
    } catch (const nlohmann::json::exception& error) {
      throw InputError(std::string("a shard is not a result of multireach-replay sweep: ") + error.what());
    }
  }();
  if (!table_.empty()) write_text_file(table_, table);
  if (!json_.empty())
    write_text_file(json_, result.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

int SweepCommand::sweep() const {
  if (request_.session.empty()) throw InputError("sweep: SESSION is missing; see sweep --help");
  if (request_.setup.set.empty())
    throw InputError("sweep: --set is missing; expected --set KEY=V1,V2,... at least once");
  std::vector<SweptKey> keys;
  for (const std::string& text : request_.setup.set) keys.push_back(swept_key_from(text));
  const ReplayFrom source = request_.source();
  const SweepJob job{.grid = SweepGrid(keys),
                     .options = [&](const ConfigOverrides& overrides) { return request_.options(source, overrides); },
                     .shard = shard_from(shard_),
                     .jobs = jobs_};
  check_sweep(job);

  const ReplayOptions first = job.options(job.grid.overrides(0));
  nlohmann::ordered_json result{{"session", std::filesystem::path(request_.session).filename().string()},
                                {"session_bytes", std::filesystem::file_size(request_.session)},
                                {"robot_digest", fmt::format("{:016x}", static_cast<uint64_t>(first.config.digest))}};
  if (first.vision) result["vision_digest"] = fmt::format("{:016x}", static_cast<uint64_t>(first.vision->digest));
  result["robot_model"] = request_.robot;
  result["start_with"] = source == ReplayFrom::kImages ? "images" : "targets";
  result["until_s"] = request_.until_s;
  result["keys"] = nlohmann::ordered_json::object();
  for (const SweptKey& key : keys) result["keys"][key.key] = key.values;
  result["combinations"] = job.grid.size();
  result["shard"] = shard_;
  Progress progress;
  result["rows"] = sweep_rows(job, [&](double part) { progress.show(part); });
  progress.end();
  write(result);
  return 0;
}

}  // namespace multireach
