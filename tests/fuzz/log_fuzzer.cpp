// Any bytes as a log: a summary, latencies and the inputs of a replay, or one sentence.
#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

#include "runtime/log_file.hpp"
#include "tools/log/latency.hpp"
#include "tools/log/log_summary.hpp"
#include "tools/replay/session.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace multireach;
  static const int file = memfd_create("log", 0);
  static const std::string path = "/proc/self/fd/" + std::to_string(file);
  if (ftruncate(file, 0) != 0 || pwrite(file, data, size, 0) != static_cast<ssize_t>(size)) std::abort();
  try {
    const LogSummary summary = summary_of(path);
    if (summary.json().empty() || summary.table().empty()) std::abort();
    latency_of(path);
    for (const ReplayFrom from : {ReplayFrom::kImages, ReplayFrom::kTargets}) {
      Session session(path, from, true);
      int64_t before = 0;
      while (const auto input = session.next()) {
        if (input->at_us < before) std::abort();
        before = input->at_us;
      }
    }
  } catch (const InputError&) {
  }
  return 0;
}
