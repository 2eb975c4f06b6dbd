#include "tools/calibrate/colour_region.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "vision/colour/blob.hpp"
#include "vision/colour/colour_model.hpp"

namespace multireach {
namespace {

using Feature = Eigen::Vector3d;  // chroma U, V and the logarithm of Y

constexpr int kStart = 3;         // pixels, half size of the patch around the click
constexpr double kOfStart = 0.5;  // least share of the patch that a region contains
constexpr double kDrift = 0.2;    // of the mean chroma from that of the patch: farther away it is another colour
// Share of the image: a larger region is not one object; one that reaches the image's border may be the background.
// Both are choices: most objects cover a few per cent.
constexpr double kLargest = 0.25, kLargestAtBorder = 0.1;
constexpr double kMostPixels = 2.5e6;  // of an image; the region is looked for in a smaller one of larger images

/// The features of all pixels of an image.
class Features {
 public:
  explicit Features(const cv::Mat& bgr) : columns_(bgr.cols), of_(static_cast<size_t>(bgr.cols) * bgr.rows) {
    cv::Mat smooth;
    cv::GaussianBlur(bgr, smooth, {3, 3}, 0);
    for (int row = 0; row < bgr.rows; ++row) {
      for (int column = 0; column < bgr.cols; ++column) {
        const auto& p = smooth.at<cv::Vec3b>(row, column);
        // An offset keeps the chroma of dark pixels small, which is mostly noise.
        constexpr double kOffset = 8;
        const Rgb rgb{p[2] + kOffset, p[1] + kOffset, p[0] + kOffset};
        const Eigen::Vector2d chroma = vision::chroma_of(rgb);
        of_[index(row, column)] = {chroma.x(), chroma.y(), std::log(vision::luma_of(rgb))};
      }
    }
  }
  const Feature& at(int row, int column) const { return of_[index(row, column)]; }

 private:
  size_t index(int row, int column) const { return static_cast<size_t>(row) * columns_ + column; }
  int columns_;
  std::vector<Feature> of_;
};

/// A normal distribution of features.
struct Distribution {
  Feature mean;
  Eigen::Matrix3d covariance, information;

