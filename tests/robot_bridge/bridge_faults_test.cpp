// Seeded schedules of faults against the bridge, in virtual time: lost, repeated, reordered, late and corrupt
// set-points and measurements, foreign senders, gaps in the ticks, controllers that are restarted or whose clock steps,
// stalls of all processes, robots that are blocked, displaced, silent or restarted, and requests of a user. When the
// faults end, the bridge must follow the controller again, if need be after the documented requests.
// MULTIREACH_FAULT_SCHEDULES sets their number, MULTIREACH_FAULT_FIRST the first of them.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <deque>
#include <functional>
#include <iostream>

#include "numeric/random.hpp"
#include "robot_bridge/bridge.hpp"
#include "robot_bridge/stream_check.hpp"
#include "tests/test_arms.hpp"

namespace multireach::robot_bridge {
namespace {

constexpr int64_t kTicks = 2000, kQuiet = 3000, kRobot = 21, kController = 22;

/// What else a schedule is about.
struct Setting {
  Chain chain = testing::hoap2();
  BridgeOptions options{};
  bool real = false;    ///< the robot: it must be enabled, and again after each of its restarts
  bool pauses = false;  ///< the user pauses and resumes
  bool lags = false;    ///< the robot tells with which velocity it moves
  bool is_linear() const { return options.shape == BridgeOptions::Shape::kLinear; }
};

/// One schedule: which faults it has, and how often.
class Schedule {
 public:
  Schedule(const CounterRandom& random, uint64_t number) : random_(random), number_(number) {
    for (uint64_t kind = 0; kind < rates_.size(); ++kind)
      rates_[kind] = draw(kind) < 0.3 ? std::pow(10.0, -2 * draw(100 + kind)) : 0;
  }
  /// A number from 0 to 1, the next of this schedule.
  double draw(uint64_t what) const { return random_.uniform((number_ << 32) + what); }
  double next() { return draw(1000 + drawn_++); }
  /// Whether the fault of this kind happens now, at `share` of its rate.
  bool happens(size_t kind, double share = 1) { return rates_[kind] > 0 && next() < share * rates_[kind]; }
  void end() { rates_.fill(0); }

 private:
  const CounterRandom& random_;
  uint64_t number_, drawn_ = 0;
  std::array<double, 15> rates_{};
};
enum Fault : size_t {
  kLost,
  kRepeated,
  kReordered,
  kLate,
  kCorrupt,
  kForeign,
  kGap,
  kBlocked,
  kDisplaced,
  kSilent,
  kRestarted,
  kAsked,
  kControllerRestarted,
  kClockStep,
  kAllStalled
};

class FaultRun {
 public:
  FaultRun(const Setting& setting, Schedule schedule)
      : schedule_(schedule), setting_(setting), bridge_(setting.chain, setting.options), check_(bridge_.limits()) {
    const int n = setting.chain.size();
    centre_ = amplitude_ = JointVector(n);
    for (int i = 0; i < n; ++i) {
      const double lower = setting.chain.sample_lower(i), upper = setting.chain.sample_upper(i);
      centre_[i] = (lower + upper) / 2;
      amplitude_[i] = 0.45 * schedule_.next() * (upper - lower);
    }
    frequency_ = 0.2 + 2 * schedule_.next();
    measured_ = wanted(0).theta;
    told_ = measured_;
  }

  /// Returns what went wrong; "" for nothing.
  std::string run() {
    for (int64_t ms = 0; ms < kTicks; ++ms) {
      step(ms);
      if (!within_limits()) return beyond(ms);
      if (bridge_.state() == BridgeState::kFault && !*bridge_.cause()) return "a fault without a cause";
    }
    return recovers() ? ""
           : !within_limits()
               ? beyond(kTicks + kQuiet)
               : "does not run again after the faults: state " + std::to_string(static_cast<int>(bridge_.state())) +
                     ", " + bridge_.cause() + "; the last set-point: " + std::to_string(static_cast<int>(verdict_));
  }
  int64_t faults() const { return faults_; }
  int64_t running() const { return running_; }

