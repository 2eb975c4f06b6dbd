#include "vision/contour/contour_covariance.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace multireach::vision {
namespace {

// Errors of the image model (blur, shading, lens) that the edges do not reveal, pixels.
constexpr double kModelCentre = 0.003, kModelRadius = 0.04;
constexpr double kModelBlur = 0.05;  // asymmetry of the blur, share of its width
constexpr double kNoBlur = 0.2;      // px^2: blur that sharp edges of a shaded ball appear to have
// Set on rendered balls (docs/vision-accuracy.md, Errors and covariance, names them): the variance of an image's own
// errors, in variances of what the edges say, with chroma of full resolution (1 where no light has a direction) and in
// blocks of it, which the encoding or only the edges tell; how it grows in a small contour (pixels of radius), where
// edges are missing, and, with chroma of full resolution, with the share of the contour beside which the surface has
// another colour.
constexpr double kOwnEdges = 0.7, kBlocks = 2, kGuessedBlocks = 3;
constexpr double kFewPixels = 5, kBlockPixels = 11, kOneSideOnly = 2, kPainted = 40, kOneSided = 0.25;
// The shared error along the light, in variances of an image's own: usual, and in blocks of chroma.
constexpr double kSharedEdges = 2, kSharedBlocks = 1.5;
constexpr double kLeastShading = 0.1;  // share of the shading model's expected variance that is never ruled out
// The same, of an edge whose blur along the motion has the variance v (px^2, as measured): error kMoved v^1.5, pixels,
// and its share in the size.
constexpr double kMoved = 0.043, kMovedSize = 0.75;
// The same, of edges that are blurred by more than the variance kFast, from their residual beyond the usual one,
// pixels.
constexpr double kFast = 1, kUsualResidual = 0.3, kFaster = 2;

/// Neighbours on the contour share errors (texture, JPEG blocks), so there are fewer independent points than points.
/// The sum of the residuals' autocorrelation is the ratio of the two.
double neighbours_agree(const ContourEvidence& evidence) {
  constexpr size_t kLags = 12;
  const size_t count = evidence.edgels.size();
  std::array<double, kMaxContourPoints + kLags> weights, values;  // periodic: the first kLags again at the end
  for (size_t i = 0; i < count + kLags; ++i) {
    const ContourEdgel& edgel = evidence.edgels[i % count];
    weights[i] = values[i] = 0;
    if (edgel.point < 0) continue;
    const ContourPoint& point = evidence.points[static_cast<size_t>(edgel.point)];
    weights[i] = point.weight;
    values[i] = point.weight * point.residual_px / point.sigma_px * edgel.edge.outward;
  }
  std::array<double, kLags + 1> covariance{}, pairs{};
  for (size_t i = 0; i < count; ++i) {
    for (size_t lag = 0; lag <= kLags; ++lag) {
      covariance[lag] += values[i] * values[i + lag];
      pairs[lag] += weights[i] * weights[i + lag];
    }
  }
  for (size_t lag = 0; lag <= kLags; ++lag) covariance[lag] = pairs[lag] > 0 ? covariance[lag] / pairs[lag] : 0;
  if (covariance[0] == 0) return 1;
  double factor = 1, squares = 0;
  for (size_t lag = 1; lag <= kLags; ++lag) {
    const double taper = 1 - static_cast<double>(lag) / (kLags + 1);
    factor += 2 * taper * covariance[lag] / covariance[0];
    squares += taper * taper;
  }
  // For independent points the sum scatters with this standard deviation, and max(0, sum) has a mean of 0.4 of it:
  // divide by that bias.
  const double by_chance = 2 * std::sqrt(squares / static_cast<double>(count));
  return std::max(1.0, factor) / (1 + 0.4 * by_chance);
}

/// Ratio of the residuals' power at low spatial frequencies along the contour to that of independent residuals. The
/// centre is the first harmonic and the size the zeroth, which the fit takes out: the next ones tell how large the
/// errors were there.
double low_harmonics(const ContourEvidence& evidence) {
  constexpr size_t kFirst = 2, kLast = 5;
  std::array<Eigen::Vector2d, kLast + 1> sums;
  sums.fill(Eigen::Vector2d::Zero());
  double squares = 0, weights = 0, weights2 = 0;
  for (const ContourEdgel& edgel : evidence.edgels) {
    if (edgel.point < 0) continue;
    const ContourPoint& point = evidence.points[static_cast<size_t>(edgel.point)];
    const double z = point.residual_px / point.sigma_px * edgel.edge.outward;
    squares += point.weight * z * z;
    weights += point.weight;
    weights2 += point.weight * point.weight;
    const Eigen::Vector2d& once = edgel.edge.normal;
    Eigen::Vector2d turned = once;
    for (size_t harmonic = kFirst; harmonic <= kLast; ++harmonic) {
      turned =
          Eigen::Vector2d(turned.x() * once.x() - turned.y() * once.y(), turned.x() * once.y() + turned.y() * once.x());
      sums[harmonic] += point.weight * z * turned;
    }
  }
  if (!(squares > 0)) return 1;
  double power = 0;
  for (size_t harmonic = kFirst; harmonic <= kLast; ++harmonic) power += sums[harmonic].squaredNorm();
  return power / (kLast - kFirst + 1) / weights2 / (squares / weights);
}

/// Covariance of n from the noise of the shading's fit.
Eigen::Matrix3d shading_covariance(const ContourEvidence& evidence) {
  // Derivative of n with respect to the shading's coefficients in each channel.
  std::array<Eigen::Matrix<double, 3, Shading::kTerms>, 3> changes;
  for (auto& change : changes) change.setZero();
  for (const ContourEdgel& edgel : evidence.edgels) {
    if (edgel.point < 0) continue;
    const Eigen::Vector3d& pull = evidence.points[static_cast<size_t>(edgel.point)].pull;
    for (int channel = 0; channel < 3; ++channel) {
      changes[static_cast<size_t>(channel)].noalias() +=
          edgel.found.shading_gain[channel] * pull * edgel.found.shading_terms.transpose();
    }
  }
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const auto& change : changes) sum += change * evidence.shading.covariance() * change.transpose();
  return evidence.noise * evidence.noise * evidence.fit.covariance * sum * evidence.fit.covariance.transpose();
}

