// multireach-bench-replay: speed of replay and of reading logs, compared with plain image decoding and memory speed.
// All measured in one run, best of several.
#include <fmt/format.h>
#include <turbojpeg.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <multireach/images_t.hpp>
#include <thread>

#include "runtime/channels.hpp"
#include "runtime/message.hpp"
#include "tools/log/log_summary.hpp"
#include "tools/replay/run.hpp"

namespace multireach {
namespace {

double seconds(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// Time to decode all images of a session with turbojpeg, called as vision's codec does, in one thread.
double decoding_alone(const std::vector<std::vector<uint8_t>>& jpegs) {
  tjhandle handle = tjInitDecompress();
  std::vector<uint8_t> pixels;
  const double time = seconds([&] {
    for (const auto& jpeg : jpegs) {
      int width = 0, height = 0, subsampling = 0, colours = 0;
      tjDecompressHeader3(handle, jpeg.data(), jpeg.size(), &width, &height, &subsampling, &colours);
      pixels.resize(3UL * static_cast<size_t>(width) * static_cast<size_t>(height));
      tjDecompress2(handle, jpeg.data(), jpeg.size(), pixels.data(), width, 0, height, TJPF_BGR,
                    TJFLAG_ACCURATEDCT | TJFLAG_STOPONWARNING);
    }
  });
  tjDestroy(handle);
  return time;
}

std::vector<std::vector<uint8_t>> jpegs_in(const std::string& session) {
  std::vector<std::vector<uint8_t>> jpegs;
  LogReader log(session);
  while (const auto event = log.next()) {
    if (event->channel != channel::kStereoImages) continue;
    const auto images = decode<images_t>(event->data);
    for (const image_t& image : images ? images->images : std::vector<image_t>()) jpegs.push_back(image.data);
  }
  return jpegs;
}

/// Replays into a log, as `multireach-replay run -o` does. Returns the time taken.
double replaying(const ReplayOptions& options, const std::string& output, ReplayResult& result) {
  return seconds([&] {
    LogWriter log(output);
    result = replay(
        options,
        [&](int64_t at, std::string_view channel, std::span<const uint8_t> bytes, bool) {
          log.write(at, channel, bytes);
        },
        nullptr);
    log.close();
  });
}

void measure(const std::string& session, const std::string& robot, int repetitions, const std::string& folder) {
  ReplayOptions options{.session = session,
                        .from = ReplayFrom::kImages,
                        .robot = ReplayRobot::kIdeal,
                        .config = RobotConfig::load(robot),
                        .vision = VisionConfig::load(resolve_relative(robot, "vision.yaml")),
                        .until_s = 1e9,
                        .threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()))};
  const std::string whole = folder + "/whole.lcm", targets = folder + "/targets.lcm", big = folder + "/big.lcm";
  const auto jpegs = jpegs_in(session);
  ReplayResult result;
  double decode_s = 1e9, run_s = 1e9, one_s = 1e9, targets_s = 1e9, info_s = 1e9, copy_s = 1e9;
  replaying(options, whole, result);
  const std::string once = read_text_file(session);
  constexpr size_t kBig = size_t{1} << 30;
  {
    OutputFile file(big);
    const std::span bytes(reinterpret_cast<const uint8_t*>(once.data()), once.size());
    for (size_t written = 0; written < kBig; written += once.size()) file.write(bytes);
    file.finish();
  }
  const auto big_size = static_cast<double>(std::filesystem::file_size(big));
  std::vector<char> there(once.size());
  for (int k = 0; k < repetitions; ++k) {
    decode_s = std::min(decode_s, decoding_alone(jpegs));
    ReplayOptions one = options, from_targets = options;
    one.threads = 1;
    from_targets.session = whole;
    from_targets.from = ReplayFrom::kTargets;
    run_s = std::min(run_s, replaying(options, folder + "/out.lcm", result));
    one_s = std::min(one_s, replaying(one, folder + "/out.lcm", result));
    targets_s = std::min(targets_s, replaying(from_targets, targets, result));
    info_s = std::min(info_s, seconds([&] { summary_of(big); }));
    copy_s = std::min(copy_s, seconds([&] { std::copy(once.begin(), once.end(), there.begin()); }));
  }
  fmt::print("| what | time, s | beside |\n|---|---|---|\n");
  fmt::print("| decoding {} images with turbojpeg alone, one thread | {:.3f} | |\n", jpegs.size(), decode_s);
  fmt::print("| run, {} threads | {:.3f} | {:.2f} of that speed; {:.0f} times real time |\n", options.threads, run_s,
             decode_s / run_s, result.span_s / run_s);
  fmt::print("| run, one thread | {:.3f} | {:.2f} of that speed |\n", one_s, decode_s / one_s);
  fmt::print("| run from targets | {:.3f} | {:.0f} times real time |\n", targets_s, result.span_s / targets_s);
  fmt::print(
      "| info of a log of {:.2f} GB of images, from cache | {:.3f} | {:.1f} GB/s; a plain copy in memory {:.1f} |\n",
      big_size * 1e-9, info_s, big_size * 1e-9 / info_s, static_cast<double>(once.size()) * 1e-9 / copy_s);
}

}  // namespace
}  // namespace multireach

int main(int argc, char** argv) {
  using namespace multireach;
  cv::setNumThreads(1);
  CLI::App app("Replay and log reading, beside bare decoding.", "multireach-bench-replay");
  std::string session = MULTIREACH_SOURCE_DIR "/logs/reach.lcm",
              robot = MULTIREACH_SOURCE_DIR "/robots/hoap2/robot.yaml";
  int repetitions = 9;
  app.add_option("--session", session)->capture_default_str();
  app.add_option("--robot", robot)->capture_default_str();
  app.add_option("--repetitions", repetitions)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  char folder[] = "/tmp/multireach-bench-XXXXXX";
  if (!mkdtemp(folder)) return 1;
  measure(session, robot, repetitions, folder);
  std::filesystem::remove_all(folder);
  return 0;
}
