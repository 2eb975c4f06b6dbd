#include "tools/page/shown_runs.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "runtime/channels.hpp"
#include "tools/log/run_report.hpp"
#include "tools/replay/request.hpp"
#include "tools/replay/sweep.hpp"

namespace multireach {
namespace {

RunRequest request_for(const ShownRuns::Options& options, const std::vector<std::string>& set,
                       const std::string& robot_model) {
  RunRequest request;
  request.session = options.log;
  request.robot = robot_model;
  request.setup.config = options.robot;
  request.setup.vision = options.vision;
  request.setup.set = set;
  return request;
}

std::string file_name(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

/// Images are those of the recorded log.
bool is_recorded_only(std::string_view channel) {
  return channel == channel::kStereoImages || channel == channel::kNodeInputs || channel == channel::kTrackerState;
}

}  // namespace

ShownRuns::ShownRuns(Options options) : options_(std::move(options)) {
  std::string folder = std::filesystem::temp_directory_path() / "multireach-page.XXXXXX";
  const auto log = std::make_shared<const LogIndex>(options_.log);
  if (!mkdtemp(folder.data()))
    throw InputError("no folder for computed logs can be made as '" + folder + "'; set TMPDIR to one that is writable");
  folder_ = folder;
  const auto recorded = add(file_name(options_.log));
  recorded->log = log;
  waiting_.push_back(recorded);
  worker_ = std::thread([this] { work(); });
}

ShownRuns::~ShownRuns() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
    for (const auto& run : runs_) run->removed = true;
    changed_.notify_all();
  }
  worker_.join();
  std::error_code error;
  std::filesystem::remove_all(folder_, error);
}

std::shared_ptr<ShownRuns::Run> ShownRuns::add(std::string label) {
  const std::lock_guard lock(mutex_);
  if (runs_.size() >= kMostRuns) throw InputError(fmt::format("{} runs are shown: remove one first", kMostRuns));
  const auto run = std::make_shared<Run>();
  run->id = next_id_++;
  run->label = std::move(label);
  runs_.push_back(run);
  ++version_;
  return run;
}

void ShownRuns::add_log(const std::string& path) {
  auto log = std::make_shared<const LogIndex>(path);
  const auto run = add(file_name(path));
  const std::lock_guard lock(mutex_);
  run->log = std::move(log);
  waiting_.push_back(run);
  changed_.notify_all();
}

void ShownRuns::recompute(const std::vector<std::string>& set, const std::string& robot_model) {
  constexpr std::array<std::string_view, 3> kModels{"ideal", "sim", "recorded"};
  if (std::ranges::find(kModels, robot_model) == kModels.end())
    throw InputError("'" + robot_model + "' is no model of the robot; expected ideal, sim or recorded");
  RunRequest request = request_for(options_, set, robot_model);
  request.threads = 1;          // nodes without threads of their own
  nodes_of(request.options());  // refuses wrong values
  const auto run = add(set.empty() ? std::string("computed again") : fmt::format("{}", fmt::join(set, ", ")));
  const std::lock_guard lock(mutex_);
  run->set = set;
  run->robot_model = robot_model;
  waiting_.push_back(run);
  changed_.notify_all();
}

void ShownRuns::remove(int64_t id) {
  const std::lock_guard lock(mutex_);
  const auto found = std::ranges::find(runs_, id, [](const auto& run) { return run->id; });
  if (id == kRecorded || found == runs_.end()) throw InputError(fmt::format("there is no run {} to remove", id));
  (*found)->removed = true;
  runs_.erase(found);
  ++version_;
}

std::optional<ShownRuns::View> ShownRuns::find(int64_t id) const {
  const std::lock_guard lock(mutex_);
  const auto found = std::ranges::find(runs_, id, [](const auto& run) { return run->id; });
  if (found == runs_.end()) return std::nullopt;
  const Run& run = **found;
  if (id == kRecorded) return View{run.log, 0};
  if (run.state != State::kReady) return std::nullopt;
  return View{run.log, run.comparison->offset_us};
}

