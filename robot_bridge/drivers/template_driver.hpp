#pragma once

#include <cstring>

#include "robot_bridge/drivers/driver.hpp"

namespace multireach::drivers {

/// A driver to copy: for a robot that takes joint positions and tells its own as little-endian doubles over TCP, in
/// both directions n positions without a header. docs/your-robot.md explains each part.
class TemplateDriver : public Driver {
 public:
  TemplateDriver(int joints, std::string host, int port) : reading_{}, host_(std::move(host)), port_(port) {
    reading_.position = reading_.velocity = reading_.effort = JointVector::Zero(joints);
  }

  std::vector<Link> links() const override { return {{.kind = Link::Kind::kTcp, .address = host_, .number = port_}}; }
  void link_changed(size_t, bool up, const Time&, WireOutbox&) override {
    connected_ = up;
    buffer_.clear();
  }
  void receive(size_t, std::span<const uint8_t> bytes, const Time& now, WireOutbox&) override {
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
    const size_t size = sizeof(double) * static_cast<size_t>(reading_.position.size());
    for (; buffer_.size() >= size; buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<long>(size))) {
      JointVector position = reading_.position;
      std::memcpy(position.data(), buffer_.data(), size);
      const double seconds = static_cast<double>(now.us - heard_us_) * 1e-6;
      if (measured_ && seconds > 0) reading_.velocity = (position - reading_.position) / seconds;
      reading_.position = position;
      heard_us_ = now.us;
      measured_ = fresh_ = true;
    }
  }
  void command(const JointVector& position, const JointVector&, int64_t, const Time&, WireOutbox& out) override {
    const auto* bytes = reinterpret_cast<const uint8_t*>(position.data());
    out.push_back({0, {bytes, bytes + sizeof(double) * static_cast<size_t>(position.size())}});
  }
  void tick(const Time& now, WireOutbox&) override { silent_ = now.us - heard_us_ > kSilence; }
  std::optional<Reading> take_reading() override {
    return std::exchange(fresh_, false) ? std::optional(reading_) : std::nullopt;
  }
  DriverStatus status() const override {
    if (!connected_) return {DriverStatus::Phase::kWaiting, "not connected to " + host_};
    if (!measured_ || silent_) return {DriverStatus::Phase::kWaiting, "the robot sends no positions"};
    return {DriverStatus::Phase::kReady, "ready"};
  }

 private:
  static constexpr int64_t kSilence = 100000;  // us

  Reading reading_;
  std::string host_;
  int port_;
  std::vector<uint8_t> buffer_;
  int64_t heard_us_ = 0;
  bool connected_ = false, measured_ = false, silent_ = false, fresh_ = false;
};

}  // namespace multireach::drivers
