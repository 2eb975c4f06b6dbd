#include "studies/study/shard_progress.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "runtime/files.hpp"
#include "runtime/message_clock.hpp"

namespace multireach {
namespace {

namespace fs = std::filesystem;
using std::chrono::steady_clock;

constexpr int64_t kSilent = 60000000;  // us: a running shard writes every second
constexpr std::string_view kSuffix = ".progress";

/// What is known of one shard.
struct Known {
  double part = 0, seconds = 0;
  bool done = false, silent = false;
};

std::string duration(double seconds) {
  if (seconds < 120) return fmt::format("{:.0f} s", seconds);
  if (seconds < 7200) return fmt::format("{:.0f} min", seconds / 60);
  return fmt::format("{:.1f} h", seconds / 3600);
}

/// "3, 17, 20 and 4 more"
std::string list_of(const std::vector<int64_t>& numbers) {
  constexpr size_t kListed = 8;
  const size_t listed = std::min(numbers.size(), kListed);
  std::string text =
      fmt::format("{}", fmt::join(numbers.begin(), numbers.begin() + static_cast<ptrdiff_t>(listed), ", "));
  return numbers.size() > listed ? text + fmt::format(" and {} more", numbers.size() - listed) : text;
}

class Shards {
 public:
  /// Takes what a file says, if it is of a shard: the merged result is not.
  void read(const std::string& path, int64_t now_us) {
    const bool running = path.ends_with(kSuffix);
    Shard shard;
    Known known{.part = 1, .done = true};
    try {
      const nlohmann::json json = nlohmann::json::parse(read_text_file(path));
      shard = shard_from(json.value("shard", "0/1"));
      if (shard.count < 2) return;
      if (running) {
        known = {.part = json.at("part").get<double>(), .seconds = json.at("seconds").get<double>()};
        known.silent = now_us - json.at("utime").get<int64_t>() > kSilent;
      }
    } catch (const nlohmann::json::exception&) {
      if (running) throw InputError(path + ": is not the progress of a shard of multireach-study");
      return;
    }
    if (count_ > 0 && shard.count != count_) {
      throw InputError(fmt::format("{}: is one of {} shards, {} one of {}; expected one study in a folder", path,
                                   shard.count, first_, count_));
    }
    if (count_ == 0) first_ = path;
    count_ = shard.count;
    if (Known& other = shards_[shard.index]; !other.done) other = known;
  }

  ShardStatus status(const std::string& folder) const {
    if (count_ == 0) throw InputError(folder + ": has no results of shards, and none that runs; expected *.json");
    int64_t done = 0, running = 0;
    double parts = 0, per_second = 0;
    std::vector<int64_t> silent;
    for (const auto& [index, shard] : shards_) {
      parts += shard.part;
      done += shard.done;
      if (shard.silent) silent.push_back(index);
      if (shard.done || shard.silent) continue;
      ++running;
      if (shard.seconds > 0) per_second += shard.part / shard.seconds;
    }
    const auto count = static_cast<double>(count_);
    const int64_t waiting = count_ - static_cast<int64_t>(shards_.size());
    std::string line = fmt::format("{} shards: {} done, {} running, {} not begun", count_, done, running, waiting);
    if (!silent.empty())
      line += fmt::format(", {} silent for over a minute ({}): run them again", silent.size(), list_of(silent));
    line += fmt::format("; {:.0f} %", 100 * parts / count);
    if (per_second > 0) line += fmt::format(", {} left", duration((count - parts) / per_second));
    return {line, done == count_};
  }

 private:
  std::map<int64_t, Known> shards_;
  int64_t count_ = 0;
  std::string first_;
};

}  // namespace

ShardProgress::ShardProgress(const std::string& result, const Shard& shard)
    : path_(result + std::string(kSuffix)), shard_(shard), begin_(steady_clock::now()), last_(begin_) {
  write(0);
}

ShardProgress::~ShardProgress() {
  std::error_code ignored;
  fs::remove(path_, ignored);
}

void ShardProgress::show(double part) {
  const auto now = steady_clock::now();
  if (now - last_ < std::chrono::seconds(1)) return;
  last_ = now;
  write(part);
}

void ShardProgress::write(double part) const {
  const double seconds = std::chrono::duration<double>(steady_clock::now() - begin_).count();
  write_json_file(path_, {{"shard", fmt::format("{}/{}", shard_.index, shard_.count)},
                          {"part", part},
                          {"seconds", seconds},
                          {"utime", wall_us()}});
}

ShardStatus shard_status(const std::string& folder, int64_t now_us) {
  std::error_code error;
  fs::directory_iterator files(folder, error);
  if (error) throw InputError(folder + ": cannot be read as a folder: " + error.message());
  Shards shards;
  for (const auto& file : files) {
    const std::string path = file.path().string();
    if (file.is_regular_file(error) && (path.ends_with(".json") || path.ends_with(kSuffix))) shards.read(path, now_us);
  }
  return shards.status(folder);
}

}  // namespace multireach
