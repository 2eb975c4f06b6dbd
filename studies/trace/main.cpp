// multireach-trace: computes one reach offline and writes every step as CSV.
#include <cmath>
#include <cstdio>
#include <limits>

#include "controller/batch/paper_batch.hpp"
#include "controller/ik/multi_start.hpp"
#include "controller/law/guarded_law.hpp"
#include "runtime/files.hpp"
#include "runtime/program.hpp"
#include "studies/gain_options.hpp"
#include "studies/joint_options.hpp"

namespace multireach {
namespace {

struct Options {
  std::string urdf, base, tip, law = "paper", start, target, target_posture, acceleration, csv = "-";
  double gamma = 0;
  GainOptions gains;
  double drift_m = 0;
  int64_t steps = 0;
};

void add_options(CommandLine& cli, Options& options) {
  cli.option("--urdf", options.urdf, "URDF file").required();
  cli.option("--base", options.base, "link at the start of the chain; its frame is W").required();
  cli.option("--tip", options.tip, "link at the end of the chain, the hand").required();
  cli.option("--law", options.law, "control law").one_of({"paper", "guarded"}).show_default();
  cli.option("--start", options.start, "start posture, rad (m for a prismatic joint): --start=a,b,...").required();
  cli.option("--target", options.target, "hand target in W, m: --target=x,y,z").required();
  cli.option("--target-posture", options.target_posture,
             "first target posture theta_T, rad; default: the nearest posture that reaches the target");
  cli.option("--gamma", options.gamma, "weight of the hand's attractor, Eq. (28), rad^2/m^2")
      .required()
      .finite(0.0, 1e12);
  options.gains.add_to(cli);
  cli.option("--drift", options.drift_m,
             "law paper: search theta_T again when K(theta_T) is further than this from the target, m; 0: never, as "
             "printed in the paper")
      .finite(0.0, 1e6)
      .show_default();
  cli.option("--acceleration", options.acceleration, kAccelerationHelp);
  cli.option("--steps", options.steps, "integration steps; the output has one row more").required().whole(0, 100000000);
  cli.option("-o,--output", options.csv, "CSV file to write; - for standard output").show_default();
}

JointVector posture_of(const Chain& chain, const std::string& option, const std::string& text) {
  const std::vector<double> values = parse_numbers(option, text);
  if (const auto fault = joint_configuration_fault(chain, values, option)) throw InputError(*fault);
  return Eigen::Map<const Eigen::VectorXd>(values.data(), chain.size());
}

void append(std::string& row, double value) {
  char text[40];
  std::snprintf(text, sizeof text, ",%.17g", value);
  row += text;
}

template <class Angles>
std::string row_of(int64_t step, const Angles& theta, const Eigen::Vector3d& x, const Angles& theta_target) {
  std::string row = std::to_string(step);
  for (const double angle : theta) append(row, angle);
  for (const double coordinate : x) append(row, coordinate);
  for (const double angle : theta_target) append(row, angle);
  return row + "\n";
}

InputError refused() {
  return InputError("--start or --target-posture has an angle beyond 1e5 rad");
}

/// The rows of a reach under the law `paper`. Uses the same batch code as multireach-study, so both give the same
/// steps.
std::string paper_rows(const Chain& chain, const Options& options, const JointVector& start, const Eigen::Vector3d& x_T,
                       const JointVector& theta_target) {
  const controller::PaperParameters law{.gains = options.gains.gains(options.law), .gamma = options.gamma};
  const double drift_m = options.drift_m > 0 ? options.drift_m : std::numeric_limits<double>::infinity();
  controller::PaperBatch batch(chain, law, drift_m, 1);
  if (!batch.start(0, start, x_T, theta_target)) throw refused();
  const controller::ArmBlock& block = batch.block(0);
  JointVector goal(chain.size());
  std::string rows;
  for (int64_t step = 0; step <= options.steps; ++step) {
    if (step > 0) batch.step();
    for (int i = 0; i < chain.size(); ++i) goal[i] = block.joints[static_cast<size_t>(i)].theta_target[0];
    rows += row_of(step, batch.theta(0), batch.x(0), goal);
  }
  return rows;
}

std::string guarded_rows(const Chain& chain, const Options& options, const JointVector& start,
                         const Eigen::Vector3d& x_T, const JointVector& theta_target) {
  controller::GuardedParameters parameters;
  parameters.gains = options.gains.gains(options.law);
  parameters.attractor = options.gains.attractor();
  parameters.steps_per_second = options.gains.steps_per_second;
  parameters.gamma = options.gamma;
  parameters.acceleration = joint_values_from("--acceleration", options.acceleration, chain);
  controller::GuardedLaw law(chain, parameters);
  if (!law.start(start) || law.set_target({.position = x_T}, theta_target) == controller::TargetResult::kRefused)
    throw refused();
  std::string rows = row_of(0, law.theta(), law.x(), law.theta_target());
  for (int64_t step = 1; step <= options.steps; ++step) {
    law.step();
    rows += row_of(step, law.theta(), law.x(), law.theta_target());
  }
  return rows;
}

int trace(const Options& options) {
  options.gains.check(options.law);
  const Chain chain = load_chain(options.urdf, options.base, options.tip);
  const JointVector start = posture_of(chain, "--start", options.start);
  const std::vector<double> target = parse_numbers("--target", options.target);
  if (target.size() != 3) throw InputError("--target has " + std::to_string(target.size()) + " values; expected x,y,z");
  const Eigen::Vector3d x_T(target[0], target[1], target[2]);
  if (!x_T.allFinite()) throw InputError("--target has a value that is not a finite number");

  const controller::MultiStartIk search(chain);
  JointVector theta_target;
  if (options.target_posture.empty()) {
    const auto found = search.nearest(x_T, start);
    if (!found) {
      std::fprintf(stderr,
                   "multireach-trace: no posture inside the limits of the chain from '%s' to '%s' reaches the target\n",
                   options.base.c_str(), options.tip.c_str());
      return 1;
    }
    theta_target = *found;
  } else {
    theta_target = posture_of(chain, "--target-posture", options.target_posture);
  }

  std::string csv = "step";
  for (const Joint& joint : chain.joints()) csv += "," + joint.name;
  csv += ",x_m,y_m,z_m";
  for (const Joint& joint : chain.joints()) csv += "," + joint.name + "_target";
  csv += "\n";
  csv += options.law == "paper" ? paper_rows(chain, options, start, x_T, theta_target)
                                : guarded_rows(chain, options, start, x_T, theta_target);
  write_text_file(options.csv, csv);
  return 0;
}

}  // namespace
}  // namespace multireach

int main(int argc, char** argv) {
  multireach::Program program("multireach-trace", "One reach, offline, step by step, as CSV.");
  multireach::Options options;
  add_options(program.cli(), options);
  return program.run(argc, argv, [&] { return trace(options); });
}
