#include "robot_bridge/drivers/feetech_driver.hpp"

#include <numbers>

namespace multireach::drivers {
namespace {

constexpr uint8_t kLimits = 9, kLimitsSize = 6;  // smallest and largest position, largest temperature and voltage
constexpr int kEndless = 0x7FFF;                 // steps
constexpr uint8_t kMeasuredSize = 4;             // position, speed
constexpr uint8_t kTorque = 40, kGoal = 42, kPosition = 56;

void append(const feetech::Packet& packet, std::vector<uint8_t>& bytes) {
  const std::vector<uint8_t> packed = feetech::encode(packet);
  bytes.insert(bytes.end(), packed.begin(), packed.end());
}

void append_word(uint16_t value, std::vector<uint8_t>& bytes) {
  bytes.push_back(static_cast<uint8_t>(value));
  bytes.push_back(static_cast<uint8_t>(value >> 8));
}

const char* fault_of(uint8_t status) {
  if (status & 1) return "supply voltage";
  if (status & 2) return "encoder";
  if (status & 4) return "too hot";
  if (status & 8) return "current too large";
  return status & 32 ? "overload" : "";
}

}  // namespace

double FeetechDriver::velocity_unit() const {
  return 2 * std::numbers::pi / kStepsPerTurn;
}

void FeetechDriver::append_start(std::vector<uint8_t>& bytes) {
  std::vector<int> here;
  for (const Motor& motor : motors()) here.push_back(motor.position);
  append_goals(here, bytes);
  append_sync_write(kTorque, 1, bytes);
}

void FeetechDriver::append_goals(const std::vector<int>& steps, std::vector<uint8_t>& bytes) {
  feetech::Packet packet{feetech::kBroadcast, feetech::kSyncWrite, {kGoal, 2}};
  for (size_t i = 0; i < motors().size(); ++i) {
    packet.parameters.push_back(static_cast<uint8_t>(motors()[i].id));
    append_word(feetech::sign_magnitude(steps[i]), packet.parameters);
  }
  append(packet, bytes);
}

/// Writes one byte to all motors.
void FeetechDriver::append_sync_write(uint8_t address, uint8_t value, std::vector<uint8_t>& bytes) const {
  feetech::Packet packet{feetech::kBroadcast, feetech::kSyncWrite, {address, 1}};
  for (const Motor& motor : motors()) {
    packet.parameters.push_back(static_cast<uint8_t>(motor.id));
    packet.parameters.push_back(value);
  }
  append(packet, bytes);
}

void FeetechDriver::append_read(std::vector<uint8_t>& bytes) {
  append_sync_read(kPosition, kMeasuredSize, bytes);
}

void FeetechDriver::append_read_limits(std::vector<uint8_t>& bytes) {
  append_sync_read(kLimits, kLimitsSize, bytes);
}

void FeetechDriver::append_sync_read(uint8_t address, uint8_t size, std::vector<uint8_t>& bytes) const {
  feetech::Packet packet{feetech::kBroadcast, feetech::kSyncRead, {address, size}};
  for (const Motor& motor : motors()) packet.parameters.push_back(static_cast<uint8_t>(motor.id));
  append(packet, bytes);
}

void FeetechDriver::append_reset(std::vector<uint8_t>& bytes) {
  append_sync_write(kTorque, 0, bytes);
}

void FeetechDriver::receive(size_t, std::span<const uint8_t> bytes, const Time& now, WireOutbox&) {
  stream_.add(bytes);
  while (const auto packet = stream_.next()) {
    const auto word = [&](size_t at) {
      return feetech::from_sign_magnitude(
          static_cast<uint16_t>(packet->parameters[at] | packet->parameters[at + 1] << 8));
    };
    if (packet->parameters.size() == kLimitsSize) {
      const bool endless = word(0) == 0 && word(2) == 0;  // turns without limits
      answered_limits(packet->id, endless ? -kEndless : word(0), endless ? kEndless : word(2));
    }
    if (packet->parameters.size() != kMeasuredSize) continue;
    answered(packet->id, word(0), word(2), fault_of(packet->instruction), now);
  }
}

}  // namespace multireach::drivers
