#include "runtime/progress.hpp"

#include <unistd.h>

#include <cstdio>

namespace multireach {

using std::chrono::steady_clock;

Progress::Progress() : terminal_(isatty(STDERR_FILENO) != 0), begin_(steady_clock::now()), last_(begin_) {}

void Progress::show(double part) {
  if (!terminal_) return;
  const auto now = steady_clock::now();
  if (now - last_ < std::chrono::milliseconds(200)) return;
  last_ = now;
  const double spent = std::chrono::duration<double>(now - begin_).count();
  std::fprintf(stderr, "\r%3.0f %%, %.0f s left\033[K", 100 * part, part > 0 ? spent * (1 - part) / part : 0.0);
  std::fflush(stderr);
  shown_ = true;
}

void Progress::end() {
  if (shown_) std::fputs("\r\033[K", stderr);
  shown_ = false;
}

}  // namespace multireach
