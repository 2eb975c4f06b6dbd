// multireach-bench-accuracy: position error of a rendered sphere, and consistency of the estimated covariance, as a
// table.
#include <CLI/CLI.hpp>
#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cstdio>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "camera/rendering/ball_renderer.hpp"
#include "numeric/random.hpp"
#include "numeric/trigonometry.hpp"
#include "vision/colour/find.hpp"
#include "vision/stereo/stereo_match.hpp"

namespace multireach::bench {
namespace {

using vision::StereoMatch;

/// The background behind the ball.
struct Background {
  const char* name;
  SceneOptions scene;
};

std::vector<Background> backgrounds(double wall_distance_m, uint64_t first_seed) {
  const SceneOptions base{
      .seed = first_seed, .wall_distance_m = wall_distance_m, .noise_grey_levels = 3, .rays_per_side = 16};
  SceneOptions dark = base, bright = base, fine = base;
  dark.seed = first_seed + 1;
  dark.wall_grey = 8;
  dark.wall_contrast = 0.15;
  bright.seed = first_seed + 2;
  bright.wall_grey = 190;
  bright.wall_contrast = 0.4;
  fine.seed = first_seed + 3;
  fine.wall_grey = 60;
  fine.wall_contrast = 1.3;
  fine.wall_fineness = 5.4 / wall_distance_m;  // keeps the texture's pitch in the image constant
  return {{"plain", base}, {"dark", dark}, {"bright", bright}, {"textured", fine}};
}

struct Case {
  std::string name;
  double near_m = 0.5, far_m = 0.5;
  int jpeg_quality = 0;  // 0 for no compression
  double occlusion = 0;
  bool neighbour = false;
  bool distorted = false;
  double motion_px = 0;  // during the exposure, in a direction of its own in each image pair
  double highlight = 0;  // grey levels
  bool stripe = false;
  double cut_off = 0;  // share of the ball's width beyond a border of the image, at most
  bool radius_unknown = false;
  double gamma = 1;         // of the camera
  bool gamma_known = true;  // to vision
  double most_rms_mm = 0;
  bool expect_occluded = false;  // expected status: kOccludedTooMuch
};

std::vector<Case> cases() {
  return {
      {.name = "0.5 m", .most_rms_mm = 0.35},
      {.name = "0.5 m, lens distortion", .distorted = true, .most_rms_mm = 0.35},
      {.name = "1 to 2 m", .near_m = 1, .far_m = 2, .most_rms_mm = 3.5},
      {.name = "0.5 m, similar hue touches", .neighbour = true, .most_rms_mm = 0.35},
      {.name = "0.5 m, JPEG q95", .jpeg_quality = 95, .most_rms_mm = 0.8},
      {.name = "0.5 m, JPEG q90", .jpeg_quality = 90, .most_rms_mm = 0.8},
      {.name = "0.5 m, JPEG q75", .jpeg_quality = 75},
      {.name = "1 to 2 m, JPEG q90", .near_m = 1, .far_m = 2, .jpeg_quality = 90},
      {.name = "1 to 2 m, JPEG q75", .near_m = 1, .far_m = 2, .jpeg_quality = 75},
      {.name = "0.5 m, one tenth occluded", .occlusion = 0.1, .most_rms_mm = 4},
      {.name = "0.5 m, three tenths occluded", .occlusion = 0.3, .most_rms_mm = 0, .expect_occluded = true},
      {.name = "0.5 m, half occluded, radius unknown", .occlusion = 0.5, .radius_unknown = true},
      {.name = "0.5 m, cut off by the border", .cut_off = 0.25},
      {.name = "0.5 m, cut off by the border, radius unknown", .cut_off = 0.25, .radius_unknown = true},
      {.name = "0.5 m, radius unknown", .radius_unknown = true},
      {.name = "0.5 m, gamma not known, radius unknown", .radius_unknown = true, .gamma_known = false},
      {.name = "0.5 m, gamma 2.2", .gamma = 2.2},
      {.name = "0.5 m, gamma 2.2, radius unknown", .radius_unknown = true, .gamma = 2.2},
      {.name = "0.5 m, gamma 2.2, not known", .gamma = 2.2, .gamma_known = false},
      {.name = "0.5 m, gamma 2.2, not known, radius unknown",
       .radius_unknown = true,
       .gamma = 2.2,
       .gamma_known = false},
      {.name = "0.5 m, gamma 2.2, not known, JPEG q90", .jpeg_quality = 90, .gamma = 2.2, .gamma_known = false},
      {.name = "0.5 m, gamma 2.2, not known, JPEG q90, radius unknown",
       .jpeg_quality = 90,
       .radius_unknown = true,
       .gamma = 2.2,
       .gamma_known = false},
      {.name = "1 to 2 m, gamma 2.2, not known", .near_m = 1, .far_m = 2, .gamma = 2.2, .gamma_known = false},
      {.name = "0.5 m, highlight", .highlight = 150},
      {.name = "0.5 m, highlight, JPEG q90", .jpeg_quality = 90, .highlight = 150},
      {.name = "0.5 m, stripe", .stripe = true},
      {.name = "0.5 m, stripe, JPEG q90", .jpeg_quality = 90, .stripe = true},
      {.name = "0.5 m, motion of 4 px", .motion_px = 4},
      {.name = "0.5 m, motion of 8 px", .motion_px = 8},
      {.name = "0.5 m, motion of 8 px, JPEG q90", .jpeg_quality = 90, .motion_px = 8},
      {.name = "0.5 m, motion of 12 px", .motion_px = 12},
      {.name = "0.5 m, motion of 20 px", .motion_px = 20},
      {.name = "0.5 m, motion of 20 px, radius unknown", .motion_px = 20, .radius_unknown = true},
  };
}

StereoRig rig_of(const Case& c) {
  StereoRig rig;
  rig.left = {.width = 640, .height = 480, .fx = 500, .fy = 500, .cx = 319.5, .cy = 239.5, .distortion = {}};
  if (c.distorted) rig.left.distortion = {-0.28, 0.09, 0.0008, -0.0006, -0.01, 0, 0, 0};
  rig.left.gamma = c.gamma_known ? std::optional(c.gamma) : std::nullopt;
  rig.right = rig.left;
  rig.X_RL = rig.X_WL = Eigen::Isometry3d::Identity();
  rig.X_RL.translation().x() = -0.06;
  // Looking down at an angle, as the cameras of robots/hoap2 do: the light comes from above.
  rig.X_WL.linear() = rotation_from_rpy({-2.54818, 0, -1.570796});
  return rig;
}

/// The two cameras' renderers for one background.
struct StereoRenderer {
  StereoRenderer(const StereoRig& rig, const SceneOptions& scene)
      : left(scene, rig.left, rig.X_WL, rig.X_WL), right(scene, rig.right, rig.X_WL * rig.X_RL.inverse(), rig.X_WL) {}
  BallRenderer left, right;
};

/// The pixel in the left image of a ball that a border cuts off: the upper or the lower one in both images, the right
/// one in the left image, or the left one in the right image. `beyond`: share of its width.
Eigen::Vector2d cut_off_pixel(const StereoRig& rig, double z, double radius_px, int border, double beyond,
                              const Eigen::Vector2d& elsewhere) {
  const double inside = radius_px * (1 - 2 * beyond), disparity = rig.left.fx * -rig.X_RL.translation().x() / z;
  switch (border) {
    case 0:
      return {elsewhere.x(), inside};
    case 1:
      return {elsewhere.x(), rig.left.height - 1 - inside};
    case 2:
      return {rig.left.width - 1 - inside, elsewhere.y()};
    default:
      return {disparity + inside, elsewhere.y()};
  }
}

struct Statistics {
  int shown = 0, seen = 0, declared = 0, by_edges = 0, inside = 0;
  double nees = 0, square = 0, occlusion = 0;
  std::vector<double> errors_m;
  Eigen::Array3d error{0, 0, 0}, normalised2{0, 0, 0};

