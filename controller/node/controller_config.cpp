#include "controller/node/controller_config.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "controller/law/attractor_gains.hpp"
#include "controller/task/joint_weights.hpp"
#include "controller/tracking_defaults.hpp"
#include "runtime/config_keys.hpp"
#include "runtime/joint_fields.hpp"

namespace multireach {
namespace {

enum class Law { kGuarded, kPaper };
enum class Motion { kReach, kTrack, kIntercept };

/// What the section `controller` says.
struct ControllerKeys {
  const Chain* chain = nullptr;
  Law law = Law::kGuarded;
  Motion motion = Motion::kReach;
  std::optional<double> gamma{}, alpha{}, beta{}, natural_frequency{}, damping_ratio{};
  std::optional<int64_t> prediction_us{};
  std::optional<controller::TickTimes> ticks{};
  controller::ReachOptions options{};
  controller::GuardedParameters guarded{};
  controller::FreeFallFilter::Options flight{};
  std::optional<std::string> target_name{};
};

// One of the two keys must be given: the orientation or direction in W, or in the target's own frame.
void read_frame(const Config& config, ControllerKeys& keys, const std::string& in_world, const std::string& in_target) {
  if (config.has(in_world) == config.has(in_target))
    config.fail(config.has(in_world) ? in_target : in_world, "one of " + in_world + " and " + in_target);
  keys.options.orientation_frame =
      config.has(in_target) ? controller::OrientationFrame::kTarget : controller::OrientationFrame::kWorld;
}

/// A vector of `size` numbers, scaled to unit length.
Eigen::VectorXd unit_vector_from(const Config& config, const std::string& key, int size) {
  const std::vector<double> values = config.numbers(key, size);
  const Eigen::VectorXd vector = Eigen::Map<const Eigen::VectorXd>(values.data(), size);
  if (!(vector.norm() > 1e-3 && vector.norm() < 1e3)) config.fail(key, "a vector that is not zero");
  return vector.normalized();
}

void read_orientation(const Config& config, ControllerKeys& keys) {
  read_frame(config, keys, "orientation_wxyz", "orientation_in_target_wxyz");
  const bool in_target = config.has("orientation_in_target_wxyz");
  const Eigen::VectorXd wxyz =
      unit_vector_from(config, in_target ? "orientation_in_target_wxyz" : "orientation_wxyz", 4);
  keys.options.orientation = Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]).toRotationMatrix();
}

void read_direction(const Config& config, ControllerKeys& keys) {
  read_frame(config, keys, "pointing_direction", "pointing_direction_in_target");
  const bool in_target = config.has("pointing_direction_in_target");
  keys.options.direction =
      unit_vector_from(config, in_target ? "pointing_direction_in_target" : "pointing_direction", 3);
}

/// The index of a joint of the chain; an error that names the joints when there is none.
int joint_index(const Config& config, const Chain& chain, const std::string& key, const std::string& name) {
  const int index = chain.index_of(name);
  if (index >= 0) return index;
  std::string names;
  for (const Joint& joint : chain.joints()) names += (names.empty() ? "" : ", ") + joint.name;
  config.fail(key, "joints of the chain; it has " + names + ", and no '" + name + "'");
}

JointVector& joint_weights_to_set(ControllerKeys& keys) {
  JointVector& weights = keys.guarded.joint_weights;
  if (weights.size() == 0) weights = controller::default_joint_weights(*keys.chain);
  return weights;
}

void read_joint_weights(const Config& config, ControllerKeys& keys) {
  if (!config.has("joint_weights")) return;
  for (const auto& [name, weight] : config.named_numbers("joint_weights")) {
    const int joint = joint_index(config, *keys.chain, "joint_weights", name);
    if (!(weight >= 1e-3 && weight <= 1e3)) config.fail("joint_weights", "weights from 0.001 to 1000");
    joint_weights_to_set(keys)[joint] = weight;
  }
}

void read_locked_joints(const Config& config, ControllerKeys& keys) {
  if (!config.has("locked_joints")) return;
  for (const std::string& name : config.texts("locked_joints")) {
    const int joint = joint_index(config, *keys.chain, "locked_joints", name);
    joint_weights_to_set(keys)[joint] = std::numeric_limits<double>::infinity();
  }
  if (!(keys.guarded.joint_weights.size() > 0 && keys.guarded.joint_weights.minCoeff() < 1e9))
    config.fail("locked_joints", "at least one joint, and one that may move");
}

/// The motion that gains per step of 1/140 s give.
controller::AttractorMotion motion_of(const controller::ViteGains& gains) {
  return controller::attractor_motion(gains, controller::kReferenceRate);
}

