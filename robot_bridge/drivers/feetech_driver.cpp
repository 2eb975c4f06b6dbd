#include "robot_bridge/drivers/feetech_driver.hpp"

#include <numbers>

namespace multireach::drivers {
namespace {

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
  feetech::Packet packet{feetech::kBroadcast, feetech::kSyncWrite, {kTorque, 1}};
  for (const Motor& motor : motors()) {
    packet.parameters.push_back(static_cast<uint8_t>(motor.id));
    packet.parameters.push_back(1);
  }
  append(packet, bytes);
}

void FeetechDriver::append_goals(const std::vector<int>& steps, std::vector<uint8_t>& bytes) {
  feetech::Packet packet{feetech::kBroadcast, feetech::kSyncWrite, {kGoal, 2}};
  for (size_t i = 0; i < motors().size(); ++i) {
    packet.parameters.push_back(static_cast<uint8_t>(motors()[i].id));
    append_word(feetech::sign_magnitude(steps[i]), packet.parameters);
  }
  append(packet, bytes);
}

void FeetechDriver::append_read(std::vector<uint8_t>& bytes) {
  feetech::Packet packet{feetech::kBroadcast, feetech::kSyncRead, {kPosition, 4}};
  for (const Motor& motor : motors()) packet.parameters.push_back(static_cast<uint8_t>(motor.id));
  append(packet, bytes);
}

void FeetechDriver::append_reset(std::vector<uint8_t>& bytes) {
  feetech::Packet packet{feetech::kBroadcast, feetech::kSyncWrite, {kTorque, 1}};
  for (const Motor& motor : motors()) {
    packet.parameters.push_back(static_cast<uint8_t>(motor.id));
    packet.parameters.push_back(0);
  }
  append(packet, bytes);
}

void FeetechDriver::receive(size_t, std::span<const uint8_t> bytes, const Time& now, WireOutbox&) {
  stream_.add(bytes);
  while (const auto packet = stream_.next()) {
    if (packet->parameters.size() != 4) continue;
    const auto word = [&](size_t at) {
      return feetech::from_sign_magnitude(
          static_cast<uint16_t>(packet->parameters[at] | packet->parameters[at + 1] << 8));
    };
    answered(packet->id, word(0), word(2), fault_of(packet->instruction), now);
  }
}

}  // namespace multireach::drivers
