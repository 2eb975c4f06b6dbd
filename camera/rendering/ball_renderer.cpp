#include "camera/rendering/ball_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "numeric/random.hpp"
#include "numeric/trigonometry.hpp"

namespace multireach {
namespace {

constexpr uint64_t kDiscStream = 1, kTextureStream = 2, kNoiseStream = 1000;

/// Smooth noise in [0, 1]: random values on a square lattice of pitch 1, interpolated.
double value_noise(const CounterRandom& random, double x, double y) {
  const double fx = std::floor(x), fy = std::floor(y);
  const auto lattice = [&](double i, double j) {
    return random.uniform(static_cast<uint64_t>(static_cast<int64_t>(i) * 7919 + static_cast<int64_t>(j) * 104729));
  };
  const double u = x - fx, v = y - fy;
  const double su = u * u * (3 - 2 * u), sv = v * v * (3 - 2 * v);
  const double top = lattice(fx, fy) * (1 - su) + lattice(fx + 1, fy) * su;
  const double bottom = lattice(fx, fy + 1) * (1 - su) + lattice(fx + 1, fy + 1) * su;
  return top * (1 - sv) + bottom * sv;
}

/// An approximately normal number with unit variance: the sum of four uniform 16-bit numbers.
float normal(uint64_t bits) {
  const auto sum = static_cast<float>((bits & 0xffff) + (bits >> 16 & 0xffff) + (bits >> 32 & 0xffff) + (bits >> 48));
  return (sum / 65536.0F - 2.0F) * 1.7320508F;  // variance of the sum is 4/12
}

constexpr double kWhite = 255;

/// The light, on the scale of grey levels, that a camera shows as a grey level.
float light_of(double grey, double gamma) {
  return static_cast<float>(gamma == 1 ? grey : kWhite * std::pow(grey / kWhite, gamma));
}

cv::Vec3f light_of(const Rgb& c, double gamma) {
  return {light_of(c.b, gamma), light_of(c.g, gamma), light_of(c.r, gamma)};
}

/// Distance from the centre of a unit disc to the chord that cuts off this share of its area.
double chord_distance(double share) {
  double low = -1, high = 1;
  constexpr int kHalvings = 60;
  for (int k = 0; k < kHalvings; ++k) {
    const double d = (low + high) / 2;
    const double cut = (arc_cosine(d) - d * std::sqrt(1 - d * d)) / std::numbers::pi;
    (cut > share ? low : high) = d;
  }
  return low;
}

/// The occluder and the neighbour around the ball, in the camera's frame: what a ray hits in front of and behind the
/// ball.
class Surroundings {
 public:
  Surroundings(const ImageConditions& look, const Eigen::Vector3d& p_CB, double radius_m, double gamma)
      : look_(look), p_CB_(p_CB), gamma_(gamma) {
    if (look.occluder) {
      // The ball's contour as seen from the camera, in the card's plane.
      card_z_ = p_CB.z() - 1.05 * radius_m;
      card_ball_ = p_CB.head<2>() * (card_z_ / p_CB.z());
      card_radius_ = radius_m * card_z_ / p_CB.z();
      card_from_ = card_radius_ * chord_distance(look.occluder->occlusion);
      sine_and_cosine_of(look.occluder->angle_rad, card_way_.y(), card_way_.x());
    }
    if (look.neighbour) {
      Eigen::Vector2d way;
      sine_and_cosine_of(look.neighbour->angle_rad, way.y(), way.x());
      disc_ = p_CB.head<2>() + (radius_m + look.neighbour->gap_m + look.neighbour->radius_m) * way;
    }
  }

  std::optional<cv::Vec3f> before(const Eigen::Vector3d& ray) const {
    if (!look_.occluder) return std::nullopt;
    const Eigen::Vector2d p = ray.head<2>() * (card_z_ / ray.z()) - card_ball_;
    const double away = p.dot(card_way_), along = p.x() * card_way_.y() - p.y() * card_way_.x();
    const bool on_card = away > card_from_ && away < 2 * card_radius_ && std::abs(along) < 1.8 * card_radius_;
    return on_card ? std::optional(light_of(look_.occluder->colour, gamma_)) : std::nullopt;
  }
  std::optional<cv::Vec3f> behind(const Eigen::Vector3d& ray) const {
    if (!look_.neighbour) return std::nullopt;
    const Eigen::Vector2d p = ray.head<2>() * (p_CB_.z() / ray.z()) - disc_;
    const bool on_disc = p.norm() < look_.neighbour->radius_m;
    return on_disc ? std::optional(light_of(look_.neighbour->colour, gamma_)) : std::nullopt;
  }
  /// How far the occluder and the neighbour extend from the ball's centre, m.
  double reach_m(double radius_m) const {
    const double card = look_.occluder ? 2.8 * radius_m : 0;
    const double disc = look_.neighbour ? radius_m + look_.neighbour->gap_m + 2 * look_.neighbour->radius_m : 0;
    return std::max(card, disc);
  }

