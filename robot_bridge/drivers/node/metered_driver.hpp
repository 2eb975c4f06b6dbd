#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "robot_bridge/drivers/driver.hpp"

namespace multireach::drivers {

/// Measures how regularly a driver commands its robot on the wire, and how late after the newest command that it got.
/// Passes everything on unchanged.
class MeteredDriver : public Driver {
 public:
  /// `clock`: monotonic, microseconds.
  MeteredDriver(std::unique_ptr<Driver> driver, std::function<int64_t()> clock)
      : driver_(std::move(driver)), clock_(std::move(clock)) {}

  std::vector<Link> links() const override { return driver_->links(); }
  void link_changed(size_t link, bool up, const Time& now, WireOutbox& out) override {
    driver_->link_changed(link, up, now, out);
  }
  void receive(size_t link, std::span<const uint8_t> bytes, const Time& now, WireOutbox& out) override {
    driver_->receive(link, bytes, now, out);
  }
  void tick(const Time& now, WireOutbox& out) override;
  void command(const JointVector& position, const JointVector& velocity, int64_t utime, const Time& now,
               WireOutbox& out) override;
  void enable(const Time& now, WireOutbox& out) override { driver_->enable(now, out); }
  void reset(const Time& now, WireOutbox& out) override { driver_->reset(now, out); }
  std::optional<Reading> take_reading() override { return driver_->take_reading(); }
  DriverStatus status() const override { return driver_->status(); }
  RefusedMessages refused() const override { return driver_->refused(); }

  /// Median, 99th percentile and maximum of the periods and of the delays, ms, as JSON. Periods above 20 ms are pauses
  /// and are left out.
  std::string report();

 private:
  static constexpr int64_t kPause = 20000;            // us
  static constexpr size_t kMostSamples = 10'000'000;  // of each

  void measure(const WireOutbox& out, size_t before);

  std::unique_ptr<Driver> driver_;
  std::function<int64_t()> clock_;
  bool commanded_ = false;  // since the last message on the wire
  int64_t commanded_us_ = 0, sent_us_ = INT64_MIN / 2;
  std::vector<int64_t> periods_us_, delays_us_;
};

}  // namespace multireach::drivers