nlohmann::ordered_json ShownRuns::json() const {
  static constexpr std::array kWords{"waiting", "computing", "ready", "failed"};
  const std::lock_guard lock(mutex_);
  nlohmann::ordered_json runs = nlohmann::ordered_json::array();
  for (const auto& run : runs_) {
    runs.push_back({{"id", run->id},
                    {"label", run->label},
                    {"set", run->set},
                    {"robot_model", run->robot_model},
                    {"state", kWords.at(static_cast<size_t>(run->state))},
                    {"doing", run->doing},
                    {"progress", run->progress},
                    {"failure", run->failure},
                    {"comparison", run->comparison ? json_of(*run->comparison) : nlohmann::ordered_json()},
                    {"figures", run->figures}});
  }
  return {{"runs", runs}};
}

int64_t ShownRuns::version() const {
  const std::lock_guard lock(mutex_);
  return version_;
}

void ShownRuns::show(Run& run, const char* doing, double progress) {
  const std::lock_guard lock(mutex_);
  if (run.removed) throw Removed();
  constexpr double kVisible = 0.01;
  if (run.doing == doing && progress - run.progress < kVisible) return;
  run.doing = doing;
  run.progress = progress;
  ++version_;
}

void ShownRuns::work() {
  constexpr int kNice = 10;
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);  // of this thread: the page comes first
  while (true) {
    std::shared_ptr<Run> run;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return ending_ || !waiting_.empty(); });
      if (ending_) return;
      run = waiting_.front();
      waiting_.pop_front();
      run->state = State::kComputing;
    }
    std::string failure;
    try {
      compute(*run);
    } catch (const Removed&) {
      continue;
    } catch (const std::exception& error) {
      failure = error.what();
    }
    const std::lock_guard lock(mutex_);
    run->state = failure.empty() ? State::kReady : State::kFailed;
    run->failure = failure;
    ++version_;
  }
}

void ShownRuns::compute(Run& run) {
  if (run.id != kRecorded) {
    if (!run.log) compute_log(run);
    const auto recorded = find(kRecorded);
    const RunComparison comparison =
        compare_runs(*recorded->log, *run.log, [&](double part) { show(run, "comparing", part); });
    const std::lock_guard lock(mutex_);
    run.comparison = comparison;
  }
  report(run);
}

void ShownRuns::compute_log(Run& run) {
  const ReplayOptions options = request_for(options_, run.set, run.robot_model).options();
  const int64_t origin =
      Session(options.session, options.from, options.robot == ReplayRobot::kRecorded).recorded_utime();
  const std::string path = fmt::format("{}/{}.lcm", folder_, run.id);
  LogWriter writer(path);
  replay(
      options,
      [&](int64_t at_us, std::string_view channel, std::span<const uint8_t> bytes, bool) {
        if (!is_recorded_only(channel)) writer.write(origin + at_us, channel, bytes);
      },
      [&](double part) { show(run, "computing", part); });
  writer.close();
  auto log = std::make_shared<const LogIndex>(path);
  std::filesystem::remove(path);  // it stays mapped
  const std::lock_guard lock(mutex_);
  run.log = std::move(log);
}

void ShownRuns::report(Run& run) {
  const Setup setup = request_for(options_, run.set, run.robot_model).setup;
  RunReporter reporter(RobotConfig::load(setup.robot_file(), split(setup.overrides(), true).robot));
  const LogIndex& log = *run.log;
  for (int64_t i = 0; i < log.size(); ++i) {
    reporter.add(log.event(i));
    if (i % 1000 == 0) show(run, "reporting", static_cast<double>(i) / static_cast<double>(log.size()));
  }
  auto figures = figures_of(reporter.report());
  const std::lock_guard lock(mutex_);
  run.figures = std::move(figures);
  run.progress = 1;
}

}  // namespace multireach
