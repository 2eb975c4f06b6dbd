#include "robot_bridge/drivers/ur_driver.hpp"

#include <fmt/format.h>

#include <cmath>

namespace multireach::drivers {
namespace {

constexpr size_t kRtde = 0, kDashboard = 1, kScript = 2;
constexpr size_t kLongestAnswer = 4096;
constexpr double kSilence = 0.02;            // s: without a new counter for this long, the program ends
constexpr int64_t kLate = 100000;            // us without data
constexpr int64_t kActionPeriod = 1000000;   // us from one attempt to the next
constexpr int64_t kAnswerTime = 2000000;     // us: a controller that runs answers each step of the set-up within 10 ms
constexpr int64_t kDashboardTime = 5000000;  // us

constexpr std::string_view kOutputs = "actual_q,actual_qd,robot_mode,safety_mode,output_int_register_24";
constexpr std::string_view kOutputTypes = "VECTOR6D,VECTOR6D,INT32,INT32,INT32";
constexpr std::string_view kInputs =
    "input_int_register_24,input_int_register_25,input_double_register_24,input_double_register_25,"
    "input_double_register_26,input_double_register_27,input_double_register_28,input_double_register_29";
constexpr std::string_view kInputTypes = "INT32,INT32,DOUBLE,DOUBLE,DOUBLE,DOUBLE,DOUBLE,DOUBLE";

// Values of robot_mode and safety_mode.
constexpr int kPowerOff = 3, kIdle = 5, kRunningMode = 7;
constexpr int kNormal = 1, kReduced = 2, kProtectiveStop = 3;

}  // namespace

std::string ur_program(const UrOptions& options, int id) {
  const double step = options.e_series ? 0.002 : 0.008;
  const int silent = static_cast<int>(std::ceil(kSilence / step - 1e-9));
  return fmt::format(R"(def multireach():
  write_output_integer_register(24, {id})
  local last = read_input_integer_register(24)
  local silent = 0
  local moving = False
  while silent < {silent}:
    local count = read_input_integer_register(24)
    if count == last:
      silent = silent + 1
    else:
      silent = 0
      last = count
    end
    if read_input_integer_register(25) == 1:
      local q = [read_input_float_register(24), read_input_float_register(25), read_input_float_register(26), read_input_float_register(27), read_input_float_register(28), read_input_float_register(29)]
      servoj(q, 0, 0, {step}, {lookahead}, {gain})
      moving = True
    else:
      if moving:
        stopj(4.0)
        moving = False
      end
      sync()
    end
  end
  if moving:
    stopj(4.0)
  end
  write_output_integer_register(24, 0)
end
)",
                     fmt::arg("id", id), fmt::arg("silent", silent), fmt::arg("step", step),
                     fmt::arg("lookahead", options.lookahead_s), fmt::arg("gain", options.gain));
}

std::vector<Link> UrDriver::links() const {
  std::vector<Link> links;
  for (const int port : {30004, 29999, 30002})
    links.push_back({.kind = Link::Kind::kTcp, .address = options_.host, .number = port});
  return links;
}

void UrDriver::link_changed(size_t link, bool up, const Time& now, WireOutbox& out) {
  if (link == kDashboard) {
    dashboard_ = up;
    answers_.clear();
    unanswered_us_.reset();
    if (up && options_.e_series) ask_dashboard("is in remote control", now, out);
  } else if (link == kScript) {
    script_ = up;
  } else {
    stream_.clear();
    streams_ = false;
    setup_ = up ? Setup::kVersion : Setup::kNone;
    program_ = 0;
    heard_us_ = now.us;
    if (!up) enabled_ = enabled_ && robot_mode_ < 0;  // a robot that was there must be enabled again
    if (up) out.push_back({kRtde, rtde::request_version()});
  }
}

void UrDriver::receive(size_t link, std::span<const uint8_t> bytes, const Time& now, WireOutbox& out) {
  if (link == kScript) return;  // the robot's state in another form
  if (link == kDashboard) {
    answers_.append(bytes.begin(), bytes.end());
    unanswered_us_.reset();
    dashboard_silent_ = false;
    for (size_t end; (end = answers_.find('\n')) != std::string::npos; answers_.erase(0, end + 1))
      receive_answer(answers_.substr(0, end));
    if (answers_.size() > kLongestAnswer) {  // no dashboard server
      answers_.clear();
      out.push_back({kDashboard, {}, true});
    }
    return;
  }
  stream_.add(bytes);
  while (const auto package = stream_.next()) receive_package(*package, now, out);
  if (stream_.broken()) out.push_back({kRtde, {}, true});
}