  /// `ray`: to the position; NEES by axis is across, down and along it.
  void add(const Eigen::Vector3d& apart, const Eigen::Matrix3d& covariance, const Eigen::Vector3d& ray) {
    constexpr double kChi2 = 7.815;  // 95 % of chi^2 with three degrees of freedom
    const double squared_sigmas = apart.dot(covariance.ldlt().solve(apart));
    nees += squared_sigmas;
    inside += squared_sigmas < kChi2;
    square += apart.squaredNorm();
    errors_m.push_back(apart.norm());
    error += apart.array();
    const Eigen::Matrix3d R = Eigen::Quaterniond::FromTwoVectors(ray, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    normalised2 += (R * apart).array().square() / (R * covariance * R.transpose()).diagonal().array();
  }
  void add(const Statistics& other) {
    shown += other.shown;
    seen += other.seen;
    declared += other.declared;
    by_edges += other.by_edges;
    inside += other.inside;
    nees += other.nees;
    square += other.square;
    occlusion += other.occlusion;
    errors_m.insert(errors_m.end(), other.errors_m.begin(), other.errors_m.end());
    error += other.error;
    normalised2 += other.normalised2;
  }
  int located() const { return static_cast<int>(errors_m.size()); }
  double rms_mm() const { return errors_m.empty() ? 0 : 1000 * std::sqrt(square / located()); }
  double median_mm() const {
    std::vector<double> sorted = errors_m;
    std::ranges::sort(sorted);
    return sorted.empty() ? 0 : 1000 * sorted[sorted.size() / 2];
  }
  double inside_percent() const { return errors_m.empty() ? 0 : 100.0 * inside / located(); }
  double nees_per_dimension() const { return errors_m.empty() ? 0 : nees / located() / 3; }
};

/// What the command line chooses.
struct Choices {
  int positions = 400, rooms = 1;
  uint64_t seed = 1, first_wall = 1;
  bool unknown_radius = false, by_background = false, each = false;
  std::string only, without, json;
};

/// One room: four walls, and positions of the sphere in front of them.
class Room {
 public:
  Room(const Choices& choices, int number)
      : positions_(choices.positions / choices.rooms),
        seed_(choices.seed + static_cast<uint64_t>(number)),
        first_wall_(choices.first_wall + 4 * static_cast<uint64_t>(number)),
        radius_known_(!choices.unknown_radius),
        verbose_(choices.by_background),
        each_(choices.each) {}

