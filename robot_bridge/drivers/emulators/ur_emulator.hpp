#pragma once

#include <array>
#include <optional>
#include <variant>

#include "robot_bridge/drivers/emulators/emulator.hpp"
#include "robot_bridge/drivers/rtde.hpp"

namespace multireach::drivers {

/// A Universal Robots controller: RTDE (30004), dashboard server (29999), and programs sent to port 30002. It begins
/// powered off. Of URScript it understands one program, that of UrDriver: its numbers are read from its text, and it is
/// executed as it is written. A collision, or a step of servoj that is faster than a joint, is a protective stop, which
/// the dashboard server unlocks after 5 s. restart() boots it again.
class UrEmulator : public Emulator {
 public:
  /// `chain`: six joints with the manufacturer's speed limits. `start`: joint positions, rad.
  UrEmulator(const Chain& chain, const JointVector& start, bool e_series);

  std::vector<Link> links() const override;
  void link_changed(size_t link, bool up, const Time& now, WireOutbox& out) override;
  void receive(size_t link, std::span<const uint8_t> bytes, const Time& now, WireOutbox& out) override;
  void tick(const Time& now, WireOutbox& out) override;
  void collide() override { protective_stop("collision"); }
  void restart() override { reboots_ = true; }
  const JointVector& position() const override { return joints_.position; }
  const std::string& fault() const override { return fault_; }

  /// The program's text that was sent last; "" when none runs.
  const std::string& program() const { return program_; }

 private:
  struct Program {
    int id = 0, silent_steps = 0;
    int32_t last_count = 0;
    int silent = 0;
    bool moving = false;
  };

  std::variant<std::monostate, int32_t*, double*> input(const std::string& name);
  void receive_package(const rtde::Package& package, WireOutbox& out);
  std::string answer(const std::string& line);
  void start_program();
  void step_program();
  void decelerate();
  void protective_stop(const std::string& why);
  void send_data(WireOutbox& out);
  double step_s() const { return e_series_ ? 0.002 : 0.008; }

  Chain chain_;
  EmulatedJoints joints_;
  bool e_series_;
  std::string fault_, program_, script_, dashboard_;
  rtde::Stream stream_;
  std::vector<std::string> outputs_;
  std::vector<std::variant<std::monostate, int32_t*, double*>> inputs_;  // registers that a data package writes
  bool version_ = false, sends_ = false;  // version 2 of RTDE was agreed on; outputs are sent
  std::array<int32_t, 24> integers_{};    // input registers 24 to 47
  std::array<double, 24> doubles_{};
  int32_t output_register_ = 0;
  std::optional<Program> running_;
  JointVector target_;
  bool servo_ = false, stopping_ = false, reboots_ = false;
  int robot_mode_ = 3, safety_mode_ = 1, next_mode_ = 3;
  int64_t mode_change_ms_ = -1, stopped_ms_ = 0, ms_ = 0;
};

}  // namespace multireach::drivers