 private:
  bool within_limits() const {
    if (setting_.is_linear()) return check_.velocity() <= 1 + 1e-9 && check_.excess() <= 1e-9 && !jumped_;
    return check_.keeps() && !jumped_;
  }
  std::string beyond(int64_t ms) const {
    if (jumped_) return "tick " + std::to_string(ms) + ": a jump across a gap";
    return "tick " + std::to_string(ms) + ": speed " + std::to_string(check_.velocity()) + ", acceleration " +
           std::to_string(check_.acceleration()) + ", jerk " + std::to_string(check_.jerk()) +
           " of the limits, position " + std::to_string(check_.excess()) + " beyond";
  }
  Setpoint wanted(int64_t k) const {
    const double t = 0.05 * static_cast<double>(k), ramp = std::min(t, 1.0), w = 6.28 * frequency_;
    const double phase = ramp < 1 ? w * t * t / 2 : w * (t - 0.5), speed = ramp < 1 ? w * t : w;
    if (hold_.size() > 0) {
      return {.run = controller_run_,
              .utime = k * 50000 + clock_step_,
              .sequence = k - first_,
              .theta = hold_,
              .velocity = JointVector::Zero(hold_.size())};
    }
    return {.run = controller_run_,
            .utime = k * 50000 + clock_step_,
            .sequence = k - first_,
            .theta = centre_ + amplitude_ * (1 - std::cos(phase)) / 2,
            .velocity = amplitude_ * std::sin(phase) * speed / 2};
  }

  /// Whether the bridge follows a controller that holds the robot's position, once all faults are over.
  bool recovers() {
    schedule_.end();
    queue_.clear();
    bridge_.set_speed(1);
    bridge_.pause(false);
    for (int64_t ms = kTicks; ms < kTicks + kQuiet; ++ms) {
      // A robot that was pushed far beyond a limit is not commanded: the user brings it back.
      const bool beyond = setting_.chain.limit_excess(measured_) > setting_.options.max_start_distance;
      if (beyond) measured_ = measured_.cwiseMax(bridge_.limits().lower).cwiseMin(bridge_.limits().upper);
      // BRIDGE_STATE.far_run asks the controller to start again from where the robot is.
      if (ms == kTicks || verdict_ == SetpointVerdict::kFarFromRobot) hold_ = measured_;
      if (ms % 100 == 0 && bridge_.state() == BridgeState::kFault) (void)bridge_.reset();
      if (ms % 100 == 0 && bridge_.state() == BridgeState::kIdle) bridge_.enable();
      step(ms);
      if (!within_limits()) {
        std::cout << "beyond a limit " << ms - kTicks << " ms after the last fault\n";
        return false;
      }
    }
    return bridge_.state() == BridgeState::kRunning;
  }

  void send(Setpoint setpoint) {
    const auto corrupt = static_cast<int>(schedule_.next() * static_cast<double>(setpoint.theta.size()));
    if (schedule_.happens(kCorrupt)) {
      switch (static_cast<int>(schedule_.next() * 6)) {
        case 0:
          setpoint.theta[corrupt] = NAN;
          break;
        case 1:
          setpoint.theta[corrupt] += 20 * (schedule_.next() - 0.5);
          break;
        case 2:
          setpoint.velocity[corrupt] += 200 * (schedule_.next() - 0.5);
          break;
        case 3:
          setpoint.utime += static_cast<int64_t>(4e6 * (schedule_.next() - 0.5));
          break;
        case 4:
          setpoint.theta = JointVector::Zero(3);
          break;
        default:
          setpoint.sequence += static_cast<int64_t>(200 * (schedule_.next() - 0.5));
      }
    }
    if (schedule_.happens(kForeign)) {
      setpoint.run = 99;
      setpoint.theta = centre_ + amplitude_ * (schedule_.next() - 0.5);
    }
    bool restarted = false;
    const auto before = bridge_.next_tick();
    verdict_ = bridge_.setpoint(setpoint, restarted);
    const bool accepted = verdict_ == SetpointVerdict::kAccepted;
    if (accepted && restarted && !before) {  // a new stream, from where the robot is
      check_.begin_at(told_);
      new_stream_ = true;
    }
  }