ConfigKeys<ControllerKeys> controller_keys() {
  using controller::Feedback;
  using controller::OnTargetLost;
  using controller::TaskKind;
  using controller::TickTimes;
  using Keys = ControllerKeys;
  const controller::ViteGains guarded = controller::GuardedParameters{}.gains,
                              paper = controller::PaperParameters{}.gains;
  const auto either = [](double reach, double track, double printed) {
    return fmt::format("{:g}; other motions: {:g}; law `paper`: {:g}", reach, track, printed);
  };
  const controller::AttractorMotion reach = motion_of(guarded), track = motion_of(controller::kTrackGains);
  const auto in_time = [](double reaching, double tracking) {
    return fmt::format("{:.3g}; other motions: {:.3g}", reaching, tracking);
  };
  const auto is_guarded = [](const Keys& k) { return k.law == Law::kGuarded; };
  ConfigKeys<Keys> keys("robot.yaml, section controller", "The reaching controller.");
  keys.choice<Law>(
          "law", {{"guarded", Law::kGuarded}, {"paper", Law::kPaper}}, [](auto& k) -> auto& { return k.law; },
          "`guarded` keeps all limits (docs/guarantees.md); `paper` computes the equations as printed.")
      .choice<Motion>(
          "motion", {{"reach", Motion::kReach}, {"track", Motion::kTrack}, {"intercept", Motion::kIntercept}},
          [](auto& k) -> auto& { return k.motion; },
          "`reach`: smooth reaches, as in the paper; `track`: stiffer attractors and a prediction that also knows the "
          "target's acceleration, and estimates its velocity where none is sent, for targets that keep moving; "
          "`intercept`: for a thrown ball, with the gains of "
          "`track`: the hand waits in the rest configuration until the target falls freely, then goes where it will "
          "be; a ball that a hand swings may look like one that falls (docs/safety.md). It sets the defaults of the "
          "gains and of `prediction_s`.")
      .number(
          "gamma_rad2_m2", "rad²/m²", 0, 1e12, [](auto& k) -> auto& { return k.gamma; },
          "Weight of the hand's attractor, Eq. (28).")
      .otherwise(fmt::format("8.5 / reach²; law `paper`: {:g}", controller::PaperParameters{}.gamma))
      .number(
          "alpha_per_step", "", 1e-6, 1, [](auto& k) -> auto& { return k.alpha; },
          "Attractor gain per step of 1/140 s, Eq. (3); law `paper`: per integration step.")
      .otherwise(either(guarded.alpha, controller::kTrackGains.alpha, paper.alpha))
      .number(
          "beta_per_step", "", 1e-6, 1, [](auto& k) -> auto& { return k.beta; },
          "Attractor gain per step of 1/140 s, Eq. (3); law `paper`: per integration step.")
      .otherwise(either(guarded.beta, controller::kTrackGains.beta, paper.beta))
      .number(
          "prediction_s", "s", 0, 10, [](auto& k) -> auto& { return k.prediction_us; },
          "The hand aims at where the target will be this much later, by its velocity; with `motion: intercept`, by "
          "its free "
          "fall.",
          1e6)
      .otherwise(fmt::format("0; other motions: {:g}", 1e-6 * controller::kTrackPrediction))
      .integer(
          "steps_per_tick", "", 1, 1000, [](auto& k) -> auto& { return k.options.steps_per_tick; },
          "Integration steps in each `tick_ms`. The law `guarded` moves alike with any number.")
      .choice<std::optional<TickTimes>>(
          "ticks", {{"on_targets", TickTimes::kOnTargets}, {"periodic", TickTimes::kPeriodic}},
          [](auto& k) -> auto& { return k.ticks; },
          "`on_targets`: a set-point as soon as a target is seen, if the last is a quarter of `tick_ms` old, and "
          "`tick_ms` after the last one without; `periodic`: one every `tick_ms`.")
      .otherwise("`on_targets`; law `paper`: `periodic`")
      .number(
          "jump_m", "m", 1e-6, 1e3, [](auto& k) -> auto& { return k.options.target.jump_m; },
          "A target that is further than this from where it is expected, and beyond what noise explains, has jumped, "
          "and is not filtered.")
      .number(
          "wander_m_per_root_s", "m/√s", 0, 1e3, [](auto& k) -> auto& { return k.options.target.wander_m_per_root_s; },
          "How fast a target at rest may drift, for the filter of its position.")
      .number(
          "lost_after_s", "s", 0, 1e6, [](auto& k) -> auto& { return k.options.lost_after_us; },
          "A target that was not seen for longer than this is lost.", 1e6)
      .choice<OnTargetLost>(
          "on_target_lost",
          {{"keep_target", OnTargetLost::kHoldLastTarget},
           {"go_to_rest", OnTargetLost::kGoToRest},
           {"stop", OnTargetLost::kStop}},
          [](auto& k) -> auto& { return k.options.on_target_lost; },
          "Continue to the last target, go to the rest configuration, or stop where the arm is. Not used with "
          "`motion: intercept`.")
      .other("rest_joint_position", "list, one number for each joint", "rad or m", "where the arm started",
             "The rest configuration.",
             [](const Config& config, Keys& k) {
               if (config.has("rest_joint_position"))
                 k.options.rest = joint_configuration_from(config, "rest_joint_position", *k.chain);
             })
      .choice<Feedback>(
          "feedback", {{"open", Feedback::kOpen}, {"measured", Feedback::kMeasured}},
          [](auto& k) -> auto& { return k.options.feedback; },
          "`open`: the controller integrates its own joint positions, as in the paper; `measured`: they follow the arm "
          "when something pushes it.")
      .number(
          "disturbance_threshold", "rad or m", 0, 10, [](auto& k) -> auto& { return k.options.disturbance_threshold; },
          "With `feedback: measured`: a joint within this of the commands of the last 0.3 s counts as undisturbed.")
      .text(
          "target_name", [](auto& k) -> auto& { return k.target_name; }, "Which of vision's targets to reach for.")
      .otherwise("the first that is seen")
      .integer(
          "seed", "", 0, INT64_MAX, [](auto& k) -> auto& { return k.options.ik.seed; },
          "Random seed of the IK search, for arms without a closed form.")
      .only("with law: paper", [](const Keys& k) { return k.law == Law::kPaper; })
      .number(
          "drift_m", "m", 1e-6, 1e3, [](auto& k) -> auto& { return k.options.drift_m; },
          "Search θ_T again when K(θ_T) is further than this from the target.")
      .only("with law: guarded", is_guarded)
      .number(
          "natural_frequency_rad_s", "rad/s", 1e-3, controller::GuardedParameters::kMaxNaturalFrequency,
          [](auto& k) -> auto& { return k.natural_frequency; },
          "Instead of `alpha_per_step` and `beta_per_step`: natural frequency of both attractors. A reach takes about "
          "7 "
          "divided by it, or longer where limits demand it.")
      .otherwise(in_time(reach.natural_frequency, track.natural_frequency))
      .number(
          "damping_ratio", "", 1, controller::GuardedParameters::kMaxDampingRatio,
          [](auto& k) -> auto& { return k.damping_ratio; },
          "Instead of `alpha_per_step` and `beta_per_step`: damping ratio of both attractors. Below 1 they would "
          "overshoot.")
      .otherwise(in_time(reach.damping_ratio, track.damping_ratio))
      .number(
          "link_radius_m", "m", 0, 0.5, [](auto& k) -> auto& { return k.guarded.body.link_radius_m; },
          "The links are capsules of this radius, which avoid obstacles; 0: obstacles are ignored.")
      .number(
          "margin_m", "m", 0, 1, [](auto& k) -> auto& { return k.guarded.body.margin_m; },
          "Distance that the links keep from obstacles and from each other.")
      .integer(
          "path_work", "", 0, 1000000, [](auto& k) -> auto& { return k.guarded.path_work; },
          "Work on the plan of a short hand path at each new position target, in optimisation steps (5 to 11 µs each); "
          "70 is usual, 0: no plan.")
      .flag(
          "self_collision", [](auto& k) -> auto& { return k.guarded.body.self_collision; },
          "Whether the links avoid each other.")
      .other("joint_weights", "map from joint names to numbers", "",
             "1; for joints slower than an eighth of the median speed: median / speed, at most 30",
             "Where several motions serve the hand, a joint moves 1 / weight² times as much as one of weight 1.",
             read_joint_weights)
      .other("locked_joints", "list of joint names", "", "none", "Joints that never move.", read_locked_joints)
      .choice<TaskKind>(
          "task", {{"position", TaskKind::kPosition}, {"pointing", TaskKind::kPointing}, {"pose", TaskKind::kPose}},
          [](auto& k) -> auto& { return k.options.task; },
          "What the hand reaches: the target's position; also a direction; also an orientation.")
      .only("with motion: intercept", [](const Keys& k) { return k.motion == Motion::kIntercept; })
      .other("gravity_m_s2", "list of 3 numbers", "m/s²", "0, 0, -9.81", "Acceleration of a falling body, in W.",
             [](const Config& config, Keys& k) {
               if (!config.has("gravity_m_s2")) return;
               const std::vector<double> values = config.numbers("gravity_m_s2", 3);
               k.flight.gravity = Eigen::Map<const Eigen::Vector3d>(values.data());
               if (!(k.flight.gravity.norm() >= 0.1 && k.flight.gravity.norm() <= 100))
                 config.fail("gravity_m_s2", "a vector of 0.1 to 100 m/s²");
             })
      .only("with task: pointing or pose",
            [=](const Keys& k) { return is_guarded(k) && k.options.task != TaskKind::kPosition; })
      .number(
          "orientation_length_m", "m", 1e-6, 1e3, [](auto& k) -> auto& { return k.guarded.tool.orientation_length_m; },
          "Length that weighs an error of orientation (rad) against one of position (m).")
      .only("with task: pointing",
            [=](const Keys& k) { return is_guarded(k) && k.options.task == TaskKind::kPointing; })
      .other("pointing_direction", "list of 3 numbers", "", "required without pointing_direction_in_target",
             "Direction, in W, of the tool's axis.", read_direction)
      .other("pointing_direction_in_target", "list of 3 numbers", "", "",
             "Direction of the tool's axis in the frame of the target, whose TARGET has an orientation.",
             [](const Config&, Keys&) {})
      .other("tool_axis", "list of 3 numbers", "", "0, 0, 1", "The tool's axis in the hand's frame.",
             [](const Config& config, Keys& k) {
               if (config.has("tool_axis")) k.guarded.tool.axis = unit_vector_from(config, "tool_axis", 3);
             })
      .only("with task: pose", [=](const Keys& k) { return is_guarded(k) && k.options.task == TaskKind::kPose; })
      .other("orientation_wxyz", "list of 4 numbers", "", "required without orientation_in_target_wxyz",
             "Orientation of the hand's frame in W, a quaternion.", read_orientation)
      .other("orientation_in_target_wxyz", "list of 4 numbers", "", "",
             "Orientation of the hand's frame in the frame of the target, whose TARGET has an orientation.",
             [](const Config&, Keys&) {});
  return keys;
}

