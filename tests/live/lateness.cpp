// multireach-test-lateness FILE: how late this machine lets a process run that nothing else may delay, while tests run
// beside it. Sleeps until each millisecond at a priority above those of all of multireach, and writes to FILE, each
// second, how many seconds have passed and how many of its sleeps ended more than 3 ms late: after such a gap the
// bridge begins again from rest (docs/safety.md). Exit code 77 where that priority is not allowed.
#include <sched.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <string>

namespace {

constexpr int64_t kPeriod_ns = 1000000, kLate_ns = 3000000, kSecond_ns = 1000000000;

int64_t now_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * kSecond_ns + now.tv_nsec;
}

void sleep_until(int64_t ns) {
  const timespec until{.tv_sec = ns / kSecond_ns, .tv_nsec = ns % kSecond_ns};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
}

/// Replaces the file at once, so that a reader never sees a part of it.
bool write(const std::string& path, int64_t seconds, int late) {
  const std::string unfinished = path + ".part";
  std::FILE* file = std::fopen(unfinished.c_str(), "w");
  if (!file) return false;
  const bool written = std::fprintf(file, "%lld %d\n", static_cast<long long>(seconds), late) > 0;
  return (std::fclose(file) == 0) && written && std::rename(unfinished.c_str(), path.c_str()) == 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "Usage: %s FILE\n", argv[0]);
    return 2;
  }
  const sched_param priority{.sched_priority = 46};  // above the relay's and the bridge's
  if (sched_setscheduler(0, SCHED_FIFO, &priority) != 0) return 77;
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // ends with the test
  int late = 0;
  const int64_t begin = now_ns();
  for (int64_t next = begin;;) {
    for (const int64_t end = next + kSecond_ns; next < end;) {
      next += kPeriod_ns;
      sleep_until(next);
      const int64_t now = now_ns();
      if (now <= next + kLate_ns) continue;
      ++late;
      next = now;
    }
    if (!write(argv[1], (now_ns() - begin) / kSecond_ns, late)) return 1;
    next = now_ns();  // what writing takes is not the machine's lateness
  }
}