void UrDriver::receive_answer(const std::string& line) {
  if (line == "true" || line == "false") local_ = line == "false";
}

void UrDriver::refuse(const std::string& why) {
  setup_ = Setup::kRefused;
  refusal_ = why;
}

void UrDriver::receive_package(const rtde::Package& package, const Time& now, WireOutbox& out) {
  rtde::Reader reader(package.payload);
  const bool data = package.type == rtde::Type::kData;
  if (package.type != rtde::Type::kText && !data) heard_us_ = now.us;
  switch (package.type) {
    case rtde::Type::kVersion:
      if (setup_ != Setup::kVersion) return;
      if (reader.u8() != 1) return refuse("the robot's software does not know RTDE version 2");
      setup_ = Setup::kOutputs;
      out.push_back({kRtde, rtde::setup_outputs(1e6 / static_cast<double>(period_us()), kOutputs)});
      return;
    case rtde::Type::kSetupOutputs:
      if (setup_ != Setup::kOutputs) return;
      output_recipe_ = reader.u8();
      if (reader.rest() != kOutputTypes) return refuse("RTDE does not offer actual_q, actual_qd and the modes");
      setup_ = Setup::kInputs;
      out.push_back({kRtde, rtde::setup_inputs(kInputs)});
      return;
    case rtde::Type::kSetupInputs:
      if (setup_ != Setup::kInputs) return;
      input_recipe_ = reader.u8();
      if (reader.rest() != kInputTypes)
        return refuse("the input registers 24 to 29 of RTDE are in use by another program, e.g. a fieldbus");
      setup_ = Setup::kStart;
      out.push_back({kRtde, rtde::start()});
      return;
    case rtde::Type::kStart:
      if (setup_ != Setup::kStart) return;
      if (reader.u8() != 1) return refuse("the robot does not start RTDE");
      setup_ = Setup::kRunning;
      return;
    case rtde::Type::kData:
      if (setup_ != Setup::kRunning) return;
      unreadable_ = !receive_data(package.payload);
      if (!unreadable_) heard_us_ = now.us;
      return;
    default:
      return;
  }
}

/// Whether it has the form that was agreed on.
bool UrDriver::receive_data(std::span<const uint8_t> payload) {
  rtde::Reader reader(payload);
  if (reader.u8() != output_recipe_) return false;
  Reading reading{JointVector(6), JointVector(6), JointVector::Zero(6)};
  for (double& value : reading.position) value = reader.real();
  for (double& value : reading.velocity) value = reader.real();
  const int robot_mode = reader.i32(), safety_mode = reader.i32(), program = reader.i32();
  if (!reader.at_end() || !reading.position.allFinite() || !reading.velocity.allFinite()) return false;
  streams_ = true;
  silent_ = false;
  robot_mode_ = robot_mode;
  safety_mode_ = safety_mode;
  program_ = program;
  if (safety_mode != kNormal && safety_mode != kReduced && !stopped_) {
    stopped_ = true;
    reset_asked_ = false;
  }
  if (safety_mode > kProtectiveStop) enabled_ = false;  // an emergency stop takes the power away
  reading_ = std::move(reading);
  return true;
}

void UrDriver::ask_dashboard(const std::string& line, const Time& now, WireOutbox& out) {
  if (!dashboard_) return;
  if (!unanswered_us_) unanswered_us_ = now.us;
  out.push_back({kDashboard, rtde::Writer().text(line).u8('\n').bytes()});
}

void UrDriver::enable(const Time& now, WireOutbox&) {
  enabled_ = true;
  next_action_us_ = now.us;
}

void UrDriver::reset(const Time& now, WireOutbox& out) {
  if (setup_ == Setup::kRefused) out.push_back({kRtde, {}, true});  // what was refused may be possible now
  reset_asked_ = stopped_;
  next_action_us_ = now.us;
}

void UrDriver::command(const JointVector& position, const JointVector&, int64_t utime, const Time& now,
                       WireOutbox& out) {
  if (!running() || position.size() != 6) return;
  goal_ = position;
  commanded_us_ = now.us;
  if (divider_.is_due(utime)) send_registers(now, out);
}

void UrDriver::send_registers(const Time& now, WireOutbox& out) {
  if (setup_ != Setup::kRunning) return;
  // The driver node goes on commanding while it decelerates the arm: commands that ended need no ramp here.
  const bool follows = now.us - commanded_us_ < 2 * static_cast<int64_t>(kSilence * 1e6);
  rtde::Writer data;
  data.u8(input_recipe_).i32(++counter_).i32(follows ? 1 : 0);
  for (const double value : goal_) data.real(value);
  out.push_back({kRtde, rtde::encode(rtde::Type::kData, data.bytes())});
  sent_us_ = now.us;
}