controller::ReachOptions reach_options_of(const ControllerKeys& keys) {
  controller::ReachOptions options = keys.options;
  const bool tracks = keys.motion != Motion::kReach;
  options.prediction_us = keys.prediction_us.value_or(tracks ? controller::kTrackPrediction : 0);
  const auto put_gains = [&keys](controller::ViteGains& gains) {
    gains.alpha = keys.alpha.value_or(gains.alpha);
    gains.beta = keys.beta.value_or(gains.beta);
  };
  options.ticks = keys.ticks.value_or(keys.law == Law::kPaper ? controller::TickTimes::kPeriodic : options.ticks);
  if (keys.law == Law::kPaper) {
    controller::PaperParameters law;
    law.gamma = keys.gamma.value_or(law.gamma);
    put_gains(law.gains);
    options.law = law;
  } else {
    controller::GuardedParameters law = keys.guarded;
    law.gamma = keys.gamma;
    if (tracks) {
      law.gains = controller::kTrackGains;
      options.target.acceleration_s = controller::kTrackAccelerationTime;
      options.target.jerk_noise_m2_s5 = controller::kTrackJerkNoise;
    }
    if (keys.motion == Motion::kIntercept) options.intercept = keys.flight;
    put_gains(law.gains);
    if (keys.natural_frequency || keys.damping_ratio) {
      const controller::AttractorMotion usual = motion_of(law.gains);
      law.attractor = {keys.natural_frequency.value_or(usual.natural_frequency),
                       keys.damping_ratio.value_or(usual.damping_ratio)};
    }
    options.law = law;
  }
  return options;
}

