#include "robot_bridge/drivers/emulators/ur_emulator.hpp"

#include <cmath>
#include <map>
#include <regex>
#include <sstream>
#include <utility>

namespace multireach::drivers {
namespace {

constexpr size_t kRtde = 0, kDashboard = 1, kScript = 2;
constexpr size_t kFirstRegister = 24;                         // of those for clients; the lower ones are a fieldbus's
constexpr int64_t kPowerOnMs = 2000, kBrakeReleaseMs = 1000;  // assumed
constexpr int64_t kUnlockAfterMs = 5000;
constexpr double kServo = 60;           // rad/s: a delay of about 34 ms, as measured with lookahead 0.03
constexpr double kStopRate = 4;         // rad/s^2, of stopj in the program
constexpr double kProtectiveRate = 25;  // rad/s^2, assumed
constexpr double kStepMargin = 1.5;     // of a joint's largest speed in one step of servoj

// Values of robot_mode and safety_mode.
constexpr int kPowerOff = 3, kIdle = 5, kRunningMode = 7;
constexpr int kNormal = 1, kProtectiveStop = 3;

std::vector<std::string> split(const std::string& names) {
  std::vector<std::string> parts;
  std::istringstream in(names);
  for (std::string part; std::getline(in, part, ',');) parts.push_back(part);
  return parts;
}

/// The number that `pattern` captures in `text`.
std::optional<double> number_in(const std::string& text, const std::string& pattern) {
  std::smatch match;
  if (!std::regex_search(text, match, std::regex(pattern))) return std::nullopt;
  return std::stod(match[1]);
}

}  // namespace

UrEmulator::UrEmulator(const Chain& chain, const JointVector& start, bool e_series)
    : chain_(chain), joints_(start), e_series_(e_series), target_(start) {}

std::vector<Link> UrEmulator::links() const {
  std::vector<Link> links;
  for (const int port : {30004, 29999, 30002}) links.push_back({.kind = Link::Kind::kTcp, .number = port});
  return links;
}

void UrEmulator::link_changed(size_t link, bool up, const Time&, WireOutbox& out) {
  if (link == kRtde) {
    stream_.clear();
    version_ = sends_ = false;
    outputs_.clear();
    inputs_.clear();
  } else if (link == kScript) {
    script_.clear();
  } else {
    dashboard_.clear();
    if (up) out.push_back({kDashboard, rtde::Writer().text("Connected: Universal Robots Dashboard Server\n").bytes()});
  }
}

void UrEmulator::receive(size_t link, std::span<const uint8_t> bytes, const Time&, WireOutbox& out) {
  if (link == kRtde) {
    stream_.add(bytes);
    while (const auto package = stream_.next()) receive_package(*package, out);
    if (stream_.broken()) out.push_back({kRtde, {}, true});
  } else if (link == kScript) {
    script_.append(bytes.begin(), bytes.end());
    if (script_.ends_with("\nend\n")) start_program();
  } else {
    dashboard_.append(bytes.begin(), bytes.end());
    for (size_t end; (end = dashboard_.find('\n')) != std::string::npos; dashboard_.erase(0, end + 1)) {
      const std::string line = answer(dashboard_.substr(0, end)) + "\n";
      out.push_back({kDashboard, rtde::Writer().text(line).bytes()});
    }
  }
}

/// The input register that `name` names; nothing for another name.
std::variant<std::monostate, int32_t*, double*> UrEmulator::input(const std::string& name) {
  for (size_t i = 0; i < integers_.size(); ++i) {
    const std::string number = std::to_string(kFirstRegister + i);
    if (name == "input_int_register_" + number) return &integers_[i];
    if (name == "input_double_register_" + number) return &doubles_[i];
  }
  return {};
}

void UrEmulator::receive_package(const rtde::Package& package, WireOutbox& out) {
  static const std::map<std::string, std::string> kTypes{{"actual_q", "VECTOR6D"}, {"actual_qd", "VECTOR6D"},
                                                         {"robot_mode", "INT32"},  {"safety_mode", "INT32"},
                                                         {"timestamp", "DOUBLE"},  {"output_int_register_24", "INT32"}};
  rtde::Reader reader(package.payload);
  const auto reply = [&](const rtde::Writer& payload) {
    out.push_back({kRtde, rtde::encode(package.type, payload.bytes())});
  };
  const auto types = [](const std::vector<std::string>& names, const auto& type_of) {
    std::string list;
    for (const std::string& name : names) list += (list.empty() ? "" : ",") + type_of(name);
    return list;
  };
  const auto known = [](const std::string& list) { return list.find("NOT_FOUND") == std::string::npos; };
  switch (package.type) {
    case rtde::Type::kVersion:
      version_ = reader.u16() == 2;
      return reply(rtde::Writer().u8(version_ ? 1 : 0));
    case rtde::Type::kController:
      return reply(rtde::Writer().i32(e_series_ ? 5 : 3).i32(15).i32(0).i32(0));
    case rtde::Type::kSetupOutputs: {
      if (!version_) return;
      const double rate = reader.real();
      outputs_ = split(reader.rest());
      const std::string list = types(outputs_, [&](const std::string& name) {
        const auto found = kTypes.find(name);
        return found == kTypes.end() ? std::string("NOT_FOUND") : found->second;
      });
      const bool accepted = known(list) && rate > 0 && rate <= 1.01 / step_s();
      if (!accepted) outputs_.clear();
      return reply(rtde::Writer().u8(accepted ? 1 : 0).text(list));
    }
    case rtde::Type::kSetupInputs: {
      if (!version_) return;
      inputs_.clear();
      const std::string list = types(split(reader.rest()), [this](const std::string& name) {
        constexpr std::array<const char*, 3> kNames{"NOT_FOUND", "INT32", "DOUBLE"};
        inputs_.push_back(input(name));
        return std::string(kNames[inputs_.back().index()]);
      });
      if (!known(list)) inputs_.clear();
      return reply(rtde::Writer().u8(inputs_.empty() ? 0 : 1).text(list));
    }
    case rtde::Type::kStart:
      sends_ = !outputs_.empty();
      return reply(rtde::Writer().u8(sends_ ? 1 : 0));
    case rtde::Type::kPause:
      sends_ = false;
      return reply(rtde::Writer().u8(1));
    case rtde::Type::kData:
      if (reader.u8() != 1) return;
      for (const auto& input : inputs_) {
        if (const auto integer = std::get_if<int32_t*>(&input)) **integer = reader.i32();
        if (const auto number = std::get_if<double*>(&input)) **number = reader.real();
      }
      return;
    default:
      return;
  }
}

std::string UrEmulator::answer(const std::string& line) {
  if (line == "is in remote control" && e_series_) return "true";
  if (line == "power on") {
    if (robot_mode_ == kPowerOff && mode_change_ms_ < 0) {
      next_mode_ = kIdle;
      mode_change_ms_ = ms_ + kPowerOnMs;
    }
    return "Powering on";
  }
  if (line == "brake release") {
    if (robot_mode_ == kIdle && mode_change_ms_ < 0) {
      next_mode_ = kRunningMode;
      mode_change_ms_ = ms_ + kBrakeReleaseMs;
    }
    return "Brake releasing";
  }
  if (line == "close safety popup") return "closing safety popup";
  if (line == "unlock protective stop") {
    if (safety_mode_ != kProtectiveStop) return "Cannot unlock protective stop: there is none";
    if (ms_ - stopped_ms_ < kUnlockAfterMs) return "Cannot unlock protective stop until 5s after occurrence";
    safety_mode_ = kNormal;
    fault_.clear();
    return "Protective stop releasing";
  }
  return "could not understand: '" + line + "'";
}

void UrEmulator::start_program() {
  const std::string text = std::exchange(script_, {});
  const auto id = number_in(text, R"(write_output_integer_register\(24, ([0-9]+)\))");
  const auto silent = number_in(text, R"(while silent < ([0-9]+):)");
  const auto step = number_in(text, R"(servoj\(q, 0, 0, ([0-9.]+), )");
  const auto lookahead = number_in(text, R"(servoj\(q, 0, 0, [0-9.]+, ([0-9.]+), )");
  const auto gain = number_in(text, R"(servoj\(q, 0, 0, [0-9.]+, [0-9.]+, ([0-9.]+)\))");
  const bool valid = id && silent && step && lookahead && gain && std::abs(*step - step_s()) < 1e-9 &&
                     *lookahead >= 0.03 && *lookahead <= 0.2 && *gain >= 100 && *gain <= 2000;
  if (!valid || robot_mode_ != kRunningMode || safety_mode_ != kNormal) return;
  program_ = text;
  running_ =
      Program{.id = static_cast<int>(*id), .silent_steps = static_cast<int>(*silent), .last_count = integers_[0]};
  output_register_ = running_->id;
  target_ = joints_.position;
}

/// One cycle of the program's loop.
void UrEmulator::step_program() {
  Program& program = *running_;
  program.silent = integers_[0] == program.last_count ? program.silent + 1 : 0;
  program.last_count = integers_[0];
  if (integers_[1] == 1) {
    const JointVector wanted = Eigen::Map<const Eigen::Matrix<double, 6, 1>>(doubles_.data());
    if (!wanted.allFinite()) return protective_stop("servoj: a position that is not finite");
    const JointVector largest = kStepMargin * step_s() * chain_.velocity();
    if (((wanted - target_).cwiseAbs() - largest).maxCoeff() > 0) return protective_stop("servoj: a step too far");
    target_ = wanted;
    program.moving = servo_ = true;
    stopping_ = false;
  } else if (program.moving) {
    program.moving = servo_ = false;
    stopping_ = true;
  } else if (!stopping_) {
    target_ = joints_.position;
  }
  if (program.silent < program.silent_steps) return;
  running_.reset();
  program_.clear();
  output_register_ = 0;
  servo_ = false;
  stopping_ = true;
}

void UrEmulator::protective_stop(const std::string& why) {
  if (safety_mode_ == kProtectiveStop || robot_mode_ != kRunningMode) return;
  fault_ = "protective stop: " + why;
  safety_mode_ = kProtectiveStop;
  stopped_ms_ = ms_;
  running_.reset();
  program_.clear();
  output_register_ = 0;
  servo_ = false;
  stopping_ = true;
}

void UrEmulator::decelerate() {
  const double change = (safety_mode_ == kProtectiveStop ? kProtectiveRate : kStopRate) * 1e-3;
  for (double& velocity : joints_.velocity) velocity -= std::clamp(velocity, -change, change);
  joints_.position += 1e-3 * joints_.velocity;
  if (!joints_.velocity.isZero(0)) return;
  stopping_ = false;
  target_ = joints_.position;
}

void UrEmulator::send_data(WireOutbox& out) {
  rtde::Writer data;
  data.u8(1);
  for (const std::string& name : outputs_) {
    if (name == "actual_q") {
      for (const double value : joints_.position) data.real(value);
    } else if (name == "actual_qd") {
      for (const double value : joints_.velocity) data.real(value);
    } else if (name == "timestamp") {
      data.real(static_cast<double>(ms_) * 1e-3);
    } else {
      data.i32(name == "robot_mode" ? robot_mode_ : name == "safety_mode" ? safety_mode_ : output_register_);
    }
  }
  out.push_back({kRtde, rtde::encode(rtde::Type::kData, data.bytes())});
}

void UrEmulator::tick(const Time&, WireOutbox& out) {
  ++ms_;
  if (std::exchange(reboots_, false)) {
    for (const size_t link : {kRtde, kDashboard, kScript}) out.push_back({link, {}, true});
    running_.reset();
    program_.clear();
    fault_.clear();
    joints_.stop();
    target_ = joints_.position;
    servo_ = stopping_ = false;
    robot_mode_ = kPowerOff;
    safety_mode_ = kNormal;
    mode_change_ms_ = -1;
    output_register_ = 0;
  }
  if (mode_change_ms_ >= 0 && ms_ >= mode_change_ms_) {
    robot_mode_ = next_mode_;
    mode_change_ms_ = -1;
  }
  const auto cycle = static_cast<int64_t>(std::lround(step_s() * 1e3));
  if (running_ && ms_ % cycle == 0) step_program();
  if (stopping_) {
    decelerate();
  } else if (servo_) {
    joints_.follow(target_, kServo, 1e-3);
  }
  if (sends_ && ms_ % cycle == 0) send_data(out);
}

}  // namespace multireach::drivers
