#include "tools/replay/sweep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <mutex>
#include <thread>

#include "tools/log/quantile.hpp"
#include "tools/log/run_report.hpp"

namespace multireach {
namespace {

using Json = nlohmann::ordered_json;

constexpr int64_t kMostCombinations = 1000000;

Json number_or_null(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

/// Adds the median and the largest value of `key` of all reaches. A reach without it counts as infinite: null.
void add_median_and_max(Json& figures, const nlohmann::json& reaches, const std::string& key) {
  std::vector<double> values;
  for (const nlohmann::json& reach : reaches)
    values.push_back(reach.at(key).is_number() ? reach.at(key).get<double>() : INFINITY);
  figures[key + "_p50"] = number_or_null(quantile(values, 0.5));
  figures[key + "_max"] = number_or_null(quantile(values, 1));
}

/// Progress of replays that run at the same time.
class SharedProgress {
 public:
  SharedProgress(const ReplayProgress& progress, int64_t replays)
      : progress_(progress), parts_(static_cast<size_t>(replays), 0.0) {}
  void show(size_t replay, double part) {
    const std::lock_guard lock(mutex_);
    sum_ += part - parts_[replay];
    parts_[replay] = part;
    if (progress_) progress_(sum_ / static_cast<double>(parts_.size()));
  }

 private:
  std::mutex mutex_;
  const ReplayProgress progress_;
  std::vector<double> parts_;
  double sum_ = 0;
};

/// Replays combinations until none is left or one fails.
class Sweeper {
 public:
  Sweeper(const SweepJob& job, const ReplayProgress& progress)
      : job_(job),
        begin_(job.shard.begin(job.grid.size())),
        rows_(static_cast<size_t>(job.shard.end(job.grid.size()) - begin_)),
        progress_(progress, static_cast<int64_t>(rows_.size())) {}

  Json run() {
    std::vector<std::thread> threads;
    const size_t count = std::min(rows_.size(), static_cast<size_t>(job_.jobs));
    for (size_t i = 0; i < count; ++i) threads.emplace_back([this] { work(); });
    for (std::thread& thread : threads) thread.join();
    if (failure_) std::rethrow_exception(failure_);
    Json rows = Json::array();
    for (Json& row : rows_) rows.push_back(std::move(row));
    return rows;
  }

 private:
  void work() {
    for (size_t k = next_++; k < rows_.size(); k = next_++) {
      try {
        rows_[k] = row(k);
      } catch (...) {
        const std::lock_guard lock(mutex_);
        if (!failure_) failure_ = std::current_exception();
        next_ = rows_.size();
      }
    }
  }

  Json row(size_t k) {
    const int64_t index = begin_ + static_cast<int64_t>(k);
    const ConfigOverrides overrides = job_.grid.overrides(index);
    const ReplayOptions options = [&] {
      const std::lock_guard lock(mutex_);
      ReplayOptions loaded = job_.options(overrides);
      // Processors that no other replay uses decode images.
      loaded.threads = std::max(1, job_.jobs / static_cast<int>(std::min<size_t>(rows_.size(), INT16_MAX)));
      return loaded;
    }();
    RunReporter reporter(options.config);
    const int64_t origin =
        Session(options.session, options.from, options.robot == ReplayRobot::kRecorded).recorded_utime();
    int64_t number = 0;
    const ReplayResult result = replay(
        options,
        [&](int64_t at_us, std::string_view channel, std::span<const uint8_t> bytes, bool) {
          reporter.add({number++, origin + at_us, channel, bytes, bytes});
        },
        [&](double part) { progress_.show(k, part); });
    progress_.show(k, 1);
    Json row{{"index", index}, {"set", Json::object()}, {"figures", figures_of(reporter.report())}};
    row["figures"]["digest"] = fmt::format("{:016x}", static_cast<uint64_t>(result.digest));
    for (const ConfigOverride& given : overrides) row["set"][given.key] = given.value;
    return row;
  }

  const SweepJob& job_;
  int64_t begin_;
  std::vector<Json> rows_;
  SharedProgress progress_;
  std::atomic<size_t> next_ = 0;
  std::mutex mutex_;
  std::exception_ptr failure_;
};

}  // namespace

Json figures_of(const RunReport& run) {
  const nlohmann::json& report = run.json;
  Json figures;
  figures["succeeded"] = run.succeeded;
  figures["reaches"] = report.at("reaches").size();
  figures["reached"] = report.at("reached");
  figures["unreachable"] = report.at("unreachable").size();
  add_median_and_max(figures, report.at("reaches"), "hand_error_mm");
  add_median_and_max(figures, report.at("reaches"), "settle_s");
  const nlohmann::json& vision = report.at("vision_error_mm");
  for (const char* key : {"median", "p95", "max"})
    figures[std::string("vision_error_mm_") + key] = vision.is_object() ? Json(vision.at(key)) : Json();
  int64_t frames = 0;
  for (const nlohmann::json& interval : report.at("lost_intervals")) frames += interval.at("frames").get<int64_t>();
  figures["lost_intervals"] = report.at("lost_intervals").size();
  figures["lost_frames"] = frames;
  for (const char* key : {"images", "targets", "setpoints", "commands", "robot_states", "max_limit_violation_rad",
                          "max_measured_limit_violation_rad", "max_velocity_violation_rad_s", "max_command_speed_share",
                          "max_measured_speed_share", "max_command_acceleration_share", "max_command_jerk_share"})
    figures[key] = Json(report.at(key));
  return figures;
}

SweptKey swept_key_from(const std::string& text) {
  const ConfigOverride given = config_override_from("--set", text);
  SweptKey swept{given.key, {""}};
  int depth = 0;
  char quote = 0;
  for (const char c : given.value) {
    if (quote) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '[' || c == '{') {
      ++depth;
    } else if (c == ']' || c == '}') {
      --depth;
    } else if (c == ',' && depth == 0) {
      swept.values.emplace_back();
      continue;
    }
    swept.values.back() += c;
  }
  for (const std::string& value : swept.values) {
    if (value.empty())
      throw InputError("--set is '" + text + "', with an empty value; expected KEY=V1,V2,... without spaces");
    if (std::ranges::count(swept.values, value) > 1)
      throw InputError("--set is '" + text + "', with the value " + value + " twice; expected each once");
  }
  return swept;
}

SweepGrid::SweepGrid(std::vector<SweptKey> keys) : keys_(std::move(keys)) {
  for (const SweptKey& one : keys_) {
    const auto holds = [&](const SweptKey& other) {
      return other.key.starts_with(one.key) && (other.key.size() == one.key.size() ||
                                                other.key[one.key.size()] == '.' || other.key[one.key.size()] == '[');
    };
    if (std::ranges::count_if(keys_, holds) > 1)
      throw InputError("--set: '" + one.key + "' is given twice, or with a key inside of it; expected each value once");
    if (static_cast<int64_t>(one.values.size()) > kMostCombinations / size_)
      throw InputError("--set: the values have more than a million combinations");
    size_ *= static_cast<int64_t>(one.values.size());
  }
}

ConfigOverrides SweepGrid::overrides(int64_t combination) const {
  ConfigOverrides chosen;
  for (size_t i = keys_.size(); i-- > 0;) {
    const auto values = static_cast<int64_t>(keys_[i].values.size());
    chosen.push_back({keys_[i].key, keys_[i].values[static_cast<size_t>(combination % values)]});
    combination /= values;
  }
  std::ranges::reverse(chosen);
  return chosen;
}

void check_sweep(const SweepJob& job) {
  for (int64_t k = job.shard.begin(job.grid.size()); k < job.shard.end(job.grid.size()); ++k) {
    const ConfigOverrides overrides = job.grid.overrides(k);
    const auto fail = [&](const std::exception& fault) {
      std::string with = fault.what();
      for (const auto& [key, value] : overrides) with.append(" --set ").append(key).append("=").append(value);
      throw InputError(with.insert(std::string(fault.what()).size(), ", with"));
    };
    try {
      ReplayOptions options = job.options(overrides);
      options.threads = 1;  // nodes without threads of their own
      nodes_of(options);
    } catch (const InputError& fault) {
      fail(fault);
    } catch (const std::invalid_argument& fault) {  // of a stage
      fail(fault);
    }
  }
}

Json sweep_rows(const SweepJob& job, const ReplayProgress& progress) {
  return Sweeper(job, progress).run();
}

}  // namespace multireach
