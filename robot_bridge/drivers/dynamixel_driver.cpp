#include "robot_bridge/drivers/dynamixel_driver.hpp"

#include <algorithm>
#include <numbers>

namespace multireach::drivers {
namespace {

// Registers of the X series.
constexpr int kLimits = 44, kLimitsSize = 12;  // velocity limit, largest and smallest position
constexpr int kMeasuredSize = 8;               // velocity, position
constexpr int kTorque = 64, kWatchdog = 98, kGoal = 116, kVelocity = 128;
constexpr int64_t kWatchdogUnit = 20000;  // us
constexpr uint8_t kAlert = 0x80;          // of a status: register 70 is not 0
constexpr double kVelocityUnit = 0.229;   // rpm

void append(const dynamixel::Packet& packet, std::vector<uint8_t>& bytes) {
  const std::vector<uint8_t> packed = dynamixel::encode(packet);
  bytes.insert(bytes.end(), packed.begin(), packed.end());
}

}  // namespace

/// 3 units, and where the period is longer than one of them, two periods at least.
int DynamixelDriver::watchdog_units() const {
  const int64_t two_periods = (2 * period_us() + kWatchdogUnit - 1) / kWatchdogUnit;
  return std::max(3, static_cast<int>(two_periods) + 1);
}

/// The watchdog counts in units: it may expire up to one unit early.
int64_t DynamixelDriver::most_late_us() const {
  return (watchdog_units() - 1) * kWatchdogUnit;
}

double DynamixelDriver::velocity_unit() const {
  return kVelocityUnit * 2 * std::numbers::pi / 60;
}

void DynamixelDriver::append_sync_write(int address, int size, const std::vector<int>& values,
                                        std::vector<uint8_t>& bytes) const {
  dynamixel::Packet packet{dynamixel::kBroadcast, dynamixel::kSyncWrite, {}};
  dynamixel::put(packet.parameters, address, 2);
  dynamixel::put(packet.parameters, size, 2);
  for (size_t i = 0; i < motors().size(); ++i) {
    packet.parameters.push_back(static_cast<uint8_t>(motors()[i].id));
    dynamixel::put(packet.parameters, values[i], size);
  }
  append(packet, bytes);
}

void DynamixelDriver::append_start(std::vector<uint8_t>& bytes) {
  std::vector<int> here;
  for (const Motor& motor : motors()) here.push_back(motor.position);
  const std::vector<int> zeros(here.size(), 0), ones(here.size(), 1), watchdog(here.size(), watchdog_units());
  append_sync_write(kWatchdog, 1, zeros, bytes);  // a watchdog that has expired refuses goals until it is cleared
  append_sync_write(kGoal, 4, here, bytes);
  append_sync_write(kTorque, 1, ones, bytes);
  append_sync_write(kWatchdog, 1, watchdog, bytes);
}

void DynamixelDriver::append_goals(const std::vector<int>& steps, std::vector<uint8_t>& bytes) {
  append_sync_write(kGoal, 4, steps, bytes);
}

void DynamixelDriver::append_read(std::vector<uint8_t>& bytes) {
  append_sync_read(kVelocity, kMeasuredSize, bytes);
}

void DynamixelDriver::append_read_limits(std::vector<uint8_t>& bytes) {
  append_sync_read(kLimits, kLimitsSize, bytes);
}

void DynamixelDriver::append_sync_read(int address, int size, std::vector<uint8_t>& bytes) const {
  dynamixel::Packet packet{dynamixel::kBroadcast, dynamixel::kSyncRead, {}};
  dynamixel::put(packet.parameters, address, 2);
  dynamixel::put(packet.parameters, size, 2);
  for (const Motor& motor : motors()) packet.parameters.push_back(static_cast<uint8_t>(motor.id));
  append(packet, bytes);
}

void DynamixelDriver::append_reset(std::vector<uint8_t>& bytes) {
  for (const int id : alerted_) append({static_cast<uint8_t>(id), dynamixel::kReboot, {}}, bytes);
  alerted_.clear();
}

void DynamixelDriver::receive(size_t, std::span<const uint8_t> bytes, const Time& now, WireOutbox&) {
  stream_.add(bytes);
  while (const auto packet = stream_.next()) {
    if (packet->instruction != dynamixel::kStatus) continue;
    if (packet->parameters.size() == 1 + kLimitsSize)
      answered_limits(packet->id, dynamixel::get(packet->parameters, 9, 4), dynamixel::get(packet->parameters, 5, 4));
    if (packet->parameters.size() != 1 + kMeasuredSize) continue;
    const bool alert = packet->parameters[0] & kAlert;
    if (alert && std::ranges::find(alerted_, packet->id) == alerted_.end()) alerted_.push_back(packet->id);
    answered(
        packet->id, dynamixel::get(packet->parameters, 5, 4), dynamixel::get(packet->parameters, 1, 4),
        alert ? "hardware error (overload, heat, voltage, shock or encoder): support the arm, see to the cause" : "",
        now);
  }
}

}  // namespace multireach::drivers