  Distribution(const Features& features, const cv::Mat& mask) : mean(Feature::Zero()) {
    covariance.setZero();
    double pixels = 0;
    const auto each = [&](const auto& visit) {
      for (int row = 0; row < mask.rows; ++row) {
        for (int column = 0; column < mask.cols; ++column) {
          if (mask.at<uint8_t>(row, column) != 0) visit(features.at(row, column));
        }
      }
    };
    each([&](const Feature& f) {
      mean += f;
      ++pixels;
    });
    mean /= pixels;
    each([&](const Feature& f) { covariance += (f - mean) * (f - mean).transpose() / pixels; });
    // A few pixels do not show how much an object's colours vary; shading varies its brightness most.
    const Feature usual(0.06, 0.06, 0.2);
    covariance.diagonal() += usual.cwiseAbs2();
    information = covariance.inverse();
  }
  double distance2(const Feature& f) const { return (f - mean).dot(information * (f - mean)); }
};

/// The region with its holes filled: highlights and marks leave holes.
cv::Mat filled(const cv::Mat& region) {
  cv::Mat without_holes = cv::Mat::zeros(region.size(), CV_8UC1);
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(region.clone(), contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  cv::drawContours(without_holes, contours, -1, cv::Scalar::all(255), cv::FILLED);
  return without_holes;
}

/// The connected component of `mask` that contains the point nearest to the click.
cv::Mat component_at(const cv::Mat& mask, const cv::Point& click) {
  cv::Mat labels;
  cv::connectedComponents(mask, labels, 4, CV_32S);
  int label = 0;
  double nearest = 1e9;
  constexpr int kReach = 6;
  for (int row = std::max(0, click.y - kReach); row < std::min(mask.rows, click.y + kReach + 1); ++row) {
    for (int column = std::max(0, click.x - kReach); column < std::min(mask.cols, click.x + kReach + 1); ++column) {
      const double distance = std::hypot(row - click.y, column - click.x);
      if (labels.at<int>(row, column) == 0 || distance >= nearest) continue;
      nearest = distance;
      label = labels.at<int>(row, column);
    }
  }
  return label > 0 ? cv::Mat(labels == label) : cv::Mat::zeros(mask.size(), CV_8UC1);
}

/// The largest share of the image that a region like this may have.
double largest_share(const cv::Mat& region) {
  const int at_border = cv::countNonZero(region.row(0)) + cv::countNonZero(region.row(region.rows - 1)) +
                        cv::countNonZero(region.col(0)) + cv::countNonZero(region.col(region.cols - 1));
  return at_border > 0 ? kLargestAtBorder : kLargest;
}

/// Contrast at the border of a region: the level that seven tenths of the border exceed. A region that leaks into its
/// surroundings, or is only a part of the object, has a border without contrast somewhere.
double border_contrast(const cv::Mat& gradient, const cv::Mat& region) {
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(region.clone(), contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  std::vector<float> levels;
  for (const auto& contour : contours) {
    for (const cv::Point& point : contour) levels.push_back(gradient.at<float>(point));
  }
  if (levels.empty()) return 0;
  const auto at = levels.begin() + static_cast<ptrdiff_t>(levels.size() * 3 / 10);
  std::ranges::nth_element(levels, at);
  return *at;
}

/// The region's share of its convex hull: small for a region that leaks.
double solidity(const cv::Mat& region) {
  std::vector<cv::Point> pixels, hull;
  cv::findNonZero(region, pixels);
  cv::convexHull(pixels, hull);
  const double border = 0.5 * cv::arcLength(hull, true);  // the hull's corners are the centres of pixels
  return std::min(1.0, static_cast<double>(pixels.size()) / (cv::contourArea(hull) + border + 1));
}

/// The steepest change of any channel within two pixels.
cv::Mat gradient_of(const cv::Mat& bgr) {
  cv::Mat smooth, dx, dy, steepest = cv::Mat::zeros(bgr.size(), CV_32F);
  cv::GaussianBlur(bgr, smooth, {3, 3}, 0);
  cv::Sobel(smooth, dx, CV_32F, 1, 0);
  cv::Sobel(smooth, dy, CV_32F, 0, 1);
  for (int channel = 0; channel < 3; ++channel) {
    cv::Mat x, y, length;
    cv::extractChannel(dx, x, channel);
    cv::extractChannel(dy, y, channel);
    cv::magnitude(x, y, length);
    steepest = cv::max(steepest, length);
  }
  cv::dilate(steepest, steepest, cv::getStructuringElement(cv::MORPH_ELLIPSE, {5, 5}));
  return steepest;
}

/// How well a region is set off: of regions with a border of equal contrast, the most compact and the largest.
double score_of(const cv::Mat& gradient, const cv::Mat& region) {
  return border_contrast(gradient, region) * std::pow(solidity(region), 2) * std::pow(cv::countNonZero(region), 0.1);
}

/// Grows regions from a patch around the click, with several limits of similarity, and returns the one with the border
/// of highest contrast.
cv::Mat grown(const cv::Mat& bgr, const Features& features, const cv::Mat& gradient, const cv::Point& click) {
  const cv::Rect whole({0, 0}, bgr.size());
  const cv::Rect start = cv::Rect(click.x - kStart, click.y - kStart, 2 * kStart + 1, 2 * kStart + 1) & whole;
  cv::Mat patch = cv::Mat::zeros(bgr.size(), CV_8UC1), best = patch;
  patch(start) = 255;
  best = patch;
  const Distribution clicked(features, patch);
  double best_score = 0;
  constexpr int kRounds = 4;
  for (const double sigmas : {3.0, 2.5, 2.0, 1.5}) {
    cv::Mat region = patch;
    for (int round = 0; round < kRounds; ++round) {
      const Distribution colours(features, region);
      cv::Mat near = cv::Mat::zeros(bgr.size(), CV_8UC1);
      for (int row = 0; row < near.rows; ++row) {
        for (int column = 0; column < near.cols; ++column) {
          if (colours.distance2(features.at(row, column)) < sigmas * sigmas) near.at<uint8_t>(row, column) = 255;
        }
      }
      cv::morphologyEx(near, near, cv::MORPH_OPEN, cv::getStructuringElement(cv::MORPH_CROSS, {3, 3}));
      const cv::Mat component = component_at(near, click);
      const auto has_drifted = [&](const cv::Mat& to) {
        return (Distribution(features, to).mean - clicked.mean).head<2>().norm() > kDrift;
      };
      region = filled(component);
      bool drifted = cv::countNonZero(component) > 0 && has_drifted(region);
      if (drifted) {  // perhaps a frame around another colour
        region = component;
        drifted = has_drifted(region);
      }
      const int pixels = cv::countNonZero(region);
      if (pixels == 0 || pixels > largest_share(region) * whole.area()) break;
      // A region that has left the click has drifted to the colours of its surroundings.
      if (cv::countNonZero(region(start)) < kOfStart * start.area()) break;
      if (drifted) break;
      const double score = score_of(gradient, region);
      if (score <= best_score) continue;
      best_score = score;
      best = region;
    }
  }
  return best;
}

/// Cuts the object from its surroundings. Returns `region` when the cut contradicts it.
cv::Mat cut(const cv::Mat& bgr, const cv::Mat& gradient, const cv::Mat& region, const cv::Point& click) {
  const cv::Rect whole({0, 0}, bgr.size()), box = cv::boundingRect(region);
  const auto widened = [&](double share, int least) {
    const int margin = std::max(least, static_cast<int>(share * std::max(box.width, box.height)));
    return cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) & whole;
  };
  const cv::Rect window = widened(1, 20), possible = widened(0.25, 4);
  cv::Mat labels(bgr.size(), CV_8UC1, cv::Scalar::all(cv::GC_BGD));
  labels(possible).setTo(cv::GC_PR_BGD);
  labels.setTo(cv::GC_PR_FGD, region);
  cv::Mat inner;
  cv::erode(region, inner, cv::getStructuringElement(cv::MORPH_ELLIPSE, {5, 5}));
  labels.setTo(cv::GC_FGD, inner);
  labels.at<uint8_t>(click) = cv::GC_FGD;
  if (possible == window) return region;
  cv::Mat background, foreground, cut_labels = labels(window).clone();
  cv::setRNGSeed(1);
  constexpr int kRounds = 4;
  cv::grabCut(bgr(window), cut_labels, {}, background, foreground, kRounds, cv::GC_INIT_WITH_MASK);
  cv::Mat found = cv::Mat::zeros(bgr.size(), CV_8UC1);
  found(window).setTo(255, (cut_labels == cv::GC_FGD) | (cut_labels == cv::GC_PR_FGD));
  cv::morphologyEx(found, found, cv::MORPH_OPEN, cv::getStructuringElement(cv::MORPH_ELLIPSE, {5, 5}));
  const bool is_frame = cv::countNonZero(filled(region)) > cv::countNonZero(region);
  found = component_at(found, click);
  if (!is_frame) found = filled(found);
  const double ratio = static_cast<double>(cv::countNonZero(found)) / cv::countNonZero(region);
  constexpr double kLeast = 0.6, kMost = 2.5, kSet = 0.9;
  if (!(ratio > kLeast && ratio < kMost)) return region;
  if (cv::countNonZero(found) > largest_share(found) * static_cast<double>(whole.area())) return region;
  return score_of(gradient, found) >= kSet * score_of(gradient, region) ? found : region;
}

/// How much a region resembles a disc: compactness() in vision/colour/blob.hpp.
double compactness_of(const cv::Mat& region) {
  const cv::Moments m = cv::moments(region, true);
  if (!(m.m00 > 0)) return 0;
  Eigen::Matrix2d spread;
  spread << m.mu20, m.mu11, m.mu11, m.mu02;
  return vision::compactness(m.m00, spread / m.m00);
}

/// The pixels of a part of the image whose chroma is that of a region, however bright they are.
cv::Mat of_chroma(const Features& features, const cv::Mat& region, const cv::Rect& part, double sigmas) {
  const Distribution colours(features, region);
  const Eigen::Matrix2d information = colours.covariance.topLeftCorner<2, 2>().inverse();
  cv::Mat alike = cv::Mat::zeros(region.size(), CV_8UC1);
  for (int row = part.y; row < part.br().y; ++row) {
    for (int column = part.x; column < part.br().x; ++column) {
      const Eigen::Vector2d from = features.at(row, column).head<2>() - colours.mean.head<2>();
      if (from.dot(information * from) < sigmas * sigmas) alike.at<uint8_t>(row, column) = 255;
    }
  }
  cv::morphologyEx(alike, alike, cv::MORPH_OPEN, cv::getStructuringElement(cv::MORPH_CROSS, {3, 3}));
  return alike;
}

/// The mask, or what is not in it, without or with what is nearer to the rest than `radius`: by distances, since large
/// structuring elements take long.
cv::Mat eroded(const cv::Mat& mask, double radius) {
  cv::Mat distance;
  cv::distanceTransform(mask, distance, cv::DIST_L2, cv::DIST_MASK_5);
  return distance > radius;
}
cv::Mat dilated(const cv::Mat& mask, double radius) {
  cv::Mat distance;
  cv::distanceTransform(mask == 0, distance, cv::DIST_L2, cv::DIST_MASK_5);
  return distance <= radius;
}

/// Dark lines, at most `width` wide: pixels at most 0.7 times as bright as what is beside the line.
cv::Mat dark_lines(const cv::Mat& bgr, double width) {
  constexpr double kDarker = 0.7;
  const int size = static_cast<int>(std::ceil(width)) | 1;
  cv::Mat grey, beside;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  cv::morphologyEx(grey, beside, cv::MORPH_CLOSE, cv::getStructuringElement(cv::MORPH_RECT, {size, size}));
  beside.convertTo(beside, CV_8U, kDarker);
  return grey < beside;
}

/// Whether a region has the hue of another one, and about its saturation: from 0.7 to 1.5 of it.
bool has_hue(const Features& features, const cv::Mat& region, const cv::Mat& of) {
  const Eigen::Vector2d mean = Distribution(features, region).mean.head<2>();
  const Eigen::Vector2d wanted = Distribution(features, of).mean.head<2>();
  const double saturation = wanted.norm(), along = mean.dot(wanted) / saturation;
  const double across = std::abs(mean.x() * wanted.y() - mean.y() * wanted.x()) / saturation;
  return across < kDrift && along > 0.7 * saturation && along < 1.5 * saturation;
}

/// Adds the other parts of an object that dark seams divide, as the panels of a basketball: what has the chroma of the
/// region and is at most a seam away, if all is compact, more so than the region, has seams, and is about as well set
/// off. The numbers are choices, made with the balls that docs/real-images.md names in view.
cv::Mat with_other_parts(const cv::Mat& bgr, const Features& features, const cv::Mat& gradient, const cv::Mat& region,
                         const cv::Point& click) {
  constexpr double kSeam = 0.08;     // largest width of a seam, of the diameter of a disc of twice the region's area
  constexpr double kNeck = 0.2;      // likewise, of what connects an object to something else, as its reflection
  constexpr double kSeams = 0.02;    // least share of the object that seams cover: of a basketball's disc about a tenth
  constexpr double kCompact = 0.7;   // as join_parts() asks for; half a disc has 0.5
  constexpr double kMore = 1.3;      // times the region's area
  constexpr double kLeastSize = 40;  // pixels, diameter: seams of smaller objects are narrower than two pixels
  constexpr double kSetOff = 0.5;    // times the region's score: the object's border may be of lower contrast
  const double area = cv::countNonZero(region), diameter = 2 * std::sqrt(2 * area / std::numbers::pi);
  const double seam = kSeam * diameter + 2, least_compact = std::max(kCompact, compactness_of(region));
  const double least_area = std::max(kMore * area, std::numbers::pi / 4 * kLeastSize * kLeastSize);
  const int around = static_cast<int>(1.5 * diameter) + 2;
  const cv::Rect box = cv::boundingRect(region);
  const cv::Rect part = cv::Rect(box.x - around, box.y - around, box.width + 2 * around, box.height + 2 * around) &
                        cv::Rect({0, 0}, bgr.size());
  cv::Mat seams = cv::Mat::zeros(region.size(), CV_8UC1);
  dark_lines(bgr(part), seam).copyTo(seams(part));
  const auto has_seams = [&](const cv::Mat& whole) {
    cv::Mat inner;
    cv::erode(whole, inner, cv::getStructuringElement(cv::MORPH_ELLIPSE, {9, 9}));  // without the object's dark edge
    return cv::countNonZero(inner & seams) > kSeams * cv::countNonZero(inner);
  };
  double best_score = kSetOff * score_of(gradient, region);
  cv::Mat best = region.clone();
  for (const double sigmas : {4.0, 3.0, 2.0}) {
    const cv::Mat closed = eroded(dilated(of_chroma(features, region, part, sigmas), seam / 2), seam / 2);
    cv::Mat whole = filled(component_at(closed, click));
    if (cv::countNonZero(whole) < area || !has_seams(whole)) continue;
    whole = component_at(dilated(eroded(whole, kNeck / 2 * diameter), kNeck / 2 * diameter) & whole, click);
    const double most = largest_share(whole) * static_cast<double>(bgr.total());
    if (cv::countNonZero(whole) == 0 || cv::countNonZero(whole) > most) continue;
    whole = cut(bgr, gradient, whole, click);
    const double score = score_of(gradient, whole);
    if (cv::countNonZero(whole) < least_area || compactness_of(whole) < least_compact || score < best_score) continue;
    const cv::Mat without_seams = whole & ~dilated(seams, 1);
    if (!has_seams(whole) || cv::countNonZero(without_seams) == 0 || !has_hue(features, without_seams, region))
      continue;
    best_score = score;
    best = without_seams & of_chroma(features, without_seams, part, 4);
  }
  return best;
}

}  // namespace

ObjectRegion region_around(const cv::Mat& bgr, const cv::Point& click) {
  return region_around(bgr, std::vector{click});
}

ObjectRegion region_around(const cv::Mat& bgr, const std::vector<cv::Point>& clicks) {
  cv::Mat image = bgr;
  std::vector<cv::Point> points = clicks;
  const double scale = std::sqrt(kMostPixels / static_cast<double>(bgr.total()));
  if (scale < 1) {
    cv::resize(bgr, image, {}, scale, scale, cv::INTER_AREA);
    for (cv::Point& point : points) point = {point.x * image.cols / bgr.cols, point.y * image.rows / bgr.rows};
  }
  const Features features(image);
  const cv::Mat gradient = gradient_of(image);
  cv::Mat mask = cv::Mat::zeros(image.size(), CV_8UC1);
  for (const cv::Point& point : points) {
    const cv::Mat part = cut(image, gradient, grown(image, features, gradient, point), point);
    mask |= with_other_parts(image, features, gradient, part, point);
  }
  if (scale < 1) cv::resize(mask, mask, bgr.size(), 0, 0, cv::INTER_NEAREST);
  return {cv::boundingRect(mask), mask};
}

}  // namespace multireach
