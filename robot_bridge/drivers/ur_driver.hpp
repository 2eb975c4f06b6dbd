#pragma once

#include "robot_bridge/drivers/driver.hpp"
#include "robot_bridge/drivers/rtde.hpp"

namespace multireach::drivers {

struct UrOptions {
  std::string host = "127.0.0.1";
  bool e_series = true;       ///< e-Series: 500 Hz; else CB3: 125 Hz
  double lookahead_s = 0.03;  ///< of servoj, 0.03 to 0.2
  double gain = 500;          ///< of servoj, 100 to 2000
};

/// The URScript program that runs on the robot. It follows the joint positions in the input registers with servoj. When
/// the counter in register 24 stands still for 20 ms, it decelerates with stopj and ends. While it runs, output
/// register 24 holds `id`.
std::string ur_program(const UrOptions& options, int id);

/// Universal Robots: joint positions through RTDE registers (port 30004) to a program that the driver sends (port
/// 30002); power, brakes and protective stops through the dashboard server (port 29999). A counter in each period tells
/// the program that the driver is running, also while nothing is commanded. A controller that accepts a connection and
/// does not answer is a fault, and is connected again.
class UrDriver : public Driver {
 public:
  explicit UrDriver(const UrOptions& options) : options_(options), divider_(period_us()) {}

  std::vector<Link> links() const override;
  void link_changed(size_t link, bool up, const Time& now, WireOutbox& out) override;
  void receive(size_t link, std::span<const uint8_t> bytes, const Time& now, WireOutbox& out) override;
  void tick(const Time& now, WireOutbox& out) override;
  void command(const JointVector& position, const JointVector& velocity, int64_t utime, const Time& now,
               WireOutbox& out) override;
  void enable(const Time& now, WireOutbox& out) override;
  void reset(const Time& now, WireOutbox& out) override;
  std::optional<Reading> take_reading() override { return std::exchange(reading_, std::nullopt); }
  DriverStatus status() const override;

 private:
  enum class Setup { kNone, kVersion, kOutputs, kInputs, kStart, kRunning, kRefused };

  int64_t period_us() const { return options_.e_series ? 2000 : 8000; }
  void receive_package(const rtde::Package& package, const Time& now, WireOutbox& out);
  bool receive_data(std::span<const uint8_t> payload);
  void receive_answer(const std::string& line);
  void refuse(const std::string& why);
  void send_registers(const Time& now, WireOutbox& out);
  void ask_dashboard(const std::string& line, const Time& now, WireOutbox& out);
  void watch_dashboard(const Time& now, WireOutbox& out);
  void bring_up(const Time& now, WireOutbox& out);
  bool running() const { return program_ != 0 && program_ == id_; }

  UrOptions options_;
  RateDivider divider_;
  rtde::Stream stream_;
  std::string answers_;
  Setup setup_ = Setup::kNone;
  std::string refusal_;
  uint8_t input_recipe_ = 0, output_recipe_ = 0;
  bool dashboard_ = false, script_ = false, enabled_ = false, stopped_ = false, reset_asked_ = false, local_ = false;
  bool streams_ = false;                  // data have come since RTDE was connected
  bool silent_ = false;                   // RTDE was connected, and did not answer in time
  bool unreadable_ = false;               // the newest data have not the agreed form
  std::optional<int64_t> unanswered_us_;  // since when the dashboard server owes an answer
  bool dashboard_silent_ = false;         // it did not answer in time
  int robot_mode_ = -1, safety_mode_ = 1, program_ = 0, id_ = 0;
  int64_t heard_us_ = 0, next_action_us_ = 0, sent_us_ = 0, commanded_us_ = INT64_MIN / 2;
  int32_t counter_ = 0;
  JointVector goal_ = JointVector::Zero(6);
  std::optional<Reading> reading_;
};

}  // namespace multireach::drivers