/// How far errors of the edges, pixels outwards, move (x/z, y/z, s) if all have the same cause.
Eigen::Vector3d moved_by(double Edge::*error_px, const ContourEvidence& evidence) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const ContourEdgel& edgel : evidence.edgels) {
    if (edgel.point < 0) continue;
    sum += edgel.edge.outward * edgel.found.*error_px * evidence.points[static_cast<size_t>(edgel.point)].pull;
  }
  return evidence.fit.cone.jacobian() * evidence.fit.covariance * sum;
}

/// Mean square of the edges' errors of the shading model, px^2.
double mean_shading2(const ContourEvidence& evidence) {
  double sum = 0, weights = 0;
  for (const ContourEdgel& edgel : evidence.edgels) {
    if (edgel.point < 0) continue;
    const ContourPoint& point = evidence.points[static_cast<size_t>(edgel.point)];
    if (point.weight == 0) continue;
    weights += point.weight;
    sum += point.weight * edgel.found.shading_px * edgel.found.shading_px;
  }
  return sum / weights;
}

/// Share of the edges' expected variances that is not of the shading model.
double noise_share_of(const ContourEvidence& evidence) {
  double sum = 0, weights = 0;
  for (const ContourEdgel& edgel : evidence.edgels) {
    if (edgel.point < 0) continue;
    const ContourPoint& point = evidence.points[static_cast<size_t>(edgel.point)];
    weights += point.weight;
    const double share = edgel.found.shading_px / point.sigma_px;
    sum += point.weight * (1 - share * share);
  }
  return weights > 0 ? sum / weights : 1;
}

/// Direction in which the object gets brighter in the image, a unit vector; zero where it is lit from the camera.
Eigen::Vector2d light_direction(const Shading& shading) {
  const auto change = [&](int term) {
    const Shading::Terms along = Shading::Terms::Unit(term);
    return shading.colour(along).sum();
  };
  const Eigen::Vector2d gradient(change(1), change(2));
  constexpr double kLeast = 20;  // grey levels, summed over the channels: less is noise
  const double size = gradient.norm();
  return size > kLeast ? Eigen::Vector2d(gradient / size) : Eigen::Vector2d(0, 0);
}

}  // namespace

