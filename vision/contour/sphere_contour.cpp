#include "vision/contour/sphere_contour.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "numeric/median.hpp"
#include "numeric/trigonometry.hpp"
#include "vision/contour/contour_covariance.hpp"
#include "vision/contour/measure_edges.hpp"

namespace multireach::vision {
namespace {

using Along = ContourPoint::Along;

constexpr int kMaxEdgels = 240;       // edgels per contour; a larger one is measured at every second, third ... line
constexpr int kEdgelsBefore = 64;     // edgels in the passes before the last one
constexpr int kMaxBorder = 16;        // rows, and columns, of the blob whose ends the first fit uses
constexpr double kLumaEdge = 0.15;    // smallest brightness share of a colour difference for measuring luma blur
constexpr double kModelEdge = 0.01;   // error of the image model at an edge, pixels
constexpr double kPaintedEdge = 0.5;  // the same, where the surface beside it has another colour than most of it
constexpr double kMovedShare = 0.25;  // of the variance from a moved contour's distance to the blob's centroid

struct Median {
  double value = 0, sigma = 0;  // and its standard deviation, from the scatter of the values
};

/// Median of values from neighbouring edges. Errors are taken as common to about three neighbours (kTogether).
Median median_with_sigma(std::vector<double>& values) {
  if (values.empty()) return {};
  const double median = median_of(values);
  for (double& value : values) value = std::abs(value - median);
  constexpr double kNormal = 1.4826, kOfMedian = 1.2533, kTogether = 3;
  const double scatter = kNormal * median_of(values);
  return {median, kOfMedian * scatter * std::sqrt(kTogether / static_cast<double>(values.size()))};
}

}  // namespace

// Sharp images of smooth balls, as rendered ones; then those of real balls: fabric, chroma at half resolution and some
// motion make their edges soft, and learned colours make their blobs smaller than they are.
const SphereContourFitter::Search SphereContourFitter::kSharp{.usual_blur2 = 0.1, .small_residual = 0.5};
const SphereContourFitter::Search SphereContourFitter::kSoft{
    .reach_px = 3, .larger_px = 2, .usual_blur2 = 0.5, .small_residual = 0.7};

void SphereContourFitter::find_extents(const Blob& blob) {
  box_ = blob.box;
  rows_.assign(static_cast<size_t>(box_.height), {box_.br().x, box_.x});
  columns_.assign(static_cast<size_t>(box_.width), {box_.br().y, box_.y});
  const int stride = 1 + (box_.width - 1) / kMaxBorder;
  const auto take = [](BlobExtent& extent, int begin, int end) {
    extent.begin = std::min(extent.begin, begin);
    extent.end = std::max(extent.end, end);
  };
  for (const Run& run : blob.runs) {
    take(rows_[static_cast<size_t>(run.row - box_.y)], run.begin, run.end);
    const int first = (run.begin - box_.x + stride - 1) / stride * stride;
    for (int x = first; x < run.end - box_.x; x += stride) take(columns_[static_cast<size_t>(x)], run.row, run.row + 1);
  }
}

/// Adds a point without its ray.
void SphereContourFitter::add_point(double x, double y, Along along, double sigma_px) {
  points_.push_back({.ray = {0, 0}, .along = along, .sigma_px = sigma_px});
  pixels_.emplace_back(x, y);
}

void SphereContourFitter::find_rays() {
  rays_.clear();
  for (const Eigen::Vector2d& pixel : pixels_) rays_.emplace_back(middle_ray_ + d_ray_d_pixel_ * (pixel - middle_px_));
  rays_of(camera_, pixels_, rays_);
  for (size_t k = 0; k < points_.size(); ++k) points_[k].ray = rays_[k];
}

void SphereContourFitter::clear_points() {
  points_.clear();
  pixels_.clear();
}

void SphereContourFitter::find_border_points() {
  clear_points();
  constexpr double kSigma = 0.5;  // px, standard deviation of a mask's border
  const auto add = [this](double x, double y) { add_point(x, y, Along::kNormal, kSigma); };
  const int row_stride = 1 + (box_.height - 1) / kMaxBorder, column_stride = 1 + (box_.width - 1) / kMaxBorder;
  for (int k = 0; k < box_.height; k += row_stride) {
    const BlobExtent& row = rows_[static_cast<size_t>(k)];
    if (row.end <= row.begin) continue;
    if (row.begin > readable_.x) add(row.begin - 0.5, box_.y + k);
    if (row.end < readable_.br().x) add(row.end - 0.5, box_.y + k);
  }
  for (int k = 0; k < box_.width; k += column_stride) {
    const BlobExtent& column = columns_[static_cast<size_t>(k)];
    if (column.end <= column.begin) continue;
    if (column.begin > readable_.y) add(box_.x + k, column.begin - 0.5);
    if (column.end < readable_.br().y) add(box_.x + k, column.end - 0.5);
  }
  find_rays();
}

template <class Chosen>
void SphereContourFitter::choose_edgels(const Chosen& chosen) {
  chosen_.clear();
  for (size_t k = 0; k < edgels_.size(); ++k) {
    if (std::invoke(chosen, edgels_[k])) chosen_.push_back(static_cast<int>(k));
  }
}

void SphereContourFitter::learn_blur(const Search& search) {
  choose_edgels([&](const ContourEdgel& edgel) {
    return edgel.point >= 0 && points_[static_cast<size_t>(edgel.point)].weight != 0;
  });
  measure_blur(chosen_, profiles_, edgels_);
  samples_.clear();
  wider_samples_.clear();
  for (const int k : chosen_) {
    const ContourEdgel& edgel = edgels_[static_cast<size_t>(k)];
    samples_.push_back(edgel.blur.colour2);
    if (edgel.blur.luma_share > kLumaEdge) wider_samples_.push_back(edgel.blur.colour2 - edgel.blur.luma2);
  }
  const Median colour = median_with_sigma(samples_), wider = median_with_sigma(wider_samples_);
  constexpr double kLowResolution = 0.15, kSure = 2;  // px^2, a third of what halved chroma adds; standard deviations
  const bool told = 4 * wider_samples_.size() > samples_.size();
  hues_blurred_ = chroma_subsampled_ || (told && wider.value > std::max(kLowResolution, kSure * wider.sigma));
  colour_blur2_ = colour.value;
  luma_blur2_ = colour.value - wider.value;
  if (hues_blurred_) return;
  // Fuse with a prior, the blur of usual lenses in focus: small contours and textured backgrounds measure blur poorly.
  const double usual = search.usual_blur2, usual2 = usual * usual, sigma2 = colour.sigma * colour.sigma;
  colour_blur2_ = luma_blur2_ = (usual2 * colour.value + sigma2 * usual) / (usual2 + sigma2);
}

void SphereContourFitter::learn_parts() {
  std::array<double, kContourCorners> fitting{}, all{};
  for (const ContourEdgel& edgel : edgels_) {
    all[edgel.part] += 1;
    if (edgel.point >= 0) fitting[edgel.part] += points_[static_cast<size_t>(edgel.point)].weight;
  }
  for (size_t part = 0; part < fits_.size(); ++part) fits_[part] = fitting[part] > 0.5 * all[part];
}

void SphereContourFitter::learn_sides(EdgeModel& model) {
  samples_.clear();  // the background's slopes; their median, because some of them contain other edges
  NoiseEstimator noise_estimator;
  for (ContourEdgel& edgel : edgels_) {
    if (!edgel.readable) continue;
    noise_estimator.add(profiles_[edgel.profile]);
    samples_.push_back(outside_slope(profiles_[edgel.profile], edgel.half).squaredNorm() / 3);
  }
  if (samples_.empty()) return;
  model.noise = noise_estimator.sigma();
  constexpr double kMedian = 0.79;  // about the median of chi^2 / 3 with three degrees of freedom
  model.outside_slope2 = std::max(0.0, median_of(samples_) / kMedian - model.noise * model.noise / 2);
}

void SphereContourFitter::learn_shading(const EdgeModel& model) {
  constexpr size_t kEnough = 64;  // edgels to sample, at most about
  const size_t stride = 1 + (edgels_.size() - 1) / kEnough;
  chosen_.clear();
  for (size_t i = 0; i < edgels_.size(); i += stride) {
    // Next to an occluder, the pixels inside the contour are not the ball's.
    if (edgels_[i].readable && fits_[edgels_[i].part]) chosen_.push_back(static_cast<int>(i));
  }
  read_surface(chosen_, profiles_, model.radius_px, edgels_, surface_);
  // A small contour has too few pixels to tell paint from shading; blur mixes the surface with what is around it.
  constexpr double kSharpEnough = 1, kStillEnough = 0.6;  // px^2
  const bool plain = model.radius_px < kLargeEnough || colour_blur2_ > kSharpEnough || motion_.variance > kStillEnough;
  shading_.fit(surface_, plain);
}

/// Uses the narrowest window that holds each blurred edge.
void SphereContourFitter::choose_windows(EdgeModel& model) {
  constexpr double kNarrow = 0.36, kWide = 1.4;
  const auto half = [](double blur2) { return blur2 < kNarrow ? 1 : blur2 < kWide ? 2 : 3; };
  model.chroma_error = hues_blurred_ ? 0.2 : 0;
  // With subsampled chroma, luma and chroma have different blurs: no single edge shape fits.
  model.blur2 = hues_blurred_ || colour_blur2_ > kWide ? -1 : std::max(0.0, colour_blur2_);
  model.shading_error = std::clamp(0.05 * std::sqrt(20 / model.radius_px), 0.03, 0.15);
  choose_edgels(&ContourEdgel::readable);
  if (hues_blurred_) measure_blur(chosen_, profiles_, edgels_);
  for (const int k : chosen_) {
    ContourEdgel& edgel = edgels_[static_cast<size_t>(k)];
    const bool by_luma = hues_blurred_ && edgel.blur.luma_share > kLumaEdge;
    edgel.half = half(by_luma ? luma_blur2_ : colour_blur2_);
  }
}

/// Measures the edges at their expected positions or, where there is none, at the nearest one within the search's
/// reach.
void SphereContourFitter::find_edges(const cv::Mat& bgr, const EdgeModel& model, const Search& search) {
  const auto measure = [&] { measure_edges(chosen_, profiles_, model, shading_.shading(), edgels_); };
  // Measures an edgel at another position, if its pixels can be read there, the next time.
  const auto move = [&](size_t k, double at) {
    ContourEdgel& edgel = edgels_[k];
    edgel.edge.at = at;
    edgel.is_edge = false;
    if (read_profile(bgr, readable_, edgel.edge, profiles_[edgel.profile])) chosen_.push_back(static_cast<int>(k));
  };
  choose_edgels(&ContourEdgel::readable);
  measure();
  for (ContourEdgel& edgel : edgels_) edgel.expected = edgel.edge.at;
  for (int away = 1; away <= search.reach_px; ++away) {
    for (const int side : {away, -away}) {
      chosen_.clear();
      for (size_t k = 0; k < edgels_.size(); ++k) {
        if (edgels_[k].readable && !edgels_[k].is_edge) move(k, edgels_[k].expected + side);
      }
      measure();
    }
  }
  constexpr double kCentred = 0.75;  // pixels between the edge and the middle of its window
  for (int again = 0; again < 2; ++again) {
    chosen_.clear();
    for (size_t k = 0; k < edgels_.size(); ++k) {
      const ContourEdgel& edgel = edgels_[k];
      if (edgel.is_edge && std::abs(edgel.found.at - edgel.edge.at) > kCentred) move(k, edgel.found.at);
    }
    measure();
  }
}

void SphereContourFitter::find_paint(const EdgeModel& model) {
  if (!shading_.shading().known()) return;
  choose_edgels(&ContourEdgel::readable);
  mark_painted(chosen_, profiles_, shading_.shading(), model.radius_px, shading_.most_apart(model.noise), edgels_);
}

/// Share of the contour's length whose surface is painted; `missing`: of that without an edge.
double SphereContourFitter::painted_share(bool missing) const {
  double all = 0, share = 0;
  for (const ContourEdgel& edgel : edgels_) {
    all += edgel.length;
    if (missing && edgel.point >= 0 && points_[static_cast<size_t>(edgel.point)].weight > 0) continue;
    if (edgel.painted) share += edgel.length;
  }
  return all > 0 ? share / all : 0;
}

void SphereContourFitter::measure_edgels(const cv::Mat& bgr, bool refined, const Search& search, EdgeModel& model) {
  for (ContourEdgel& edgel : edgels_)
    edgel.readable = read_profile(bgr, readable_, edgel.edge, profiles_[edgel.profile]);
  if (refined) {
    choose_windows(model);
    learn_sides(model);
    learn_shading(model);
  } else {
    shading_.clear();
  }
  find_edges(bgr, model, search);
  find_paint(model);
  clear_points();
  for (ContourEdgel& edgel : edgels_) {
    edgel.point = -1;
    if (!edgel.is_edge) continue;
    Edge& edge = edgel.found;
    // Correct for the contour's curvature: the mean of the circle's second-order term over the line's width of 1 px.
    const double cosine = edgel.edge.cosine;
    edge.at += edgel.edge.outward / (24 * model.radius_px * cosine * cosine * cosine);
    if (refined) gamma_shift_.correct(colour_blur2_, hues_blurred_, edgel);
    edgel.point = static_cast<int>(points_.size());
    const double of_fit2 =
        model.noise * model.noise * edge.shading_gain.squaredNorm() * shading_.shading().variance(edge.shading_terms);
    const double line = edgel.edge.line, of_paint = edgel.painted ? kPaintedEdge : 0,
                 sigma = std::sqrt(edge.sigma_px * edge.sigma_px + edge.shading_px * edge.shading_px + of_fit2 +
                                   kModelEdge * kModelEdge + of_paint * of_paint);
    if (edgel.edge.along_row) {
      add_point(edge.at, line, Along::kRow, sigma);
    } else {
      add_point(line, edge.at, Along::kColumn, sigma);
    }
  }
  find_rays();
}

ContourVerdict SphereContourFitter::fit_edges(const cv::Mat& bgr, const Blob& blob, const Search& search,
                                              SphereContour& result) {
  find_border_points();
  const RobustFit to_border{.trials = 32, .gate_px = 1.0, .largest_px = 2.0, .smallest_share = 0.25};
  auto fit = fit_cone(points_, d_ray_d_pixel_, to_border);
  if (!fit) return ContourVerdict::kNothing;
  const double focal = camera_.focal_px();
  if (search.larger_px > 0) {
    const double sine = std::min(0.8, fit->cone.sine() + search.larger_px / focal);
    fit->cone.n = fit->cone.n.normalized() / std::sqrt(1 - sine * sine);
  }
  EdgeModel model;
  constexpr int kPasses = 3;
  for (int pass = 0; pass < kPasses; ++pass) {
    const auto polygon = polygon_of(fit->cone, camera_);
    const double radius_px = fit->cone.sine() * focal;
    if (!polygon || radius_px < 2 || radius_px > 4 * std::max(box_.width, box_.height)) return ContourVerdict::kNothing;
    place_edgels(*polygon, radius_px, pass < kPasses - 1 ? kEdgelsBefore : kMaxEdgels, edgels_);
    model.radius_px = radius_px;
    measure_edgels(bgr, pass > 0, search, model);
    RobustFit to_edges{.trials = pass == 0 ? 16 : 0, .gate_px = 0.5, .largest_px = 1.5, .smallest_share = 0.3};
    fit = fit_cone(points_, d_ray_d_pixel_, to_edges, &fit->cone);
    if (!fit) return ContourVerdict::kNothing;
    learn_parts();
    if (pass == kPasses - 1) break;
    learn_blur(search);
    motion_ = motion_blur_of(edgels_, points_);
  }
  const double seen_inside = describe(*fit, model.noise, result);
  result.motion_px = motion_.length_px();
  const auto polygon = polygon_of(fit->cone, camera_);
  const ContourVerdict verdict = verdict_on({.radius_px = result.radius_px,
                                             .residual_px = result.residual_px,
                                             .visible_fraction = result.visible_fraction,
                                             .seen_inside = seen_inside,
                                             .painted_missing = painted_share(true),
                                             .occlusion = result.occlusion,
                                             .cut_off = result.cut_off,
                                             .blob_length = polygon ? half_length(blob) / half_length(*polygon) : 0,
                                             .motion_blur2 = motion_.variance},
                                            least_seen_, search.small_residual);
  if (verdict != ContourVerdict::kContradicted) return verdict;
  result.occlusion = SphereContour::kUnknown;
  return ContourVerdict::kNothing;
}

double SphereContourFitter::occluded_fraction(const ContourPolygon& polygon) const {
  double lowest = 1e9, highest = -1e9;
  for (const Eigen::Vector2d& corner : polygon) {
    lowest = std::min(lowest, corner.y());
    highest = std::max(highest, corner.y());
  }
  double all = 0, there = 0;
  for (int row = static_cast<int>(std::ceil(lowest)); row <= highest; ++row) {
    double from, to;
    cross_rows(polygon, row, from, to);
    if (!(to > from)) continue;
    all += to - from;
    if (row < box_.y || row >= box_.br().y) continue;
    const BlobExtent& extent = rows_[static_cast<size_t>(row - box_.y)];
    there += std::max(0.0, std::min(to, extent.end - 0.5) - std::max(from, extent.begin - 0.5));
  }
  return all > 0 ? 1 - there / all : 1;
}

double SphereContourFitter::describe(const ConeFit& fit, double noise, SphereContour& result) {
  const double focal = camera_.focal_px();
  const ContourCone& cone = fit.cone;
  result.value << cone.ray(), cone.sine();
  const LensPoint centre = image_of(camera_, cone.ray());
  result.centre_px = centre.pixel;
  result.radius_px = cone.sine() * focal;

  double seen = 0, inside = 0, all = 0, squares = 0, weights = 0;
  for (const ContourEdgel& edgel : edgels_) {
    all += edgel.length;
    if (edgel.readable) inside += edgel.length;
    const Edgel& edge = edgel.edge;
    const double x = edge.along_row ? edge.at : edge.line, y = edge.along_row ? edge.line : edge.at;
    const cv::Point first = readable_.tl(), end = readable_.br();
    if (x < first.x - 0.5 || y < first.y - 0.5 || x > end.x - 0.5 || y > end.y - 0.5) result.cut_off = true;
    if (edgel.point < 0) continue;
    const ContourPoint& point = points_[static_cast<size_t>(edgel.point)];
    if (point.weight == 0) continue;
    seen += edgel.length;
    squares += point.weight * point.residual_px * point.residual_px;
    weights += point.weight;
  }
  if (!(inside > 0 && weights > 0)) return 0;
  result.visible_fraction = seen / all;
  result.residual_px = std::sqrt(squares / weights);
  // A complete contour means no occlusion, even where the blob has holes. The blob's border is not exact, so occlusion
  // is measured on a contour scaled down.
  constexpr double kWhole = 0.9;
  if (result.visible_fraction < kWhole) {
    const double scale = 1 - std::clamp(2 / result.radius_px, 0.1, 0.4);
    if (const auto inner = polygon_of(cone, camera_, scale)) result.occlusion = occluded_fraction(*inner);
    // Whatever hides a part of a disc hides a larger share of its contour than of its area. Where the blob lacks more,
    // the object's colours were not all learned.
    result.occlusion = std::min(result.occlusion, 1 - result.visible_fraction);
  }

  const ContourCovariance errors = covariance_of({.edgels = edgels_,
                                                  .points = points_,
                                                  .fit = fit,
                                                  .shading = shading_.shading(),
                                                  .noise = noise,
                                                  .focal_px = focal,
                                                  .d_ray_d_pixel = d_ray_d_pixel_,
                                                  .whole = result.visible_fraction >= kWhole,
                                                  .painted = painted_share(false),
                                                  .hues_blurred = hues_blurred_,
                                                  .chroma_known = chroma_subsampled_,
                                                  .colour_blur2 = colour_blur2_,
                                                  .residual_px = result.residual_px,
                                                  .motion = motion_});
  result.covariance = errors.covariance;
  result.shared = errors.shared;
  return seen / inside;
}

void SphereContourFitter::use_centroid(SphereContour& result) const {
  const BlobCentre centre = centre_of(rows_, box_, readable_, middle_px_);
  const double focal = camera_.focal_px();
  result.kind = SphereContour::Kind::kCentroid;
  result.centre_px = middle_px_ + centre.px;
  result.radius_px = centre.radius_px;
  const Eigen::Vector2d ray = ray_of(camera_, result.centre_px, middle_ray_);
  result.value << ray, result.radius_px / focal;
  result.covariance.setZero();
  result.shared.setZero();
  result.shared.col(kShape).head<2>() = d_ray_d_pixel_ * centre.shape_sigma;
  result.covariance.topLeftCorner<2, 2>() = d_ray_d_pixel_ * centre.covariance * d_ray_d_pixel_.transpose();
  result.alternative_spread = d_ray_d_pixel_ * centre.occlusion_covariance * d_ray_d_pixel_.transpose();
  constexpr double kSize = 0.3, kPixel = 0.5;  // the size is a rough estimate
  const double sigma_size = kSize * result.value.z() + kPixel / focal;
  result.covariance(2, 2) = sigma_size * sigma_size;
  result.cut_off = centre.cut_off;
  // What only the searched part of the image cuts off is not where it is looked for.
  const bool in_image = (box_.x > readable_.x || readable_.x == 0) && (box_.y > readable_.y || readable_.y == 0) &&
                        (box_.br().x < readable_.br().x || readable_.br().x == camera_.width) &&
                        (box_.br().y < readable_.br().y || readable_.br().y == camera_.height);
  if (centre.cut_off)
    result.occlusion = in_image ? std::max(result.occlusion, centre.cut_off_share) : BlobCentre::kNotLocated;
}

SphereContour SphereContourFitter::fit(const cv::Mat& bgr, const Blob& blob, const cv::Rect& readable,
                                       bool chroma_subsampled) {
  SphereContour result;
  chroma_subsampled_ = chroma_subsampled;
  readable_ = readable;
  find_extents(blob);
  middle_px_ = Eigen::Vector2d(box_.x + 0.5 * (box_.width - 1), box_.y + 0.5 * (box_.height - 1));
  const Eigen::Vector2d pinhole((middle_px_.x() - camera_.cx) / camera_.fx, (middle_px_.y() - camera_.cy) / camera_.fy);
  middle_ray_ = ray_of(camera_, middle_px_, pinhole);
  d_ray_d_pixel_ = image_of(camera_, middle_ray_).d_pixel_d_ray.inverse();
  ContourVerdict verdict = fit_edges(bgr, blob, kSharp, result);
  if (verdict != ContourVerdict::kAccepted) {
    SphereContour second;
    const ContourVerdict of_second = fit_edges(bgr, blob, kSoft, second);
    if (of_second > verdict) result = second;
    verdict = std::max(verdict, of_second);
  }
  if (verdict == ContourVerdict::kAccepted) {
    SphereContour centroid{.occlusion = SphereContour::kUnknown};
    use_centroid(centroid);
    centroid.area = blob.area;
    result.kind = SphereContour::Kind::kEdges;
    result.from_centroid = result.value - centroid.value;
    if (result.visible_fraction < kOfAnything) result.by_centroid = std::make_shared<SphereContour>(centroid);
    // A part of the contour of an object that need not be a sphere: an arc of an ellipse fits a circle elsewhere.
    if (result.cut_off && least_seen_ > kOfASphere) {
      result.shared.col(kShape) = result.from_centroid;
      result.covariance += result.from_centroid * result.from_centroid.transpose();
    }
    // The ends of a moved object have no sharp edges: the blob's centroid, which they do not mislead, tells how far the
    // contour may be off.
    if (motion_.variance > kMovedBlur2)
      result.covariance += kMovedShare * result.from_centroid * result.from_centroid.transpose();
  } else {
    const SphereContour part = result;
    // Occlusion is meaningful only for objects known to be spheres.
    if (least_seen_ > kOfASphere || part.visible_fraction == 0) result = {.occlusion = SphereContour::kUnknown};
    use_centroid(result);
    if (blob.alternative_area > 0) {
      result.alternative_spread += d_ray_d_pixel_ * blob.alternative_spread * d_ray_d_pixel_.transpose();
      result.alternative_size = std::sqrt(blob.alternative_area / blob.area) * result.value.z();
    }
    if (verdict == ContourVerdict::kPart) {
      // Either this is the whole object, or the arc belongs to a ball that is partly occluded, alike in both images.
      result.shared.col(kOccluded) = part.value - result.value;
      result.covariance += result.shared.col(kOccluded) * result.shared.col(kOccluded).transpose();
    }
  }
  result.area = blob.area;
  return result;
}

}  // namespace multireach::vision