  Statistics run(const Case& c) {
    const StereoRig rig = rig_of(c);
    const std::vector<Background> walls = backgrounds(c.far_m > 0.7 ? 2.6 : 0.9, first_wall_);
    const double radius = walls[0].scene.ball_radius_m;
    vision::MatchOptions options;
    const bool radius_known = radius_known_ && !c.radius_unknown;
    if (radius_known) options.radius_m = radius;
    const double least_seen =
        radius_known ? vision::SphereContourFitter::kOfASphere : vision::SphereContourFitter::kOfAnything;
    vision::SphereContourFitter left_measurer(rig.left, least_seen), right_measurer(rig.right, least_seen);
    Statistics sums;
    for (size_t wall = 0; wall < walls.size(); ++wall) {
      const StereoRenderer& renderer = renderer_of(c, walls[wall], rig);
      Statistics of_wall;
      for (int k = static_cast<int>(wall); k < positions_; k += static_cast<int>(walls.size())) {
        const CounterRandom random(seed_, static_cast<uint64_t>(k));
        const double z = random.uniform(0, c.near_m, c.far_m);
        Eigen::Vector2d pixel(random.uniform(1, 130, 580), random.uniform(2, 60, 420));
        if (c.cut_off > 0) {
          const int border = k / static_cast<int>(walls.size()) % 4;
          pixel = cut_off_pixel(rig, z, rig.left.fx * radius / z, border, random.uniform(8, 0.02, c.cut_off), pixel);
        }
        const Eigen::Vector3d p_LB = z * rig.left.ray(pixel).homogeneous(), p_WB = rig.X_WL * p_LB;
        ImageConditions look;
        const double angle = random.uniform(3, 0, 6.283185307179586);
        if (c.occlusion > 0) look.occluder = Occluder{.occlusion = c.occlusion, .angle_rad = angle};
        if (c.neighbour) look.neighbour = Neighbour{.angle_rad = angle, .radius_m = random.uniform(4, 0.008, 0.03)};
        if (c.motion_px > 0) {
          const Eigen::Vector3d way_L(std::cos(angle), std::sin(angle), 0);
          look.motion_W = rig.X_WL.linear() * way_L * (c.motion_px * z / rig.left.fx);
        }
        look.highlight = c.highlight;
        if (c.stripe) {
          const Eigen::Vector3d axis(random.uniform(5, -1, 1), random.uniform(6, -1, 1), random.uniform(7, -1, 1));
          look.stripe = Stripe{.axis_W = axis.normalized()};
        }
        const auto stream = static_cast<uint64_t>(2 * k);
        const auto left = contours(renderer.left.render(p_WB, stream, look), c, left_measurer);
        const auto right = contours(renderer.right.render(p_WB, stream + 1, look), c, right_measurer);
        const StereoMatch match = vision::match_candidates(rig, left, right, std::nullopt, options);
        for (Statistics* s : {&sums, &of_wall}) add_match(match, p_LB, rig, *s);
        if (each_) print_match(walls[wall].name, k, match, p_LB, rig, left, right);
      }
      if (verbose_) print(("  " + std::string(walls[wall].name)).c_str(), of_wall);
    }
    return sums;
  }