 private:
  const ImageConditions& look_;
  Eigen::Vector3d p_CB_;
  double gamma_;
  double card_z_ = 0, card_radius_ = 0, card_from_ = 0;
  Eigen::Vector2d card_ball_{0, 0}, card_way_{1, 0}, disc_{0, 0};
};

}  // namespace

BallRenderer::BallRenderer(const SceneOptions& scene, const CameraModel& camera, const Eigen::Isometry3d& X_WC,
                           const Eigen::Isometry3d& X_WL)
    : scene_(scene), camera_(camera), X_CW_(X_WC.inverse()) {
  light_C_ = X_CW_.linear() * Eigen::Vector3d(0.3, 0.4, 1.0).normalized();
  const CounterRandom random(scene.seed, kDiscStream);
  // Hues that only a badly chosen colour class confuses with a pink or red ball.
  const std::vector<cv::Vec3f> colours{{40, 140, 230}, {60, 200, 220}, {190, 110, 50},
                                       {70, 150, 60},  {150, 60, 110}, {200, 180, 160}};
  for (int i = 0; i < scene.distractors; ++i) {
    const auto at = 8 * static_cast<uint64_t>(i);
    const cv::Vec3f& colour = colours[random.bits(at + 3) % colours.size()];
    discs_.push_back({{random.uniform(at, -0.4, 0.4), random.uniform(at + 1, -0.3, 0.3)},
                      random.uniform(at + 2, 0.01, 0.05),
                      light_of({colour[2], colour[1], colour[0]})});
  }
  std::vector<Eigen::Vector2d> corners;
  for (int row = 0; row <= camera.height; ++row) {
    for (int column = 0; column <= camera.width; ++column) corners.emplace_back(column - 0.5, row - 0.5);
  }
  corner_rays_ = camera.rays(corners);

  const Eigen::Isometry3d X_LC = X_WL.inverse() * X_WC;
  wall_.create(camera.height, camera.width, CV_32FC3);
  for (int row = 0; row < camera.height; ++row) {
    for (int column = 0; column < camera.width; ++column) {
      cv::Vec3f sum(0, 0, 0);
      for (int k = 0; k < 4; ++k) {
        const Eigen::Vector3d ray = ray_in_pixel(column, row, 0.25 + 0.5 * (k % 2), 0.25 + 0.5 * (k / 2));
        sum += wall_colour(X_LC.translation(), X_LC.linear() * ray);
      }
      wall_.at<cv::Vec3f>(row, column) = sum / 4;
    }
  }
}

Eigen::Vector3d BallRenderer::ray_in_pixel(int column, int row, double right, double down) const {
  const size_t at = static_cast<size_t>(row) * (camera_.width + 1) + column, below = at + camera_.width + 1;
  const Eigen::Vector2d top = (1 - right) * corner_rays_[at] + right * corner_rays_[at + 1];
  const Eigen::Vector2d bottom = (1 - right) * corner_rays_[below] + right * corner_rays_[below + 1];
  return ((1 - down) * top + down * bottom).homogeneous();
}

cv::Vec3f BallRenderer::wall_colour(const Eigen::Vector3d& origin_L, const Eigen::Vector3d& direction_L) const {
  const Eigen::Vector3d p = origin_L + direction_L * ((scene_.wall_distance_m - origin_L.z()) / direction_L.z());
  for (const Disc& disc : discs_) {
    if ((p.head<2>() - disc.centre).norm() < disc.radius) return disc.colour;
  }
  const CounterRandom random(scene_.seed, kTextureStream);
  const double pitch = scene_.wall_fineness, contrast = scene_.wall_contrast;
  const double coarse = value_noise(random, p.x() * (9 * pitch), p.y() * (9 * pitch)),
               fine = value_noise(random, p.x() * (37 * pitch) + 100, p.y() * (37 * pitch));
  const auto shade = static_cast<float>(scene_.wall_grey + 60 * contrast * coarse + 12 * contrast * fine);
  return light_of({shade * 1.02F, shade, shade * 0.95F});
}

cv::Vec3f BallRenderer::light_of(const Rgb& colour) const {
  return multireach::light_of(colour, scene_.gamma);
}

std::optional<cv::Vec3f> BallRenderer::ball_colour(const Eigen::Vector3d& p_CB, const Eigen::Vector3d& ray,
                                                   const ImageConditions& look) const {
  const double a = ray.squaredNorm(), b = ray.dot(p_CB), r = scene_.ball_radius_m;
  const double discriminant = b * b - a * (p_CB.squaredNorm() - r * r);
  if (discriminant < 0) return std::nullopt;
  const Eigen::Vector3d normal_C = (ray * ((b - std::sqrt(discriminant)) / a) - p_CB) / r;
  const auto light = static_cast<float>(0.5 + 0.5 * std::max(0.0, normal_C.dot(light_C_)));
  const bool on_stripe =
      look.stripe && std::abs(normal_C.dot(X_CW_.linear() * look.stripe->axis_W)) < look.stripe->half_width;
  cv::Vec3f colour = light_of(on_stripe ? look.stripe->colour : scene_.ball_colour) * light;
  if (look.highlight > 0) {
    constexpr double kExponent = 60;
    const double cosine = std::max(0.0, normal_C.dot((light_C_ - ray.normalized()).normalized()));
    const auto white = static_cast<float>(look.highlight * std::pow(cosine, kExponent));
    colour += cv::Vec3f(white, white, white);
  }
  return colour;
}

void BallRenderer::draw_ball(const Eigen::Vector3d& p_CB, const ImageConditions& look, cv::Mat& image) const {
  if (p_CB.z() <= 2 * scene_.ball_radius_m) return;
  const Eigen::Vector2d centre = camera_.project(p_CB);
  const Surroundings surroundings(look, p_CB, scene_.ball_radius_m, scene_.gamma);
  const double reach_m = std::max(scene_.ball_radius_m, surroundings.reach_m(scene_.ball_radius_m));
  const double reach = 1.5 * std::max(camera_.fx, camera_.fy) * reach_m / (p_CB.z() - scene_.ball_radius_m) + 4;
  const auto bound = [](double value, int limit) { return std::clamp(static_cast<int>(std::floor(value)), 0, limit); };
  const int first_row = bound(centre.y() - reach, camera_.height),
            last_row = bound(centre.y() + reach + 1, camera_.height);
  const int first_column = bound(centre.x() - reach, camera_.width),
            last_column = bound(centre.x() + reach + 1, camera_.width);
  for (int row = first_row; row < last_row; ++row) {
    for (int column = first_column; column < last_column; ++column) {
      const int grid = scene_.rays_per_side;
      int hits = 0;
      cv::Vec3f sum(0, 0, 0);
      for (int k = 0; k < grid * grid; ++k) {
        const Eigen::Vector3d ray = ray_in_pixel(column, row, (k % grid + 0.5) / grid, (k / grid + 0.5) / grid);
        auto colour = surroundings.before(ray);
        if (!colour) colour = ball_colour(p_CB, ray, look);
        if (!colour) colour = surroundings.behind(ray);
        sum += colour ? *colour : image.at<cv::Vec3f>(row, column);
        hits += colour ? 1 : 0;
      }
      if (hits > 0) image.at<cv::Vec3f>(row, column) = sum / (grid * grid);
    }
  }
}

/// The image before noise, averaged over the exposure time.
cv::Mat BallRenderer::exposed(const Eigen::Vector3d& p_WB, const ImageConditions& look) const {
  constexpr int kInstants = 24;
  const int instants = look.motion_W.isZero(0) ? 1 : kInstants;
  cv::Mat sum = cv::Mat::zeros(wall_.size(), CV_32FC3);
  for (int k = 0; k < instants; ++k) {
    cv::Mat image = wall_.clone();
    const double share = (k + 0.5) / instants - 0.5;
    draw_ball(X_CW_ * (p_WB + share * look.motion_W), look, image);
    if (instants == 1) return image;
    sum += image / kInstants;
  }
  return sum;
}

cv::Mat BallRenderer::render(const std::optional<Eigen::Vector3d>& p_WB, uint64_t stream,
                             const ImageConditions& look) const {
  return developed(p_WB ? exposed(*p_WB, look) : wall_, stream, look);
}

cv::Mat BallRenderer::developed(const cv::Mat& image, uint64_t stream, const ImageConditions& look) const {
  std::array<float, 3> gains;
  for (size_t channel = 0; channel < 3; ++channel)
    gains[channel] = static_cast<float>(look.exposure * look.gains_rgb[2 - channel]);
  const CounterRandom random(scene_.seed, kNoiseStream + stream);
  const auto sigma = static_cast<float>(scene_.noise_grey_levels);
  cv::Mat result(image.size(), CV_8UC3);
  uint64_t counter = 0;
  for (int row = 0; row < image.rows; ++row) {
    const auto* in = image.ptr<float>(row);
    auto* out = result.ptr<uint8_t>(row);
    for (int i = 0; i < 3 * image.cols; ++i) {
      float value = in[i] * gains[static_cast<size_t>(i % 3)];
      if (scene_.gamma != 1)
        value = static_cast<float>(kWhite * std::pow(std::max(value, 0.0F) / kWhite, 1 / scene_.gamma));
      value += sigma * normal(random.bits(counter++)) + 0.5F;
      out[i] = static_cast<uint8_t>(std::clamp(value, 0.0F, 255.0F));
    }
  }
  return result;
}

}  // namespace multireach
