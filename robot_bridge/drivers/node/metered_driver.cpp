#include "robot_bridge/drivers/node/metered_driver.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace multireach::drivers {
namespace {

nlohmann::json statistics_of(std::vector<int64_t>& values_us) {
  if (values_us.empty()) return nullptr;
  std::ranges::sort(values_us);
  const auto at = [&](double share) {
    return 1e-3 *
           static_cast<double>(values_us[static_cast<size_t>(share * static_cast<double>(values_us.size() - 1))]);
  };
  return {{"p50", at(0.5)}, {"p99", at(0.99)}, {"max", at(1)}};
}

}  // namespace

void MeteredDriver::tick(const Time& now, WireOutbox& out) {
  const size_t before = out.size();
  driver_->tick(now, out);
  measure(out, before);
}

void MeteredDriver::command(const JointVector& position, const JointVector& velocity, int64_t utime, const Time& now,
                            WireOutbox& out) {
  commanded_us_ = clock_();
  commanded_ = true;
  const size_t before = out.size();
  driver_->command(position, velocity, utime, now, out);
  measure(out, before);
}

/// The first link carries the commands.
void MeteredDriver::measure(const WireOutbox& out, size_t before) {
  const bool sent = std::any_of(out.begin() + static_cast<std::ptrdiff_t>(before), out.end(),
                                [](const WireBytes& message) { return message.link == 0 && !message.bytes.empty(); });
  if (!sent || !commanded_) return;
  commanded_ = false;
  const int64_t now = clock_(), period = now - std::exchange(sent_us_, now);
  if (delays_us_.size() >= kMostSamples) return;
  delays_us_.push_back(now - commanded_us_);
  if (period <= kPause) periods_us_.push_back(period);
}

std::string MeteredDriver::report() {
  const nlohmann::json report{{"messages", delays_us_.size()},
                              {"period_ms", statistics_of(periods_us_)},
                              {"delay_ms", statistics_of(delays_us_)}};
  return report.dump(1) + "\n";
}

}  // namespace multireach::drivers