  static void print(const char* name, const Statistics& s) {
    std::vector<double> sorted = s.errors_m;
    std::ranges::sort(sorted);
    const double n = std::max(1, s.located());
    const Eigen::Array3d bias = 1000 * s.error / n, each = s.normalised2 / n;
    std::printf(
        "| %s | %d | %d | %d | %d | %.3f | %.3f | %.3f | %.3f | %.2f %.2f %.2f | %.3f %.3f %.3f | %.2f | %.0f %% | "
        "%.3f "
        "|\n",
        name, s.shown, s.seen, s.declared, s.by_edges, s.median_mm(), s.rms_mm(),
        sorted.empty() ? 0 : 1000 * sorted[sorted.size() * 95 / 100], sorted.empty() ? 0 : 1000 * sorted.back(),
        each.x(), each.y(), each.z(), bias.x(), bias.y(), bias.z(), s.nees_per_dimension(), s.inside_percent(),
        s.shown > 0 ? s.occlusion / s.shown : 0);
    std::fflush(stdout);
  }

 private:
  /// Rendering a wall is slow, so all cases that can share a stage do.
  const StereoRenderer& renderer_of(const Case& c, const Background& wall, const StereoRig& rig) {
    const std::string key = std::string(wall.name) + (c.distorted ? " distorted" : "") + (c.far_m > 0.7 ? " far" : "") +
                            (c.gamma != 1 ? " gamma" : "");
    SceneOptions scene = wall.scene;
    scene.gamma = c.gamma;
    return renderers_.try_emplace(key, rig, scene).first->second;
  }

  std::vector<vision::SphereContour> contours(cv::Mat image, const Case& c, vision::SphereContourFitter& fitter) {
    if (c.jpeg_quality > 0) {
      std::vector<uint8_t> bytes;
      cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, c.jpeg_quality});
      image = cv::imdecode(bytes, cv::IMREAD_COLOR);
    }
    std::vector<vision::SphereContour> result;
    const cv::Rect whole({0, 0}, image.size());
    for (const vision::Blob& blob : finder_.find(image, whole, colours_, {.min_area = 20, .most = 4}).blobs) {
      result.push_back(fitter.fit(image, blob, whole, c.jpeg_quality > 0));
    }
    return result;
  }

  static void add_match(const StereoMatch& match, const Eigen::Vector3d& p_LB, const StereoRig& rig, Statistics& sums) {
    using Status = StereoMatch::Status;
    ++sums.shown;
    sums.seen += match.status == Status::kSeen;
    sums.declared += match.status == Status::kOccludedTooMuch || match.status == Status::kCutOff;
    if (match.status != Status::kSeen && match.status != Status::kOccludedTooMuch) return;
    sums.by_edges += match.both_by_contour;
    sums.occlusion += match.occlusion;
    // In the left camera's frame, whose third axis is depth.
    const Eigen::Matrix3d R_LW = rig.X_WL.linear().transpose();
    sums.add(rig.X_WL.inverse() * match.point.p_W - p_LB, R_LW * match.covariance() * R_LW.transpose(), p_LB);
  }

  /// A line for one position: errors and standard deviations along x, y and z of the left camera, and what was fitted.
  static void print_match(const char* wall, int k, const StereoMatch& match, const Eigen::Vector3d& p_LB,
                          const StereoRig& rig, std::span<const vision::SphereContour> left,
                          std::span<const vision::SphereContour> right) {
    std::printf("    %s %d: %s", wall, k, vision::description(match.status));
    if (match.left < 0 || match.right < 0) {
      std::printf("\n");
      return;
    }
    const Eigen::Matrix3d R_LW = rig.X_WL.linear().transpose();
    const Eigen::Vector3d error = rig.X_WL.inverse() * match.point.p_W - p_LB;
    const Eigen::Matrix3d covariance = R_LW * match.covariance() * R_LW.transpose();
    std::printf(", mm");
    for (int axis = 0; axis < 3; ++axis)
      std::printf(" %.3f (%.3f)", 1000 * error[axis], 1000 * std::sqrt(covariance(axis, axis)));
    std::printf(", NEES %.1f", error.dot(covariance.ldlt().solve(error)));
    for (const vision::SphereContour* contour :
         {&left[static_cast<size_t>(match.left)], &right[static_cast<size_t>(match.right)]}) {
      const bool edges = contour->kind == vision::SphereContour::Kind::kEdges;
      std::printf("; %s visible %.2f motion %.1f residual %.2f occlusion %.2f", edges ? "contour" : "centroid",
                  contour->visible_fraction, contour->motion_px, contour->residual_px, contour->occlusion);
    }
    std::printf("\n");
  }

