#include "robot_bridge/drivers/status_filter.hpp"

#include <algorithm>

namespace multireach::drivers {
namespace {

constexpr int64_t kLatest = int64_t{1} << 60;  // us: times up to here can be subtracted
constexpr int kReordered = 3;                  // after as many in a row that are older, the sender's clock was set back
constexpr double kFastest = 6;                 // rad/s: no joint of an arm of this kind is faster
constexpr double kUncertain = 0.02;            // rad: two messages that come together were sent some milliseconds apart
constexpr int64_t kLongest = 100000;           // us

}  // namespace

bool StatusFilter::accepts(int64_t utime, const JointVector& position, const JointVector& velocity, int64_t now_us) {
  if (position.size() != joints_) return ++other_size_, false;
  const bool timed = utime != -1;
  const bool valid = !timed || (utime >= 0 && utime < kLatest);
  if (!valid || velocity.size() != joints_ || !position.allFinite() || !velocity.allFinite()) return ++invalid_, false;
  if (position_) {
    const bool comparable = timed && utime_ >= 0;
    if (comparable && utime < utime_ && ++older_in_a_row_ <= kReordered) return ++older_, false;
    const int64_t sent = comparable ? std::clamp<int64_t>(utime - utime_, 0, kLongest) : 0;
    const int64_t came = std::clamp<int64_t>(now_us - heard_us_, 0, kLongest);
    const double furthest = kUncertain + kFastest * 1e-6 * static_cast<double>(std::max(sent, came));
    if ((position - *position_).cwiseAbs().maxCoeff() > furthest) return ++other_arm_, false;
  }
  older_in_a_row_ = 0;
  utime_ = utime;
  heard_us_ = now_us;
  position_ = position;
  return true;
}

std::string StatusFilter::text() const {
  std::string text;
  const auto add = [&](int64_t count, const char* what) {
    if (count > 0) text += (text.empty() ? channel_ + " refused: " : ", ") + std::to_string(count) + " " + what;
  };
  add(other_size_, "of another number of joints");
  add(other_arm_, "of another arm");
  add(older_, "older than the last");
  add(invalid_, "invalid");
  return text;
}

}  // namespace multireach::drivers