/// One step on the way from where the robot is to a running program.
void UrDriver::bring_up(const Time& now, WireOutbox& out) {
  if (stopped_ && (safety_mode_ == kNormal || safety_mode_ == kReduced) && reset_asked_) stopped_ = false;
  if (now.us < next_action_us_ || running()) return;
  next_action_us_ = now.us + kActionPeriod;
  if (stopped_) {
    if (!reset_asked_ || safety_mode_ != kProtectiveStop) return;
    ask_dashboard("close safety popup", now, out);
    ask_dashboard("unlock protective stop", now, out);
  } else if (enabled_ && robot_mode_ == kPowerOff) {
    ask_dashboard("power on", now, out);
  } else if (enabled_ && robot_mode_ == kIdle) {
    ask_dashboard("brake release", now, out);
  } else if (enabled_ && robot_mode_ == kRunningMode && script_) {
    id_ = id_ % 1000 + 1;
    out.push_back({kScript, rtde::Writer().text(ur_program(options_, id_)).bytes()});
    if (options_.e_series) ask_dashboard("is in remote control", now, out);
  }
}

/// A dashboard server that does not answer is connected again.
void UrDriver::watch_dashboard(const Time& now, WireOutbox& out) {
  if (!unanswered_us_ || now.us - *unanswered_us_ < kDashboardTime) return;
  unanswered_us_.reset();
  dashboard_silent_ = true;
  out.push_back({kDashboard, {}, true});
}

void UrDriver::tick(const Time& now, WireOutbox& out) {
  watch_dashboard(now, out);
  if (setup_ == Setup::kNone || setup_ == Setup::kRefused) return;
  if (now.us - heard_us_ > (streams_ ? kLate : kAnswerTime)) {
    silent_ = silent_ || (!streams_ && !unreadable_);
    program_ = 0;
    heard_us_ = now.us;
    out.push_back({kRtde, {}, true});
    return;
  }
  if (setup_ != Setup::kRunning) return;
  bring_up(now, out);
  if (now.us - sent_us_ >= period_us() + 1000) send_registers(now, out);
}

DriverStatus UrDriver::status() const {
  using Phase = DriverStatus::Phase;
  if (unreadable_ && setup_ != Setup::kNone) {  // without a connection this is no news
    return {Phase::kFault, options_.host +
                               ", port 30004: the data do not have the agreed form (VECTOR6D actual_q and actual_qd, "
                               "three INT32), or are not finite: is this the robot? Connecting again"};
  }
  if (silent_) {
    return {Phase::kFault, options_.host +
                               " accepts connections on port 30004, but does not answer: the robot is still starting, "
                               "or must be started again; connecting again"};
  }
  if (setup_ == Setup::kNone) return {Phase::kWaiting, "not connected to " + options_.host + ", port 30004"};
  if (setup_ == Setup::kRefused) return {Phase::kFault, refusal_};
  if (setup_ != Setup::kRunning || robot_mode_ < 0) return {Phase::kWaiting, "starting RTDE"};
  if (stopped_ || (safety_mode_ != kNormal && safety_mode_ != kReduced)) {
    switch (safety_mode_) {
      case kProtectiveStop:
        return {Phase::kFault, "protective stop: see why, wait 5 s, then multireach-robot reset"};
      case 5:
        return {Phase::kFault, "safeguard stop: close the safeguard, then multireach-robot reset"};
      case 6:
      case 7:
        return {Phase::kFault, "emergency stop: release it, then multireach-robot reset and enable"};
      case kNormal:
      case kReduced:
        return {Phase::kFault, "the robot had stopped: multireach-robot reset"};
      default:
        return {Phase::kFault, "safety violation or fault: restart the robot's safety system at its pendant"};
    }
  }
  if (running()) return {Phase::kReady, "ready"};
  if (dashboard_silent_) {
    return {Phase::kFault,
            "the dashboard server (port 29999) accepts connections, but does not answer: start the robot "
            "again; connecting again"};
  }
  if (!enabled_) return {Phase::kWaiting, "waiting for multireach-robot enable"};
  if (local_) return {Phase::kWaiting, "the robot is in local control: switch it to remote control at its pendant"};
  if (robot_mode_ != kRunningMode) return {Phase::kWaiting, "the robot is powered on"};
  return {Phase::kWaiting, "the program is sent to the robot"};
}

}  // namespace multireach::drivers
