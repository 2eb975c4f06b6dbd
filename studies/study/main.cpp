// multireach-study: runs many random reaches and counts failures and limit violations.
#include <fmt/format.h>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "runtime/files.hpp"
#include "runtime/message_clock.hpp"
#include "runtime/program.hpp"
#include "runtime/progress.hpp"
#include "runtime/shard.hpp"
#include "studies/gain_options.hpp"
#include "studies/joint_options.hpp"
#include "studies/straightness/straightness.hpp"
#include "studies/study/shard_progress.hpp"
#include "studies/study/study.hpp"
#include "studies/throws/throws.hpp"
#include "studies/tracking/tracking.hpp"

namespace multireach {
namespace {

struct Options {
  std::string urdf, base, tip, law = "guarded", gamma_text, acceleration, joint_weights, shard = "0/1",
                               targets = "space", json, csv, failures;
  int64_t samples = 10000, trace_sample = -1;
  uint64_t seed = 1;
  int threads = static_cast<int>(std::thread::hardware_concurrency());
  double drift_m = 0.01;
  GainOptions gains;
  std::vector<std::string> merge;
  std::string folder = ".";
  ThrowOptions throwing{};
  std::optional<double> radius_m;
  int nodes = 4000;
};

std::vector<double> gammas_of(const std::string& text, const Chain& chain, const std::string& law) {
  if (text.empty()) {
    return {law == "guarded" ? controller::GuardedLaw(chain).largest_gamma() : controller::PaperParameters{}.gamma};
  }
  std::vector<double> gammas = parse_numbers("--gamma", text);
  for (const double gamma : gammas) {
    if (!(gamma >= 0 && gamma <= 1e12))
      throw InputError("--gamma '" + text + "' has a value outside 0 to 1e12 rad^2/m^2");
  }
  return gammas;
}

std::string list_of(const Eigen::VectorXd& values) {
  std::string text;
  for (const double value : values) {
    char number[40];
    std::snprintf(number, sizeof number, "%s%.17g", text.empty() ? "" : ",", value);
    text += number;
  }
  return text;
}

/// Quotes a text so that a shell takes it as one word.
std::string quoted(const std::string& text) {
  const auto plain = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || std::strchr("/._-+,=:@%", c); };
  if (!text.empty() && std::ranges::all_of(text, plain)) return text;
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

int print_sample(const Options& options, const ReachSampler& sampler, const std::vector<double>& gammas) {
  const ReachSample sample = sampler.sample(static_cast<uint64_t>(options.trace_sample));
  for (const double gamma : gammas) {
    std::printf(
        "multireach-trace --urdf %s --base %s --tip %s --law %s --start=%s --target=%s --target-posture=%s "
        "--gamma %.17g %s%s --steps %.0f\n",
        quoted(options.urdf).c_str(), quoted(options.base).c_str(), quoted(options.tip).c_str(), options.law.c_str(),
        list_of(sample.start).c_str(), list_of(sample.target).c_str(), list_of(sample.target_posture).c_str(), gamma,
        options.gains.text(options.law).c_str(),
        (options.law == "paper"         ? " --drift " + list_of(Eigen::VectorXd::Constant(1, options.drift_m))
         : options.acceleration.empty() ? ""
                                        : " --acceleration " + quoted(options.acceleration))
            .c_str(),
        20 * options.gains.steps_per_second);
  }
  return 0;
}

void write_results(const Options& options, const std::vector<Tally>& tallies, nlohmann::json header) {
  const ReachRules rules = ReachRules::at(header.at("steps_per_second"));
  header["results"] = nlohmann::json::array();
  std::string csv =
      "gamma,samples,failures,failure_ratio,limit_violations,velocity_violations,nonfinite,max_error_m,"
      "path_ratio_p50,path_ratio_p95,settle_s_p50,settle_s_p95,steps_total,ns_per_step_per_core\n";
  for (const Tally& tally : tallies) {
    nlohmann::json result = tally.json(rules);
    if (header.at("shard") != "0/1") result["histograms"] = tally.histograms();
    header["results"].push_back(result);
    for (const char* key : {"gamma", "samples", "failures", "failure_ratio", "limit_violations", "velocity_violations",
                            "nonfinite", "max_error_m"}) {
      csv += result.at(key).dump() + ",";
    }
    for (const char* key : {"path_ratio", "settle_s"}) {
      csv += result.at(key).at("p50").dump() + "," + result.at(key).at("p95").dump() + ",";
    }
    csv += result.at("steps_total").dump() + "," + result.at("ns_per_step_per_core").dump() + "\n";
  }
  if (!options.json.empty()) write_json_file(options.json, header);
  if (!options.csv.empty()) write_text_file(options.csv, csv);
}

/// Merges the results of all n shards of one study. Refuses missing and repeated shards.
int merge(const Options& options) {
  std::vector<Tally> tallies;
  nlohmann::json header;
  std::set<int64_t> seen;
  int64_t shards = 0;
  for (const std::string& path : options.merge) {
    try {
      nlohmann::json part = nlohmann::json::parse(read_text_file(path));
      const nlohmann::json results = part.at("results");
      const auto [shard, of] = shard_from(part.at("shard").get<std::string>());
      part.erase("results");
      part["shard"] = "0/1";
      if (of == 1) throw InputError(path + ": is a whole study, not a shard of one; there is nothing to add to it");
      if (header.is_null()) {
        header = part;
        shards = of;
        for (const nlohmann::json& result : results) tallies.emplace_back().gamma = result.at("gamma").get<double>();
      }
      if (header != part || shards != of || results.size() != tallies.size()) {
        throw InputError(path + ": is of another study than " + options.merge.front() +
                         " (arm, law, gains, gamma, seed or number of samples or shards differ)");
      }
      if (!seen.insert(shard).second) {
        throw InputError(path + ": is shard " + std::to_string(shard) + " once more; expected each once");
      }
      for (size_t k = 0; k < results.size(); ++k) {
        const Tally tally = Tally::from_json(results[k]);
        if (tally.gamma != tallies[k].gamma) {
          throw InputError(path + ": has other values of gamma than " + options.merge.front());
        }
        tallies[k].merge(tally);
      }
    } catch (const nlohmann::json::exception& error) {
      throw InputError(path + ": is not a result of multireach-study: " + error.what());
    }
  }
  if (static_cast<int64_t>(seen.size()) != shards) {
    throw InputError("only " + std::to_string(seen.size()) + " of the " + std::to_string(shards) +
                     " shards are given; expected all");
  }
  write_results(options, tallies, header);
  return 0;
}

double drift_m_of(const Options& options) {
  return options.drift_m > 0 ? options.drift_m : std::numeric_limits<double>::infinity();
}

std::string failures_csv(const Chain& chain, const std::vector<double>& gammas,
                         const std::vector<FailedReach>& failed) {
  std::string csv = "gamma,index,error_m,target_x_m,target_y_m,target_z_m,hand_x_m,hand_y_m,hand_z_m";
  for (const char* when : {"start_", "end_"}) {
    for (const Joint& joint : chain.joints()) csv += std::string(",") + when + joint.name;
  }
  csv += "\n";
  for (const FailedReach& reach : failed) {
    const Eigen::Vector2d numbers(gammas[reach.gamma], reach.error_m);
    csv += list_of(numbers.head(1)) + "," + std::to_string(reach.index) + "," + list_of(numbers.tail(1));
    for (const auto& values : {list_of(reach.target), list_of(reach.hand), list_of(reach.start), list_of(reach.end)}) {
      csv += "," + values;
    }
    csv += "\n";
  }
  return csv;
}

/// Digest (FNV-1a) of the URDF, to distinguish arms whose links have the same names.
std::string digest_of(const std::string& path) {
  uint64_t hash = 0xcbf29ce484222325;
  for (const unsigned char byte : read_text_file(path)) hash = (hash ^ byte) * 0x100000001b3;
  char text[20];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

int study(const Options& options) {
  options.gains.check(options.law);
  const Shard shard = shard_from(options.shard);
  const Chain chain = load_chain(options.urdf, options.base, options.tip);
  const std::vector<double> gammas = gammas_of(options.gamma_text, chain, options.law);
  const ReachSampler sampler(chain, options.seed,
                             options.targets == "space" ? TargetsFrom::kSpace : TargetsFrom::kPostures);
  if (options.trace_sample >= 0 && !options.joint_weights.empty()) {
    throw InputError("--trace-sample does not go with --joint-weights: multireach-trace has only the default weights");
  }
  if (options.trace_sample >= 0) return print_sample(options, sampler, gammas);

  check_outputs({options.json, options.csv, options.failures});
  const StudyLaw law{options.law == "guarded",
                     options.gains.gains(options.law),
                     options.gains.attractor(),
                     options.gains.steps_per_second,
                     drift_m_of(options),
                     joint_values_from("--acceleration", options.acceleration, chain),
                     joint_values_from("--joint-weights", options.joint_weights, chain)};
  Progress line;
  std::optional<ShardProgress> file;
  if (shard.count > 1 && !options.json.empty() && options.json != "-") file.emplace(options.json, shard);
  const StudyResult result =
      run_study(chain, sampler, law, gammas, shard.begin(options.samples), shard.end(options.samples), options.threads,
                !options.failures.empty(), [&](double part) {
                  line.show(part);
                  if (file) file->show(part);
                });
  line.end();
  write_results(options, result.tallies,
                {{"urdf_digest", digest_of(options.urdf)},
                 {"base", options.base},
                 {"tip", options.tip},
                 {"law", options.law},
                 {"gains", options.gains.text(options.law)},
                 {"steps_per_second", options.gains.steps_per_second},
                 {"drift_m", options.law == "paper" ? options.drift_m : 0},
                 {"acceleration", options.acceleration.empty() ? "default" : options.acceleration},
                 {"joint_weights", options.joint_weights.empty() ? "default" : options.joint_weights},
                 {"targets", options.targets},
                 {"seed", options.seed},
                 {"samples_of_all_shards", options.samples},
                 {"shard", options.shard}});
  if (!options.failures.empty()) write_text_file(options.failures, failures_csv(chain, gammas, result.failed));
  return 0;
}

int status(const Options& options) {
  const ShardStatus status = shard_status(options.folder, wall_us());
  std::printf("%s\n", status.line.c_str());
  return status.done ? 0 : 1;
}

int straightness(const Options& options) {
  const Chain chain = load_chain(options.urdf, options.base, options.tip);
  const ReachSampler sampler(chain, options.seed,
                             options.targets == "space" ? TargetsFrom::kSpace : TargetsFrom::kPostures);
  check_outputs({options.json, options.csv, options.failures});
  nlohmann::json result =
      straightness_json(run_straightness(chain, sampler, options.samples, options.nodes, options.threads));
  const std::string table = straightness_table(result);
  result["urdf_digest"] = digest_of(options.urdf);
  result["base"] = options.base;
  result["tip"] = options.tip;
  result["targets"] = sampler.from_space() ? "space" : "postures";
  result["seed"] = options.seed;
  result["samples"] = options.samples;
  result["nodes"] = options.nodes;
  if (!options.json.empty()) write_json_file(options.json, result);
  if (options.json != "-") {
    std::printf("%s to %s: %lld reaches, targets uniform in %s, seed %llu, roadmap of %d nodes\n\n%s",
                options.base.c_str(), options.tip.c_str(), static_cast<long long>(options.samples),
                sampler.from_space() ? "space" : "postures", static_cast<unsigned long long>(options.seed),
                options.nodes, table.c_str());
  }
  return 0;
}

int tracking(const Options& options) {
  const Chain chain = load_chain(options.urdf, options.base, options.tip);
  const ReachSampler sampler(chain, options.seed, TargetsFrom::kPostures);
  check_outputs({options.json, options.csv, options.failures});
  const double radius_m = options.radius_m.value_or(0.1 * chain.reach());
  nlohmann::json result = run_tracking_study(chain, sampler, options.samples, radius_m);
  const auto places = result.at("places").get<int64_t>();
  if (places == 0) {
    throw InputError(
        fmt::format("the arm can reach no whole path of {:.3f} m around any of {} places; give a smaller --radius",
                    radius_m, 100 * options.samples));
  }
  result["urdf_digest"] = digest_of(options.urdf);
  result["base"] = options.base;
  result["tip"] = options.tip;
  result["seed"] = options.seed;
  if (!options.json.empty()) write_json_file(options.json, result);
  if (options.json != "-") {
    std::printf("%s to %s: radius %.3f m, around %lld places, seed %llu\n\n%s", options.base.c_str(),
                options.tip.c_str(), radius_m, static_cast<long long>(places),
                static_cast<unsigned long long>(options.seed), tracking_table(result).c_str());
  }
  return 0;
}

int throws(const Options& options) {
  const Chain chain = load_chain(options.urdf, options.base, options.tip);
  check_outputs({options.json, options.csv, options.failures});
  nlohmann::json result = run_throws(chain, options.samples, options.seed, options.throwing);
  result["urdf_digest"] = digest_of(options.urdf);
  result["base"] = options.base;
  result["tip"] = options.tip;
  if (!options.json.empty()) write_json_file(options.json, result);
  if (options.json != "-") {
    std::printf("%s to %s: thrown objects, met within %.3f m, seed %llu\n\n%s", options.base.c_str(),
                options.tip.c_str(), options.throwing.near_m, static_cast<unsigned long long>(options.seed),
                throws_table(result).c_str());
  }
  return 0;
}

}  // namespace
}  // namespace multireach

int main(int argc, char** argv) {
  multireach::Program program("multireach-study", "Many random reaches under a law, counted, for several gamma.");
  multireach::Options options;
  multireach::CommandLine& cli = program.cli();
  cli.option("--urdf", options.urdf, "URDF file");
  cli.option("--base", options.base, "link at the start of the chain; its frame is W");
  cli.option("--tip", options.tip, "link at the end of the chain, the hand");
  cli.option("--law", options.law, "control law").one_of({"paper", "guarded"}).show_default();
  cli.option("--gamma", options.gamma_text, "G1,G2,...: weights of the hand's attractor, rad^2/m^2");
  cli.option("--samples", options.samples, "reaches for each gamma").whole(1, 1000000000000).show_default();
  cli.option("--seed", options.seed, "random seed of the starts and targets").show_default();
  cli.option("--targets", options.targets,
             "space: uniform in the reachable space (an arm of no closed form: postures); postures: the hand's "
             "positions at uniform postures")
      .one_of({"space", "postures"})
      .show_default();
  cli.option("--shard", options.shard, "i/n: run only part i of n; i from 0 to n - 1").show_default();
  cli.option("--threads", options.threads,
             "threads (default: all processors); the results are the same with any number")
      .whole(1, 1024);
  options.gains.add_to(cli);
  cli.option("--drift", options.drift_m,
             "law paper: search theta_T again when K(theta_T) is further than this from the target, m; 0: never")
      .finite(0.0, 1e6)
      .show_default();
  cli.option("--acceleration", options.acceleration, multireach::kAccelerationHelp);
  cli.option("--joint-weights", options.joint_weights,
             "W1,W2,...: law guarded: weight of each joint, or one for all; inf locks a joint; default: a slow joint "
             "weighs more");
  cli.option("--json", options.json, "JSON file of the results; - for standard output, the default without --csv");
  cli.option("--csv", options.csv, "CSV file of the results; - for standard output");
  cli.option("--failures", options.failures, "CSV file of the reaches that did not arrive");
  cli.option("--trace-sample", options.trace_sample, "print the command that traces reach K, and stop")
      .whole(0, 1000000000000);
  multireach::CommandLine merging = cli.subcommand("merge", "merge the results of all shards of a study");
  merging.option("files", options.merge, "JSON files of the shards").required();
  merging.option("--json", options.json, "where to write the results; - for standard output");
  merging.option("--csv", options.csv, "CSV file of the results");
  multireach::CommandLine asking = cli.subcommand(
      "status", "one line on all shards of a study, finished and running; exit code 1 until all are done");
  asking.option("folder", options.folder, "folder of the shards' --json files").show_default();
  multireach::CommandLine straight = cli.subcommand(
      "straightness",
      "length of the hand's path: guarded, a damped-least-squares follower, and the shortest path inside the limits");
  straight.fallthrough();
  straight.option("--nodes", options.nodes, "nodes of the roadmap for the shortest path; 0: do not compute it")
      .whole(0, 1000000)
      .show_default();
  multireach::CommandLine following = cli.subcommand(
      "tracking",
      "how well the hand follows targets that keep moving: the controller, and a damped-least-squares follower");
  following.fallthrough();
  following.option("--radius", options.radius_m, "radius of the paths, m; default: a tenth of the arm's reach")
      .finite(1e-4, 10.0);
  multireach::CommandLine throwing = cli.subcommand(
      "throws",
      "how often the hand meets a thrown object (motion: intercept), beside how often any hand could be in time");
  throwing.fallthrough();
  throwing
      .option("--sigma", options.throwing.sigma_m, "standard deviation of each coordinate of an observed position, m")
      .finite(0.0, 1.0)
      .show_default();
  throwing.option("--near", options.throwing.near_m, "met: the hand comes as near as this to the object, m")
      .finite(1e-4, 1.0)
      .show_default();
  throwing
      .option("--drag", options.throwing.drag,
              "deceleration by the air per squared speed, 1/m, of which the controller does not know (table tennis: "
              "0.12, tennis: 0.02)")
      .finite(0.0, 1.0)
      .show_default();
  return program.run(argc, argv, [&] {
    if (options.json.empty() && options.csv.empty() && !straight.given() && !following.given() && !throwing.given())
      options.json = "-";
    if (merging.given()) return multireach::merge(options);
    if (asking.given()) return multireach::status(options);
    for (const auto& [text, name] :
         {std::pair(options.urdf, "--urdf"), {options.base, "--base"}, {options.tip, "--tip"}}) {
      if (text.empty()) throw multireach::InputError(std::string(name) + " is missing; see --help");
    }
    if (straight.given()) return multireach::straightness(options);
    if (following.given()) return multireach::tracking(options);
    if (throwing.given()) return multireach::throws(options);
    return multireach::study(options);
  });
}
