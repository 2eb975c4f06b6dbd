#include "vision/contour/disc_measure.hpp"

#include <Eigen/LU>
#include <cmath>
#include <numbers>

namespace multireach::vision {
namespace {

using Along = OutlinePoint::Along;

constexpr int kMostSites = 240;         // of an outline; a larger one is measured at every second, third ... line
constexpr int kSitesBefore = 64;        // likewise, where it is only to be found
constexpr int kMostBorder = 16;         // lines of the blob whose ends the first fit uses, each way
constexpr double kWorstShape = 0.03;    // residual of the radius that an edge fit may have: else it is not a disc ...
constexpr double kSmallResidual = 0.5;  // ... but this is never too much, pixels
constexpr double kLumaEdge = 0.15;      // share of brightness in a difference of colours that suffices to measure it
// What no edge tells: how far the model of the image (blur, shading, lens) is from the truth, pixels.
constexpr double kModelCentre = 0.006, kModelRadius = 0.04, kModelEdge = 0.01;
constexpr double kModelBlur = 0.05;  // share of a blur's width that it may be one-sided by
constexpr double kNoBlur = 0.05;     // px^2: what sharp edges of a shaded ball seem to have

/// Where a closed polygon crosses the rows from `first` on: the smallest and largest column in each.
void cross_rows(const OutlinePolygon& polygon, int row, double& from, double& to) {
  from = 1e9;
  to = -1e9;
  for (size_t k = 0; k < polygon.size(); ++k) {
    const Eigen::Vector2d &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
    if ((a.y() <= row) == (b.y() <= row)) continue;
    const double x = a.x() + (row - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
    from = std::min(from, x);
    to = std::max(to, x);
  }
}

double median_of(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Median {
  double value = 0;
  double sigma = 0;  ///< its standard deviation, by how the values scatter
};

/// Of values from neighbouring edges, of which three share what disturbs them, about.
Median median_with_sigma(std::vector<double>& values) {
  if (values.empty()) return {};
  const double median = median_of(values);
  for (double& value : values) value = std::abs(value - median);
  constexpr double kNormal = 1.4826, kOfMedian = 1.2533, kTogether = 3;
  const double scatter = kNormal * median_of(values);
  return {median, kOfMedian * scatter * std::sqrt(kTogether / static_cast<double>(values.size()))};
}

}  // namespace

void DiscMeasurer::find_extents(const Blob& blob) {
  box_ = blob.box;
  rows_.assign(static_cast<size_t>(box_.height), {box_.br().x, box_.x});
  columns_.assign(static_cast<size_t>(box_.width), {box_.br().y, box_.y});
  const int stride = 1 + (box_.width - 1) / kMostBorder;
  const auto take = [](Extent& extent, int begin, int end) {
    extent.begin = std::min(extent.begin, begin);
    extent.end = std::max(extent.end, end);
  };
  for (const Run& run : blob.runs) {
    take(rows_[static_cast<size_t>(run.row - box_.y)], run.begin, run.end);
    const int first = (run.begin - box_.x + stride - 1) / stride * stride;
    for (int x = first; x < run.end - box_.x; x += stride) take(columns_[static_cast<size_t>(x)], run.row, run.row + 1);
  }
}

OutlinePoint DiscMeasurer::outline_point(double x, double y, Along along, double sigma_px) const {
  const Eigen::Vector2d pixel(x, y);
  return {.ray = ray_of(camera_, pixel, middle_ray_ + d_ray_d_pixel_ * (pixel - middle_px_)),
          .along = along,
          .sigma_px = sigma_px};
}

void DiscMeasurer::find_border_points() {
  points_.clear();
  constexpr double kSigma = 0.5;  // of a mask's border
  const auto add = [this](double x, double y) { points_.push_back(outline_point(x, y, Along::kNormal, kSigma)); };
  const int row_stride = 1 + (box_.height - 1) / kMostBorder, column_stride = 1 + (box_.width - 1) / kMostBorder;
  for (int k = 0; k < box_.height; k += row_stride) {
    const Extent& row = rows_[static_cast<size_t>(k)];
    if (row.end <= row.begin) continue;
    if (row.begin > 0) add(row.begin - 0.5, box_.y + k);
    if (row.end < camera_.width) add(row.end - 0.5, box_.y + k);
  }
  for (int k = 0; k < box_.width; k += column_stride) {
    const Extent& column = columns_[static_cast<size_t>(k)];
    if (column.end <= column.begin) continue;
    if (column.begin > 0) add(box_.x + k, column.begin - 0.5);
    if (column.end < camera_.height) add(box_.x + k, column.end - 0.5);
  }
}

void DiscMeasurer::place_sites(const OutlinePolygon& polygon, double radius_px, int most) {
  sites_.clear();
  const int stride = 1 + static_cast<int>(4 * std::numbers::sqrt2 * radius_px / most);
  double area = 0;
  for (size_t k = 0; k < polygon.size(); ++k) {
    const Eigen::Vector2d &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
    area += a.x() * b.y() - a.y() * b.x();
  }
  const int turn = area > 0 ? 1 : -1;
  for (size_t k = 0; k < polygon.size(); ++k) {
    const Eigen::Vector2d a = polygon[k], d = polygon[(k + 1) % polygon.size()] - a;
    // Along rows where the outline is steep, along columns where it is flat.
    const bool along_row = std::abs(d.y()) >= std::abs(d.x());
    const double from = along_row ? a.y() : a.x(), way = along_row ? d.y() : d.x();
    const double start = along_row ? a.x() : a.y(), slope = (along_row ? d.x() : d.y()) / way;
    const int step = way > 0 ? stride : -stride;
    // The lines in (from, from + way], in the order of the outline.
    int line = static_cast<int>(way > 0 ? std::floor(from) + 1 : std::ceil(from) - 1);
    while (line % stride != 0) line += way > 0 ? 1 : -1;
    for (; way > 0 ? line <= from + way : line >= from + way; line += step) {
      Site site;
      site.edge = {.along_row = along_row,
                   .line = line,
                   .at = start + (line - from) * slope,
                   .outward = (way > 0 ? 1 : -1) * (along_row ? turn : -turn),
                   .cosine = 1 / std::sqrt(1 + slope * slope)};
      site.edge.normal = turn * Eigen::Vector2d(d.y(), -d.x()) / d.norm();
      site.part = k;
      site.length = stride / site.edge.cosine;
      site.profile = sites_.size();
      if (site.profile < profiles_.size()) sites_.push_back(site);
    }
  }
}

void DiscMeasurer::learn_blur() {
  samples_.clear();
  wider_samples_.clear();
  for (const Site& site : sites_) {
    if (site.point < 0 || points_[static_cast<size_t>(site.point)].weight == 0) continue;
    const EdgeBlur blur = blur_of(profiles_[site.profile], site.edge, EdgeModel());
    samples_.push_back(blur.colour2);
    if (blur.luma_share > kLumaEdge) wider_samples_.push_back(blur.colour2 - blur.luma2);
  }
  const Median colour = median_with_sigma(samples_), wider = median_with_sigma(wider_samples_);
  constexpr double kLowResolution = 0.15;  // a third of what halving the hues' resolution adds, about, px^2
  constexpr double kSure = 2;              // standard deviations
  const bool told = 4 * wider_samples_.size() > samples_.size();
  hues_blurred_ = told && wider.value > std::max(kLowResolution, kSure * wider.sigma);
  colour_blur2_ = colour.value;
  luma_blur2_ = colour.value - wider.value;
  if (hues_blurred_) return;
  // A small disc, or one before texture, tells its blur less well than one knows that of usual lenses in focus.
  constexpr double kUsual = 0.1, kUsualSigma = 0.1;  // px^2
  const double usual2 = kUsualSigma * kUsualSigma, sigma2 = colour.sigma * colour.sigma;
  colour_blur2_ = luma_blur2_ = (usual2 * colour.value + sigma2 * kUsual) / (usual2 + sigma2);
}

void DiscMeasurer::learn_parts() {
  std::array<double, kOutlineCorners> fitting{}, all{};
  for (const Site& site : sites_) {
    all[site.part] += 1;
    if (site.point >= 0) fitting[site.part] += points_[static_cast<size_t>(site.point)].weight;
  }
  for (size_t part = 0; part < fits_.size(); ++part) fits_[part] = fitting[part] > 0.5 * all[part];
}

void DiscMeasurer::learn_sides(EdgeModel& model) {
  // How much the background's colour usually changes from pixel to pixel: the median, because some edges are other
  // things' edges.
  samples_.clear();
  NoiseGauge gauge;
  for (Site& site : sites_) {
    if (!site.readable) continue;
    gauge.add(profiles_[site.profile]);
    model.half = site.half;
    samples_.push_back(outside_slope(profiles_[site.profile], model).squaredNorm() / 3);
  }
  if (samples_.empty()) return;
  model.noise = gauge.sigma();
  constexpr double kMedian = 0.79;  // of a third of a chi-squared number of three degrees, about
  model.outside_slope2 = std::max(0.0, median_of(samples_) / kMedian - model.noise * model.noise / 2);
}

void DiscMeasurer::learn_shading(const EdgeModel& model) {
  shading_.clear();
  constexpr size_t kEnough = 64;  // sites
  const size_t stride = 1 + (sites_.size() - 1) / kEnough;
  for (size_t i = 0; i < sites_.size(); i += stride) {
    const Site& site = sites_[i];
    // Beside what hides the ball there are other colours than the ball's.
    if (!site.readable || !fits_[site.part]) continue;
    for (int k = EdgeProfile::kReach; k > site.half; k -= 2)
      shading_.add(surface_normal(profiles_[site.profile], site.edge, model.radius_px, -k),
                   profiles_[site.profile].at(-k));
  }
  shading_.solve();
}

void DiscMeasurer::measure_sites(const cv::Mat& bgr, bool refined, EdgeModel& model) {
  for (Site& site : sites_) site.readable = read_profile(bgr, site.edge, profiles_[site.profile]);
  if (refined) {
    // The narrowest window that holds the edge with its blur.
    constexpr double kSharp = 0.36, kSoft = 1.4;
    const auto half = [](double blur2) { return blur2 < kSharp ? 1 : blur2 < kSoft ? 2 : 3; };
    model.chroma_error = hues_blurred_ ? 0.2 : 0;
    // Where hues are spread wider than brightness there is no one shape.
    model.blur2 = hues_blurred_ || colour_blur2_ > kSoft ? -1 : std::max(0.0, colour_blur2_);
    model.shading_error = std::clamp(0.05 * std::sqrt(20 / model.radius_px), 0.03, 0.15);
    for (Site& site : sites_) {
      if (!site.readable) continue;
      const bool by_luma =
          hues_blurred_ && blur_of(profiles_[site.profile], site.edge, EdgeModel()).luma_share > kLumaEdge;
      site.half = half(by_luma ? luma_blur2_ : colour_blur2_);
    }
    learn_sides(model);
    learn_shading(model);
  } else {
    shading_.clear();
  }
  points_.clear();
  for (Site& site : sites_) {
    site.point = -1;
    if (!site.readable || points_.size() == kMostOutlinePoints) continue;
    model.half = site.half;
    Edge edge;
    bool found = measure_edge(profiles_[site.profile], site.edge, model, shading_, edge);
    // The window is best about the edge.
    for (int again = 0; again < 2 && found && std::abs(edge.at - site.edge.at) > 0.75; ++again) {
      site.edge.at = edge.at;
      found = read_profile(bgr, site.edge, profiles_[site.profile]) &&
              measure_edge(profiles_[site.profile], site.edge, model, shading_, edge);
    }
    if (!found) continue;
    // Mean of the second-order term of a circle over the line's width of one pixel.
    const double cosine = site.edge.cosine;
    edge.at += site.edge.outward / (24 * model.radius_px * cosine * cosine * cosine);
    site.point = static_cast<int>(points_.size());
    site.found = edge;
    const double of_fit2 =
        model.noise * model.noise * edge.shading_gain.squaredNorm() * shading_.variance(edge.shading_terms);
    const double line = site.edge.line,
                 sigma = std::sqrt(edge.sigma_px * edge.sigma_px + edge.shading_px * edge.shading_px + of_fit2 +
                                   kModelEdge * kModelEdge);
    points_.push_back(site.edge.along_row ? outline_point(edge.at, line, Along::kRow, sigma)
                                          : outline_point(line, edge.at, Along::kColumn, sigma));
  }
}

bool DiscMeasurer::fit_edges(const cv::Mat& bgr, DiscMeasurement& result) {
  find_border_points();
  const RobustFit to_border{.trials = 32, .gate_px = 1.0, .largest_px = 2.0, .smallest_share = 0.25};
  auto fit = fit_cone(points_, d_ray_d_pixel_, to_border);
  if (!fit) return false;
  const double focal = std::sqrt(camera_.fx * camera_.fy);
  EdgeModel model;
  constexpr int kPasses = 3;
  for (int pass = 0; pass < kPasses; ++pass) {
    const auto polygon = polygon_of(fit->cone, camera_);
    const double radius_px = fit->cone.sine() * focal;
    if (!polygon || radius_px < 2 || radius_px > 4 * std::max(box_.width, box_.height)) return false;
    place_sites(*polygon, radius_px, pass < kPasses - 1 ? kSitesBefore : kMostSites);
    model.radius_px = radius_px;
    measure_sites(bgr, pass > 0, model);
    RobustFit to_edges{.trials = pass == 0 ? 16 : 0, .gate_px = 0.5, .largest_px = 1.5, .smallest_share = 0.3};
    fit = fit_cone(points_, d_ray_d_pixel_, to_edges, &fit->cone);
    if (!fit) return false;
    if (pass < kPasses - 1) learn_blur();
    learn_parts();
  }
  describe(bgr, *fit, model.noise, result);
  return result.outline_seen >= least_seen_ &&
         result.residual_px < std::max(kSmallResidual, kWorstShape * result.radius_px);
}

double DiscMeasurer::missing_share(const OutlinePolygon& polygon) const {
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
    const Extent& extent = rows_[static_cast<size_t>(row - box_.y)];
    there += std::max(0.0, std::min(to, extent.end - 0.5) - std::max(from, extent.begin - 0.5));
  }
  return all > 0 ? 1 - there / all : 1;
}

double DiscMeasurer::neighbours_agree() const {
  // Neighbours on the outline share what disturbs them (texture, blocks of a JPEG image): then there are fewer
  // independent points than points. The sum of the residuals' autocorrelation says how many fewer.
  constexpr size_t kLags = 12;
  const size_t count = sites_.size();
  std::array<double, kMostOutlinePoints + kLags> weights, values;  // the first ones again at the end
  for (size_t i = 0; i < count + kLags; ++i) {
    const Site& site = sites_[i % count];
    weights[i] = values[i] = 0;
    if (site.point < 0) continue;
    const OutlinePoint& point = points_[static_cast<size_t>(site.point)];
    weights[i] = point.weight;
    values[i] = point.weight * point.residual_px / point.sigma_px * site.edge.outward;
  }
  std::array<double, kLags + 1> covariance{};
  for (size_t lag = 0; lag <= kLags; ++lag) {
    double product = 0, pairs = 0;
    for (size_t i = 0; i < count; ++i) {
      product += values[i] * values[i + lag];
      pairs += weights[i] * weights[i + lag];
    }
    if (pairs > 0) covariance[lag] = product / pairs;
  }
  if (covariance[0] == 0) return 1;
  double factor = 1, squares = 0;
  for (size_t lag = 1; lag <= kLags; ++lag) {
    const double taper = 1 - static_cast<double>(lag) / (kLags + 1);
    factor += 2 * taper * covariance[lag] / covariance[0];
    squares += taper * taper;
  }
  // Of independent points the sum has this standard deviation, and the larger of it and nothing 0.4 of it as its mean.
  const double by_chance = 2 * std::sqrt(squares / static_cast<double>(count));
  return std::max(1.0, factor) / (1 + 0.4 * by_chance);
}

Eigen::Matrix3d DiscMeasurer::shading_covariance(const ConeFit& fit, double noise) const {
  // How n changes with the shading's terms in each channel.
  std::array<Eigen::Matrix<double, 3, Shading::kTerms>, 3> changes;
  for (auto& change : changes) change.setZero();
  for (const Site& site : sites_) {
    if (site.point < 0) continue;
    const Eigen::Vector3d& pull = points_[static_cast<size_t>(site.point)].pull;
    for (int channel = 0; channel < 3; ++channel) {
      changes[static_cast<size_t>(channel)].noalias() +=
          site.found.shading_gain[channel] * pull * site.found.shading_terms.transpose();
    }
  }
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const auto& change : changes) sum += change * shading_.covariance() * change.transpose();
  return noise * noise * fit.covariance * sum * fit.covariance.transpose();
}

void DiscMeasurer::describe(const cv::Mat& bgr, const ConeFit& fit, double noise, DiscMeasurement& result) {
  const double focal = std::sqrt(camera_.fx * camera_.fy);
  const OutlineCone& cone = fit.cone;
  result.value << cone.ray(), cone.sine();
  const LensPoint centre = image_of(camera_, cone.ray());
  result.centre_px = centre.pixel;
  result.radius_px = cone.sine() * focal;

  double seen = 0, all = 0, squares = 0, weights = 0, shading = 0;
  for (const Site& site : sites_) {
    all += site.length;
    const EdgeSite& edge = site.edge;
    const double x = edge.along_row ? edge.at : edge.line, y = edge.along_row ? edge.line : edge.at;
    if (x < -0.5 || y < -0.5 || x > bgr.cols - 0.5 || y > bgr.rows - 0.5) result.cut_off = true;
    if (site.point < 0) continue;
    const OutlinePoint& point = points_[static_cast<size_t>(site.point)];
    if (point.weight == 0) continue;
    seen += site.length;
    squares += point.weight * point.residual_px * point.residual_px;
    weights += point.weight;
    shading += point.weight * site.found.shading_px * site.found.shading_px;
  }
  if (!(all > 0 && weights > 0)) return;
  result.outline_seen = seen / all;
  result.residual_px = std::sqrt(squares / weights);

  // Nothing is hidden where the outline is whole, whatever the blob leaves out. The blob's own border is not exact:
  // what is deeper inside tells.
  constexpr double kWhole = 0.9;
  if (result.outline_seen < kWhole) {
    const double scale = 1 - std::clamp(2 / result.radius_px, 0.1, 0.4);
    if (const auto inner = polygon_of(cone, camera_, scale)) result.hidden = missing_share(*inner);
  }

  constexpr double kPriorPoints = 10;  // that the errors are as large as expected
  const double spread = std::max(1.0, (kPriorPoints + fit.points * fit.spread) / (kPriorPoints + fit.points - 3));
  const Eigen::Matrix3d J = cone.jacobian();
  result.covariance = spread * neighbours_agree() * J * fit.covariance * J.transpose();
  // An error that all edges of one side share moves the centre of a whole outline as far as the edges, and that of a
  // part of an outline further.
  const double blur2 = kModelBlur * kModelBlur * std::max(0.0, colour_blur2_ - kNoBlur);
  // Of the shading's error, what is the same on all sides changes the size, and what alternates the shape: the share of
  // the rest is set by rendered balls and flat discs. Coarse hues err by whole blocks, each on its side.
  const double one_sided = hues_blurred_ ? 1 : 0.4;
  const double shared2 = kModelCentre * kModelCentre + blur2 + one_sided * shading / weights;
  result.covariance += J * (shared2 / 2 * fit.geometry + shading_covariance(fit, noise)) * J.transpose();
  result.covariance(2, 2) += kModelRadius * kModelRadius / (focal * focal);
}

void DiscMeasurer::take_middle(DiscMeasurement& result) const {
  // The middle of what lies between the ends of each row: holes are highlights.
  double area = 0;
  Eigen::Vector2d sum(0, 0);
  Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
  for (int k = 0; k < box_.height; ++k) {
    const Extent& row = rows_[static_cast<size_t>(k)];
    const double length = row.end - row.begin;
    if (length <= 0) continue;
    const double x = 0.5 * (row.begin + row.end - 1) - middle_px_.x(), y = box_.y + k - middle_px_.y();
    area += length;
    sum += length * Eigen::Vector2d(x, y);
    second(0, 0) += length * (x * x + length * length / 12);
    second(0, 1) += length * x * y;
    second(1, 1) += length * (y * y + 1.0 / 12);
  }
  second(1, 0) = second(0, 1);
  const Eigen::Vector2d mean = sum / area;
  second = second / area - mean * mean.transpose();
  const double focal = std::sqrt(camera_.fx * camera_.fy);

  result.kind = DiscMeasurement::Kind::kCentroid;
  result.centre_px = middle_px_ + mean;
  result.radius_px = std::sqrt(area / std::numbers::pi);
  const Eigen::Vector2d ray = ray_of(camera_, result.centre_px, middle_ray_);
  result.value << ray, result.radius_px / focal;
  // The middle of what is seen is that of the object to about a tenth of its half axes (twice the root of the second
  // moments), and to half a pixel; what the size says is that it is about so.
  constexpr double kShare = 0.2, kBorder = 0.5, kSize = 0.3;
  const Eigen::Matrix2d spread = kShare * kShare * second + kBorder * kBorder * Eigen::Matrix2d::Identity();
  result.covariance.setZero();
  result.covariance.topLeftCorner<2, 2>() = d_ray_d_pixel_ * spread * d_ray_d_pixel_.transpose();
  const double sigma_size = kSize * result.value.z() + kBorder / focal;
  result.covariance(2, 2) = sigma_size * sigma_size;
  result.cut_off = box_.x == 0 || box_.y == 0 || box_.br().x == camera_.width || box_.br().y == camera_.height;
}

DiscMeasurement DiscMeasurer::measure(const cv::Mat& bgr, const Blob& blob) {
  DiscMeasurement result;
  find_extents(blob);
  middle_px_ = Eigen::Vector2d(box_.x + 0.5 * (box_.width - 1), box_.y + 0.5 * (box_.height - 1));
  const Eigen::Vector2d pinhole((middle_px_.x() - camera_.cx) / camera_.fx, (middle_px_.y() - camera_.cy) / camera_.fy);
  middle_ray_ = ray_of(camera_, middle_px_, pinhole);
  d_ray_d_pixel_ = image_of(camera_, middle_ray_).d_pixel_d_ray.inverse();
  if (fit_edges(bgr, result)) {
    result.kind = DiscMeasurement::Kind::kEdges;
  } else {
    // What hides a part of a disc is known of what is known to be one.
    if (least_seen_ > kOfASphere) result = {};
    take_middle(result);
  }
  result.area = blob.area;
  return result;
}

}  // namespace multireach::vision