  int positions_;
  uint64_t seed_, first_wall_;
  bool radius_known_, verbose_, each_;
  std::map<std::string, StereoRenderer> renderers_;
  vision::ColourTable colours_{vision::model_of({.references = {{220, 40, 110}}})};
  vision::BlobFinder finder_;
};

int measure(const Choices& choices) {
  std::printf(
      "Rendered sphere of 2 cm, f = 500 px, 640 x 480, baseline 6 cm, noise 3 grey levels, %d positions a case, from "
      "seed %llu, walls from %llu, four for each of %d rooms, radius %s\n\n",
      choices.positions, static_cast<unsigned long long>(choices.seed),
      static_cast<unsigned long long>(choices.first_wall), choices.rooms,
      choices.unknown_radius ? "not known" : "known");
  std::printf(
      "| case | shown | seen | declared occluded | by edges | median mm | RMS mm | p95 | max | NEES across, down, "
      "along the ray | bias mm x "
      "y z | "
      "NEES/3 | inside 95 %% | occlusion |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  std::vector<Case> chosen = cases();
  std::erase_if(chosen, [&](const Case& c) {
    const auto contains = [&](const std::string& text) { return c.name.find(text) != std::string::npos; };
    return !contains(choices.only) || (!choices.without.empty() && contains(choices.without));
  });
  // Room by room, because the walls of a room take much memory.
  std::vector<Statistics> results(chosen.size());
  for (int number = 0; number < choices.rooms; ++number) {
    Room room(choices, number);
    for (size_t k = 0; k < chosen.size(); ++k) {
      results[k].add(room.run(chosen[k]));
      if (number == choices.rooms - 1) Room::print(chosen[k].name.c_str(), results[k]);
    }
  }
  nlohmann::json report = {{"positions", choices.positions},
                           {"rooms", choices.rooms},
                           {"seed", choices.seed},
                           {"first_wall", choices.first_wall},
                           {"radius_known", !choices.unknown_radius}};
  Statistics all;
  for (size_t k = 0; k < chosen.size(); ++k) {
    const Statistics& sums = results[k];
    all.add(sums);
    report["cases"].push_back({{"name", chosen[k].name},
                               {"shown", sums.shown},
                               {"seen", sums.seen},
                               {"declared_occluded", sums.declared},
                               {"median_mm", sums.median_mm()},
                               {"rms_mm", sums.rms_mm()},
                               {"aim_rms_mm", chosen[k].most_rms_mm},
                               {"inside_95_percent", sums.inside_percent()},
                               {"nees_per_dimension", sums.nees_per_dimension()}});
  }
  report["nees_per_dimension"] = all.nees_per_dimension();
  std::printf("\nAll cases: NEES/3 = %.3f\n", all.nees_per_dimension());
  if (choices.json == "-") {
    std::printf("%s\n", report.dump(2).c_str());
  } else if (!choices.json.empty()) {
    std::ofstream file(choices.json);
    file << report.dump(2) << '\n';
    if (!file.flush()) {
      std::fprintf(stderr, "multireach-bench-accuracy: cannot write %s\n", choices.json.c_str());
      return 1;
    }
  }
  return 0;
}

}  // namespace
}  // namespace multireach::bench

int main(int argc, char** argv) {
  CLI::App app("Position error of a rendered sphere, as a Markdown table.");
  multireach::bench::Choices choices;
  app.add_option("--positions", choices.positions, "of the sphere, in each case: equally many in each room")
      ->check(CLI::Range(4, 1000000))
      ->capture_default_str();
  app.add_option("--rooms", choices.rooms, "each with four walls and positions of its own")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--seed", choices.seed, "of the positions in the first room")->capture_default_str();
  app.add_option("--walls", choices.first_wall, "seed of the first wall of the first room")->capture_default_str();
  app.add_flag("--unknown-radius", choices.unknown_radius, "do not tell the sphere's radius");
  app.add_flag("--by-background", choices.by_background, "a line for each room and background as well");
  app.add_flag("--each", choices.each, "a line for each position as well");
  app.add_option("--only", choices.only, "cases whose name contains this");
  app.add_option("--without", choices.without, "not those whose name contains this");
  app.add_option("--json", choices.json, "write the results there as JSON; - for standard output");
  CLI11_PARSE(app, argc, argv);
  if (choices.positions % (4 * choices.rooms) != 0) {
    std::fprintf(stderr, "multireach-bench-accuracy: --positions %d is not a multiple of %d, the walls of --rooms %d\n",
                 choices.positions, 4 * choices.rooms, choices.rooms);
    return 2;
  }
  return multireach::bench::measure(choices);
}