  void step(int64_t ms) {
    if (schedule_.happens(kAllStalled, 0.002)) {
      stalled_until_ = ms + static_cast<int64_t>(1500 * schedule_.next());
      if (bridge_.next_tick()) {
        bridge_.skip(stalled_until_ - ms);
        after_gap(stalled_until_ - ms);
      }
    }
    if (ms < stalled_until_) return;
    if (schedule_.happens(kControllerRestarted, 0.003)) {
      ++controller_run_;
      first_ = ms / 50;
    }
    if (schedule_.happens(kClockStep, 0.003)) clock_step_ += static_cast<int64_t>(4e6 * (schedule_.next() - 0.5));
    if (ms % 50 == 0 && !schedule_.happens(kLost)) {
      int64_t delay = static_cast<int64_t>(5 * schedule_.next());
      if (schedule_.happens(kLate)) delay += static_cast<int64_t>(200 * schedule_.next());
      queue_.push_back({ms + delay, wanted(ms / 50)});
      if (schedule_.happens(kRepeated)) queue_.push_back(queue_.back());
      if (schedule_.happens(kReordered) && queue_.size() > 1) std::swap(queue_.front(), queue_.back());
    }
    for (size_t k = 0; k < queue_.size();) {
      if (queue_[k].first > ms) {
        ++k;
        continue;
      }
      send(queue_[k].second);
      queue_.erase(queue_.begin() + static_cast<std::ptrdiff_t>(k));
    }
    move_robot(ms);
    if (schedule_.happens(kAsked, 0.02)) ask();
    if (bridge_.next_tick() && schedule_.happens(kGap, 0.05)) {
      const auto gap = static_cast<int64_t>(std::pow(10.0, 3 * schedule_.next()));
      bridge_.skip(gap);
      after_gap(gap);
    }
    if (bridge_.next_tick()) {
      const Command command = bridge_.tick();
      check_.add(command.theta, gap_ <= Bridge::kBridgedGap && !new_stream_ ? gap_ + 1 : 1);
      if (gap_ > 0 && !new_stream_) {
        // Across a gap: bridged at most at the speed limit, or the position of the last command, from rest.
        const double periods = gap_ <= Bridge::kBridgedGap ? static_cast<double>(gap_ + 1) : 1;
        const JointVector furthest = (1 + 1e-4) * 1e-3 * periods * bridge_.limits().velocity;
        jumped_ |= ((command.theta - commanded_).cwiseAbs() - furthest).maxCoeff() > 0;
      }
      commanded_ = command.theta;
      gap_ = 0;
      new_stream_ = false;
    } else {
      check_.begin();
      gap_ = 0;
    }
    running_ += ms < kTicks && bridge_.state() == BridgeState::kRunning;
    if (bridge_.state() == BridgeState::kFault) {
      faults_ += ms < kTicks;
      if (schedule_.next() < 0.01) (void)bridge_.reset();
    }
  }

  /// A short gap is bridged: the derivatives are compared across it. After a longer one the robot rests at the last
  /// command.
  void after_gap(int64_t periods) {
    gap_ += periods;
    if (gap_ > Bridge::kBridgedGap && bridge_.next_tick() && commanded_.size() > 0 && !new_stream_)
      check_.begin_at_rest(commanded_);
  }

  void ask() {
    const double what = schedule_.next();
    if (what < 0.3) bridge_.disable();
    if (what > 0.2 && what < 0.6) bridge_.enable();
    if (what >= 0.6) bridge_.set_speed(what > 0.9 ? 1 : schedule_.next());
    if (setting_.pauses) bridge_.pause(schedule_.next() < 0.5);
  }

  void move_robot(int64_t ms) {
    measured_before_ = measured_;
    if (setting_.real && !bridge_.enabled() && schedule_.next() < 0.01) bridge_.enable();
    if (schedule_.happens(kBlocked, 0.01)) blocked_until_ = ms + static_cast<int64_t>(500 * schedule_.next());
    if (schedule_.happens(kSilent, 0.01)) silent_until_ = ms + static_cast<int64_t>(1500 * schedule_.next());
    if (schedule_.happens(kRestarted, 0.002)) ++robot_run_;
    if (schedule_.happens(kDisplaced, 0.005)) measured_[0] += 0.5 * (schedule_.next() - 0.5);
    if (commanded_.size() > 0 && ms > blocked_until_) measured_ += 0.1 * (commanded_ - measured_);
    const JointVector velocity =
        setting_.lags ? ((measured_ - measured_before_) / 1e-3).eval() : JointVector::Zero(measured_.size()).eval();
    if (ms % 5 == 0 && ms > silent_until_) {
      if (bridge_.measured(
              {.run = robot_run_, .utime = ms * 1000, .theta = measured_, .velocity = velocity, .real = setting_.real}))
        told_ = measured_;
    }
  }

