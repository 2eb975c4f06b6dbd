#pragma once

#include <fmt/format.h>

#include <optional>
#include <string>

#include "controller/law/attractor_gains.hpp"
#include "runtime/files.hpp"
#include "runtime/program.hpp"

namespace multireach {

/// The options that set the gains of a law and its integration rate.
struct GainOptions {
  std::optional<double> alpha, beta, natural_frequency, damping_ratio;
  double steps_per_second = controller::kReferenceRate;

  void add_to(CommandLine& cli) {
    cli.option("--alpha", alpha, "attractor gain per step, law guarded: of 1/140 s, Eq. (3); default 0.08")
        .finite(0.0, 1.0);
    cli.option("--beta", beta,
               "attractor gain per step, law guarded: of 1/140 s, Eq. (3); default 0.03 (paper) or 0.02")
        .finite(0.0, 1.0);
    cli.option("--natural-frequency", natural_frequency,
               "law guarded: of the attractors, instead of --alpha and --beta, rad/s; default 5.72")
        .finite(1e-3, 1e3);
    cli.option("--damping-ratio", damping_ratio,
               "law guarded: of the attractors, instead of --alpha and --beta; default 1.02")
        .finite(1.0, 1e2);
    cli.option("--steps-per-second", steps_per_second, "law guarded: integration rate, 1/s")
        .finite(1.0, 1e5)
        .show_default();
  }

  /// Throws InputError for options that exclude each other.
  void check(const std::string& law) const {
    const bool in_time = natural_frequency || damping_ratio;
    if (in_time && (alpha || beta))
      throw InputError("--alpha and --beta exclude --natural-frequency and --damping-ratio");
    if (law != "guarded" && (in_time || steps_per_second != controller::kReferenceRate))
      throw InputError("--natural-frequency, --damping-ratio and --steps-per-second need --law guarded");
  }

  controller::ViteGains gains(const std::string& law) const {
    return {alpha.value_or(0.08), beta.value_or(law == "paper" ? 0.03 : 0.02)};
  }

  std::optional<controller::AttractorMotion> attractor() const {
    if (!natural_frequency && !damping_ratio) return std::nullopt;
    const auto usual = controller::attractor_motion(gains("guarded"), controller::kReferenceRate);
    return controller::AttractorMotion{natural_frequency.value_or(usual.natural_frequency),
                                       damping_ratio.value_or(usual.damping_ratio)};
  }

  /// The options that give the same gains and rate, for a command line.
  std::string text(const std::string& law) const {
    const auto motion = attractor();
    const auto [a, b] = gains(law);
    std::string options = motion ? fmt::format("--natural-frequency {:.17g} --damping-ratio {:.17g}",
                                               motion->natural_frequency, motion->damping_ratio)
                                 : fmt::format("--alpha {:.17g} --beta {:.17g}", a, b);
    if (steps_per_second != controller::kReferenceRate)
      options += fmt::format(" --steps-per-second {:.17g}", steps_per_second);
    return options;
  }
};

}  // namespace multireach