ContourCovariance covariance_of(const ContourEvidence& evidence) {
  const ConeFit& fit = evidence.fit;
  constexpr double kPriorPoints = 10;  // weight of the prior that the errors are as large as expected
  // The residuals show how large the errors of the shading model are in this image; the noise is known.
  const double noise_share = noise_share_of(evidence);
  const double observed = (kPriorPoints + fit.points * fit.spread) / (kPriorPoints + fit.points - 3);
  const double spread = std::max(noise_share, observed);
  const double of_shading = std::clamp((observed - noise_share) / std::max(1e-6, 1 - noise_share), kLeastShading, 1.0);
  const Eigen::Matrix3d J = fit.cone.jacobian(), geometry = J * fit.geometry * J.transpose();
  const double agree = 0.5 * (neighbours_agree(evidence) + low_harmonics(evidence));
  // Small contours, and chroma at half resolution, err by more than their edges scatter: few pixels, or whole blocks of
  // them, decide on the model of light and background that all edges use.
  // Beside an occluder, light and background are known on one side only; so are they beside a stripe.
  const double one_sided = evidence.whole ? 1 : kOneSideOnly;
  const Eigen::Vector2d light = light_direction(evidence.shading);
  const bool lit = !light.isZero();
  const double own = evidence.hues_blurred
                         ? (evidence.chroma_known ? kBlocks : kGuessedBlocks) * one_sided
                         : (lit ? kOwnEdges : 1) * std::max(one_sided, 1 + kPainted * evidence.painted);
  const double radius_px = fit.cone.sine() * evidence.focal_px;
  const double of_radius = (evidence.hues_blurred ? kBlockPixels : kFewPixels) / radius_px;
  const double few_pixels = 1 + of_radius * of_radius;
  const Eigen::Matrix3d of_edges =
      few_pixels * own *
      (spread * agree * J * fit.covariance * J.transpose() + J * shading_covariance(evidence) * J.transpose());
  // An error that all edges of one side have moves the centre of a complete contour by as much, and the centre of a
  // partly visible one by more.
  const double blur2 = kModelBlur * kModelBlur * std::max(0.0, evidence.colour_blur2 - kNoBlur);
  ContourCovariance result;
  result.covariance = of_edges + (kModelCentre * kModelCentre + blur2) / 2 * geometry;
  // A shading error equal on all sides changes the size; one that differs between the lit side and the dark one moves
  // the centre along the light, alike in both images.
  const double shading2 = of_shading * mean_shading2(evidence);
  result.covariance(2, 2) += kOneSided * shading2 / 2 * geometry(2, 2);
  const double shared = evidence.hues_blurred ? kSharedBlocks : kSharedEdges;
  const double along2 =
      light.dot((kOneSided * own * shading2 / 2 * geometry + shared * of_edges).topLeftCorner<2, 2>() * light);
  result.shared.col(kLight).head<2>() = std::sqrt(along2) * light;
  result.shared.col(kGammaCurve) = moved_by(&Edge::gamma_px, evidence);
  const Eigen::Vector3d of_gamma = moved_by(&Edge::gamma_rest_px, evidence);
  result.covariance += result.shared * result.shared.transpose() + of_gamma * of_gamma.transpose();
  // A window that holds less than the whole of a blurred edge places it too near to its middle; either end of the image
  // of a moving object, in front of its own background.
  // The measured blur ends where the window does. A faster object's edges do not fit a contour: their residual tells.
  const double blur = evidence.motion.variance;
  const double beyond2 = std::max(0.0, evidence.residual_px * evidence.residual_px - kUsualResidual * kUsualResidual);
  const double faster2 = blur > kFast ? kFaster * kFaster * beyond2 : 0;
  const double moved2 = kMoved * kMoved * blur * blur * blur + faster2;
  const Eigen::Vector2d along = evidence.d_ray_d_pixel * evidence.motion.along;
  result.covariance.topLeftCorner<2, 2>() += moved2 * along * along.transpose();
  result.covariance(2, 2) +=
      (kModelRadius * kModelRadius + kMovedSize * kMovedSize * moved2) / (evidence.focal_px * evidence.focal_px);
  return result;
}

}  // namespace multireach::vision