void refuse_two_kinds_of_gains(const Config& section) {
  for (const char* per_step : {"alpha_per_step", "beta_per_step"}) {
    for (const char* in_time : {"natural_frequency_rad_s", "damping_ratio"}) {
      if (section.has(per_step) && section.has(in_time))
        section.fail(in_time, fmt::format("{} without {}, or {} alone", in_time, per_step, per_step));
    }
  }
}

ControllerKeys read_controller_section(const RobotConfig& robot) {
  ControllerKeys keys;
  keys.chain = &robot.chain;
  keys.options.tick_us = robot.tick_us;
  keys.guarded.acceleration = robot.joint_acceleration_limits;
  if (const auto section = robot.section("controller")) {
    controller_keys().read(*section, keys);
    refuse_two_kinds_of_gains(*section);
    if (keys.motion == Motion::kIntercept && keys.law == Law::kPaper)
      section->fail("motion", "reach or track, with law: paper");
  }
  return keys;
}

}  // namespace

std::string controller_config_reference() {
  return controller_keys().reference();
}

controller::ReachOptions reach_options_from(const RobotConfig& robot) {
  return reach_options_of(read_controller_section(robot));
}

std::optional<std::string> target_name_from(const RobotConfig& robot) {
  return read_controller_section(robot).target_name;
}

}  // namespace multireach
