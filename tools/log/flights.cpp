#include "tools/log/flights.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

namespace multireach {
namespace {

using nlohmann::json;

constexpr int64_t kLastSeen = 200000;       // us: so long after the last observation a flight is extrapolated
constexpr int64_t kOneThrow = 300000;       // us: a fall that begins so soon after the last one is of the same throw
constexpr int64_t kTimeGoesBack = 1000000;  // us: a target so much older than the last: that one's time was wrong
constexpr int64_t kReachEvery = 20000;      // us: times at which the arm's reach is asked for

struct Flight {
  int64_t begin = 0, end = 0, closest_at = 0;
  double closest_m = std::numeric_limits<double>::infinity();
  bool reachable = false;

  json to_json(int64_t origin) const {
    const auto seconds = [=](int64_t utime) { return static_cast<double>(utime - origin) * 1e-6; };
    const bool known = closest_m < std::numeric_limits<double>::infinity();
    return {{"begin_s", seconds(begin)},
            {"end_s", seconds(end)},
            {"closest_mm", known ? json(1e3 * closest_m) : json()},
            {"closest_s", known ? json(seconds(closest_at)) : json()},
            {"reachable", reachable}};
  }
};

}  // namespace

json flights_of(std::span<const target_t> targets, const std::optional<std::string>& name,
                std::span<const TimedPosition> hand, const controller::FreeFallFilter::Options& fall,
                const controller::MultiStartIk& search, const JointVector& anywhere, int64_t origin) {
  std::vector<Flight> flights;
  controller::FreeFallFilter filter(fall);
  std::optional<std::string> followed = name;
  std::optional<Flight> flight;
  // Follows the flight up to the next observation.
  const auto follow = [&](int64_t until) {
    const int64_t end = std::min(until, filter.last_seen() + kLastSeen);
    const auto first = std::ranges::lower_bound(hand, filter.last_seen(), {}, &TimedPosition::utime);
    for (auto at = first; at != hand.end() && at->utime < end; ++at) {
      const double distance = (at->p_W - filter.at(at->utime)->position).norm();
      if (distance >= flight->closest_m) continue;
      flight->closest_m = distance;
      flight->closest_at = at->utime;
    }
    for (int64_t at = filter.last_seen(); at < end && !flight->reachable; at += kReachEvery)
      flight->reachable = search.nearest(filter.at(at)->position, anywhere).has_value();
    flight->end = end;
  };
  const auto add = [&](const Flight& found) {
    if (flights.empty() || found.begin > flights.back().end + kOneThrow) {
      flights.push_back(found);
      return;
    }
    Flight& last = flights.back();
    last.end = found.end;
    last.reachable = last.reachable || found.reachable;
    if (found.closest_m < last.closest_m) {
      last.closest_m = found.closest_m;
      last.closest_at = found.closest_at;
    }
  };
  for (const target_t& target : targets) {
    if (target.status != target_t::STATUS_TRACKED) continue;
    if (!followed) followed = target.name;
    if (target.name != *followed) continue;
    if (target.utime < filter.last_seen() - kTimeGoesBack) filter.reset();
    if (filter.falls()) follow(target.utime);
    filter.observe(target.utime, Eigen::Map<const Eigen::Vector3d>(target.position_m),
                   Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&target.covariance_m2[0][0]));
    if (filter.falls() && !flight) flight = Flight{.begin = target.utime, .end = target.utime};
    if (filter.falls() || !flight) continue;
    add(*flight);
    flight.reset();
  }
  if (flight) {
    if (filter.falls()) follow(std::numeric_limits<int64_t>::max());
    add(*flight);
  }
  json list = json::array();
  for (const Flight& each : flights) list.push_back(each.to_json(origin));
  return list;
}

}  // namespace multireach