  Schedule schedule_;
  Setting setting_;
  Bridge bridge_;
  StreamCheck check_;
  JointVector centre_, amplitude_, measured_, measured_before_, commanded_;
  JointVector told_;  // what the bridge heard of the robot last
  double frequency_ = 1;
  std::deque<std::pair<int64_t, Setpoint>> queue_;
  JointVector hold_;  // once the faults are over: the position that the controller holds
  int64_t controller_run_ = kController, first_ = 0, clock_step_ = 0;
  int64_t blocked_until_ = -1, silent_until_ = -1, stalled_until_ = -1, robot_run_ = kRobot;
  int64_t faults_ = 0, running_ = 0, gap_ = 0;
  bool jumped_ = false, new_stream_ = true;
  SetpointVerdict verdict_ = SetpointVerdict::kAccepted;
};

/// Runs the schedules of these numbers, and as many more as the environment says.
void run_all(uint64_t seed, std::vector<uint64_t> numbers, uint64_t otherwise,
             const std::function<Setting(const Schedule&)>& setting_of) {
  const char* wanted = std::getenv("MULTIREACH_FAULT_SCHEDULES");
  const char* begin = std::getenv("MULTIREACH_FAULT_FIRST");
  const uint64_t schedules = wanted ? std::strtoull(wanted, nullptr, 10) : otherwise;
  const uint64_t first = begin ? std::strtoull(begin, nullptr, 10) : 0;
  std::cout << "seed " << seed << ", " << schedules << " schedules of " << kTicks << " ms from " << first << "\n";
  const CounterRandom random(seed);
  int64_t running = 0, faults = 0;
  for (uint64_t k = first; k < first + schedules; ++k) numbers.push_back(k);
  for (const uint64_t k : numbers) {
    const Schedule schedule(random, k);
    FaultRun run(setting_of(schedule), schedule);
    const std::string wrong = run.run();
    ASSERT_EQ(wrong, "") << "schedule " << k;
    running += run.running();
    faults += run.faults();
  }
  const double ticks = static_cast<double>(schedules) * kTicks;
  std::cout << "running " << 100 * static_cast<double>(running) / ticks << " %, in a fault "
            << 100 * static_cast<double>(faults) / ticks << " % of the time\n";
  EXPECT_GT(running, 0.2 * ticks) << "the schedules test a bridge that runs";
  EXPECT_GT(faults, 0);
}

TEST(BridgeFaults, EveryScheduleKeepsAllLimits) {
  const std::vector<uint64_t> found{128719,   // found once: a robot that was pushed beyond a limit
                                    979011,   // a motion that began with a late set-point: most of the others were
                                              // refused,
                                    427020};  // or only some
  const Setting setting;
  run_all(2211, found, 1000, [&setting](const Schedule&) { return setting; });
}

TEST(BridgeFaults, EveryScheduleKeepsAllLimitsOfOtherArmsRealRobotsAndOtherOptions) {
  std::vector<Chain> arms{testing::hoap2(), testing::seven_joint_arm().chain, testing::six_joint_arm().chain};
  for (int joints = 1; joints <= 8; ++joints) arms.push_back(testing::odd_arm(joints, 3));
  const std::vector<uint64_t> found{1022,    // found once: a robot that was pushed far beyond a limit
                                    90588};  // a stop that passed a limit by 0.07 mrad
  run_all(2511, found, 1000, [&arms](const Schedule& schedule) {
    const auto draw = [&schedule](uint64_t what) { return schedule.draw(500 + what); };
    Setting setting{.chain = arms[static_cast<size_t>(draw(0) * static_cast<double>(arms.size()))]};
    setting.real = draw(1) < 0.5;
    setting.pauses = draw(2) < 0.3;
    setting.lags = draw(3) < 0.5;
    BridgeOptions& options = setting.options;
    if (!setting.real && draw(4) < 0.2) options.shape = BridgeOptions::Shape::kLinear;
    if (draw(5) < 0.5) {
      const MotionLimits usual = motion_limits(setting.chain, options.speed_where_unlimited, {}, {});
      options.acceleration = std::pow(10.0, draw(6) - 0.5) * usual.acceleration;
      options.jerk = std::pow(10.0, draw(7) - 0.5) * usual.jerk;
    }
    if (draw(8) < 0.3) options.delay_us = static_cast<int64_t>(50000 * draw(9));
    if (draw(10) < 0.3) options.robot_timeout_us = static_cast<int64_t>(std::pow(10.0, 3.5 + 2 * draw(11)));
    return setting;
  });
}

}  // namespace
}  // namespace multireach::robot_bridge
