// Figs. 7 and 8, and the cost of gamma: statistics of many random reaches.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <thread>

#include "studies/figures/scenes.hpp"
#include "studies/study/study.hpp"

namespace multireach {
namespace {

constexpr uint64_t kSeed = 1;
constexpr int64_t kReaches = 10000;
constexpr controller::ViteGains kPaperGains{0.08, 0.03};

StudyResult study_of(const Chain& chain, bool guarded, const std::vector<double>& gammas, int64_t samples) {
  StudyLaw law;
  law.guarded = guarded;
  if (!guarded) law.gains = kPaperGains;
  const int threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return run_study(chain, ReachSampler(chain, kSeed), law, gammas, 0, samples, threads, !guarded);
}

double percent(int64_t count, int64_t of) {
  return 100 * static_cast<double>(count) / static_cast<double>(of);
}

std::string at_gamma(double gamma) {
  char text[32];
  std::snprintf(text, sizeof text, "γ = %g", gamma);
  return text;
}

}  // namespace

Figure failures_scene(const SceneArm& arm) {
  const std::vector<double> gammas{50, 100, 150, 200, 250, 300, 350, 500, 700, 1000};
  Figure figure{Table({"gamma", "paper", "paper_low", "paper_high", "guarded", "guarded_low", "guarded_high"})};
  const auto paper = study_of(arm.chain, false, gammas, kReaches).tallies;
  const auto guarded = study_of(arm.chain, true, gammas, kReaches).tallies;
  for (size_t k = 0; k < gammas.size(); ++k) {
    std::vector<double> row{gammas[k]};
    for (const Tally* tally : {&paper[k], &guarded[k]}) {
      const auto [low, high] = tally->failure_interval();
      row.insert(row.end(), {percent(tally->failures, tally->samples), 100 * low, 100 * high});
    }
    figure.curves.row(row);
    figure.add(at_gamma(gammas[k]), "paper; reaches of 10 000 that failed", static_cast<double>(paper[k].failures));
    figure.add(at_gamma(gammas[k]), "paper; 95 % interval up to", row[3], "%");
    figure.add(at_gamma(gammas[k]), "guarded; reaches that failed", static_cast<double>(guarded[k].failures));
    figure.add(at_gamma(gammas[k]), "guarded; 95 % interval up to", row[6], "%");
  }
  return figure;
}

namespace {

/// Adds the percentages of points (relative to the shoulder) below it, behind it, and near its vertical.
void add_region_shares(Figure& figure, const std::string& law, const std::string& what,
                       const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& down) {
  const auto share = [&](const auto& holds) {
    return percent(std::ranges::count_if(points, holds), static_cast<int64_t>(points.size()));
  };
  figure.add(law, what + "below the shoulder", share([](const Eigen::Vector3d& p) { return p.z() < 0; }), "%");
  figure.add(law, what + "behind the shoulder", share([](const Eigen::Vector3d& p) { return p.x() < 0; }), "%");
  const double half_right_angle = std::cos(std::numbers::pi / 4) * down.norm();
  const auto hangs = [&](const Eigen::Vector3d& p) { return p.dot(down) > half_right_angle * p.norm(); };
  figure.add(law, what + "within 45° of straight down", share(hangs), "%");
}

}  // namespace

Figure unreached_scene(const SceneArm& arm) {
  constexpr int kDrawn = 400;  // points drawn per gamma; limits the size of the figure
  const std::vector<double> gammas{350, 1000, 10000};
  const Chain& chain = arm.chain;
  const Eigen::Vector3d shoulder = chain.fixed(0).translation();
  const Eigen::Vector3d down = chain.position(chain.clamped(JointVector::Zero(chain.size()))) - shoulder;
  const StudyResult result = study_of(chain, false, gammas, kReaches);
  Figure figure{Table({"gamma", "forward", "left", "up", "hand_forward", "hand_left", "hand_up"})};
  std::vector<Eigen::Vector3d> targets, hands;
  for (size_t k = 0; k < gammas.size(); ++k) {
    targets.clear();
    hands.clear();
    for (const FailedReach& reach : result.failed) {
      if (reach.gamma != k) continue;
      targets.push_back(reach.target - shoulder);
      hands.push_back(reach.hand - shoulder);
      if (targets.size() > kDrawn) continue;
      const Eigen::Vector3d &p = targets.back(), &q = hands.back();
      figure.curves.row({gammas[k], p.x(), p.y(), p.z(), q.x(), q.y(), q.z()});
    }
    if (targets.empty()) continue;
    figure.add(at_gamma(gammas[k]), "targets", static_cast<double>(targets.size()));
    add_region_shares(figure, at_gamma(gammas[k]), "targets ", targets, down);
    add_region_shares(figure, at_gamma(gammas[k]), "hands at rest ", hands, down);
  }
  std::vector<ReachSample> samples(kReaches);
  ReachSampler(chain, kSeed).sample(0, samples);
  targets.clear();
  for (const ReachSample& sample : samples) targets.push_back(sample.target - shoulder);
  figure.add("all targets", "targets", static_cast<double>(kReaches));
  add_region_shares(figure, "all targets", "targets ", targets, down);
  return figure;
}

Figure gamma_scene(const SceneArm& arm) {
  constexpr int64_t kFewer = 2500;
  const std::vector<double> gammas{10, 30, 100, 200, 350, 700, 1000, 3000, 10000};
  Figure figure{
      Table({"gamma", "paper_failed", "guarded_failed", "paper_limit", "guarded_limit", "paper_speed", "guarded_speed",
             "paper_p50", "guarded_p50", "paper_p95", "guarded_p95", "paper_settle", "guarded_settle"})};
  const auto paper = study_of(arm.chain, false, gammas, kFewer).tallies;
  const auto guarded = study_of(arm.chain, true, gammas, kFewer).tallies;
  for (size_t k = 0; k < gammas.size(); ++k) {
    std::vector<double> row{gammas[k]};
    const auto both = [&](const std::string& quantity, const std::string& unit, const auto& value) {
      for (const auto& [name, tally] : {std::pair("paper", &paper[k]), std::pair("guarded", &guarded[k])}) {
        row.push_back(value(*tally));
        figure.add(at_gamma(gammas[k]), std::string(name) + "; " + quantity, row.back(), unit);
      }
    };
    both("failed", "%", [](const Tally& tally) { return percent(tally.failures, tally.samples); });
    both("beyond a position limit", "%",
         [](const Tally& tally) { return percent(tally.limit_violations, tally.samples); });
    both("beyond a speed limit", "%",
         [](const Tally& tally) { return percent(tally.velocity_violations, tally.samples); });
    const auto ratio = [](double p) {
      return [p](const Tally& tally) {
        return static_cast<double>(tally.path_ratio.quantile(p).value_or(0)) / Tally::kRatioBins;
      };
    };
    both("path / distance; median", "", ratio(0.5));
    both("path / distance; 95 %", "", ratio(0.95));
    both("within 1 mm for good after; median", "s", [](const Tally& tally) {
      return static_cast<double>(tally.settle_steps.quantile(0.5).value_or(0)) / ReachRules{}.steps_per_second;
    });
    figure.curves.row(row);
  }
  return figure;
}

}  // namespace multireach
