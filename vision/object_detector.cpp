#include "vision/object_detector.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "vision/colour/grow_blobs.hpp"
#include "vision/colour/join_parts.hpp"
#include "vision/packed_cells.hpp"
#include "vision/stereo/triangulate.hpp"

namespace multireach::vision {
namespace {

constexpr double kFilled = 0.5;  // mask's share of an image above which the colour model is too wide
constexpr double kMore = 2;      // areas, by which the colours as learned show more of the target: a choice
// Of a wider colour model (widened()): at a tolerance of three standard deviations at least 0.45 of the saturation more
// or less, and 24 degrees in the plane of chroma, about as much as limits in HSV often allow.
constexpr double kWider = 0.15;
// Probability that an object is only what the learned colours show of what it was grown to: as likely as not.
constexpr double kOnlyLearned = 0.5;
constexpr double kDimmest = 10;  // grey levels: no pixel of a black image is brighter

/// Whether the image is black, as of a covered or dead camera. Samples every eighth pixel in both directions.
bool is_dark(const cv::Mat& bgr) {
  constexpr int kStep = 8;
  for (int row = kStep / 2; row < bgr.rows; row += kStep) {
    const auto* pixels = bgr.ptr<cv::Vec3b>(row);
    for (int column = kStep / 2; column < bgr.cols; column += kStep) {
      const cv::Vec3b& p = pixels[column];
      if (p[0] > kDimmest || p[1] > kDimmest || p[2] > kDimmest) return false;
    }
  }
  return true;
}

}  // namespace

ObjectDetector::ObjectDetector(const TrackerOptions& options, Side side)
    : camera_(options.rig.camera(side)),
      search_area_(vision::search_area(options, side)),
      min_area_px_(options.min_area_px),
      additional_ray_covariance_(ray_covariance(camera_, options.sigma_px)),
      learned_(options.colour[index(side)]),
      model_(options.colour[index(side)]),
      wider_(widened(options.colour[index(side)], kWider)),
      fitter_(camera_, options.match.radius_m > 0 ? SphereContourFitter::kOfASphere : SphereContourFitter::kOfAnything),
      background_({camera_.width, camera_.height}),
      motion_(search_area_.size()) {}

void ObjectDetector::restart() {
  gains_ = {};
  background_.forget();
  motion_.forget();
  shift_ = {};
  looks_ = since_look_ = 0;
}

View ObjectDetector::measure(const cv::Mat& bgr, const cv::Rect& window, bool chroma_subsampled, Colours colours,
                             const cv::Rect& expected) {
  View view;
  view.content = View::Content::kWrongImage;
  if (bgr.type() != CV_8UC3 || bgr.size() != whole_image().size()) return view;
  view.window = window;
  view.whole = window == search_area_;
  view.bgr = bgr;
  view.colours = colours;
  AdaptedColourModel& model = view.wider() ? wider_ : model_;
  const FoundBlobs found =
      finder_.find(bgr, window, model.members(gains_), {.min_area = min_area_px_, .most = kMaxBlobs});
  const bool filled = found.too_many_runs || static_cast<double>(found.members) > kFilled * search_area_.area();
  view.content = filled ? View::Content::kFilled : View::Content::kBlobs;
  if (filled) return view;
  view.full = found.blobs.size() >= kMaxBlobs;
  for (const Blob& blob : join_parts(found.blobs)) {
    view.seeds.push_back(blob);
    view.blobs.push_back(blob);
    view.contours.push_back(fitter_.fit(bgr, blob, window, chroma_subsampled));
  }
  grow(expected, chroma_subsampled, view);
  for (size_t k = 0; k < view.blobs.size(); ++k) {
    const Blob& blob = view.blobs[k];
    SphereContour& contour = view.contours[k];
    contour.covariance.topLeftCorner<2, 2>() += additional_ray_covariance_;
    if (contour.by_centroid) contour.by_centroid->covariance.topLeftCorner<2, 2>() += additional_ray_covariance_;
    view.appearance.push_back({.background = background_.share_of(view.seeds[k]),
                               .compactness = compactness(blob),
                               .colour_share = model.share_well_inside(gains_, bgr, blob)});
  }
  if (view.blobs.empty() && view.whole && is_dark(bgr(window))) view.content = View::Content::kDark;
  return view;
}

/// Replaces blobs of low compactness, for which no sphere contour was found, by what they grow to, and leaves out what
/// then is a part of another. What contains a sphere contour is no object of its own.
void ObjectDetector::grow(const cv::Rect& expected, bool chroma_subsampled, View& view) {
  const auto contains = [&](const Blob& grown, size_t k) {
    return 2 * static_cast<double>(common_pixels(grown, view.seeds[k])) > view.seeds[k].area;
  };
  const auto has_contour = [&](size_t k) { return view.contours[k].kind == SphereContour::Kind::kEdges; };
  for (size_t k = 0; k < view.seeds.size(); ++k) {
    const Blob& seed = view.seeds[k];
    if ((seed.box & expected).empty() || has_contour(k) || !has_low_compactness(seed)) continue;
    const cv::Rect searched = surroundings_of(seed) & view.window;
    const FoundBlobs more = finder_.find(view.bgr, searched, wider_.members(gains_), {.min_area = min_area_px_});
    const GrownBlob grown = grown_blob(seed, more.blobs, searched, search_area_);
    view.growth_cut_off = view.growth_cut_off || grown.cut_off;
    if (!grown.blob) continue;
    std::vector<size_t> parts;
    for (size_t other = 0; other < view.seeds.size(); ++other) {
      if (other != k && contains(*grown.blob, other)) parts.push_back(other);
    }
    if (std::ranges::any_of(parts, has_contour)) continue;
    view.blobs[k] = *grown.blob;
    add_alternative(seed, kOnlyLearned, view.blobs[k]);
    view.contours[k] = fitter_.fit(view.bgr, view.blobs[k], view.window, chroma_subsampled);
    // The last one first: the others keep their numbers.
    for (auto part = parts.rbegin(); part != parts.rend(); ++part) {
      const auto at = static_cast<std::ptrdiff_t>(*part);
      view.seeds.erase(view.seeds.begin() + at);
      view.blobs.erase(view.blobs.begin() + at);
      view.contours.erase(view.contours.begin() + at);
      if (*part < k) --k;
    }
  }
}

void ObjectDetector::adapt(const View& view, int blob, double quality) {
  const Blob& shown = view.seeds[static_cast<size_t>(blob)];
  gains_ = learned_colours_show_more(view, shown) ? returning(gains_, quality)
                                                  : adapted(gains_, model_.sample(gains_, view.bgr, shown), quality);
}

/// Whether the colours as learned show more of a compact object than those that were adapted, which show `blob`. Gains
/// that follow a part of an object, as the side in the light, lose the rest of it.
bool ObjectDetector::learned_colours_show_more(const View& view, const Blob& blob) {
  if (are_as_learned(gains_)) return false;
  const cv::Size margin = blob.box.size() / 2;
  const cv::Rect around = (blob.box - cv::Point(margin)) + margin + margin;
  const FoundBlobs found =
      finder_.find(view.bgr, around & view.window, learned_, {.min_area = min_area_px_, .most = kMaxBlobs});
  return std::ranges::any_of(join_parts(found.blobs), [&](const Blob& other) {
    const bool same = 2 * static_cast<double>(common_pixels(other, blob)) > blob.area;
    return same && other.area > kMore * blob.area && compactness(other) > compactness(blob);
  });
}

bool ObjectDetector::notice_motion(const View& view, int64_t utime) {
  using Content = View::Content;
  if (view.content == Content::kWrongImage || view.content == Content::kDark || !view.whole) return false;
  const CameraMotion::Motion motion = motion_.look(view.bgr(view.window));
  if (motion == CameraMotion::Motion::kNone) return false;
  if (motion == CameraMotion::Motion::kLarge) background_.forget();
  shift_.last_utime = utime;
  shift_.total_px += motion_.moved_px();
  return true;
}

void ObjectDetector::learn_background(const View& view, std::span<const cv::Rect> objects, bool others_are_background) {
  if (view.content != View::Content::kBlobs || view.wider()) return;
  if (others_are_background) background_.learn(view.window, view.seeds, objects, view.whole ? since_look_ + 1 : 1);
  since_look_ = view.whole ? 0 : std::min(kLookEvery, since_look_ + 1);
  if (view.whole) looks_ = std::min(kFirstLooks, looks_ + 1);
}

size_t ObjectDetector::serialized_size() const {
  return packed_size(background_.cells().size()) + packed_size(motion_.cells().size()) + kLooks;
}

void ObjectDetector::append_serialized(std::vector<double>& state) const {
  append_packed(background_.cells(), state);
  append_packed(motion_.cells(), state);
  state.insert(state.end(), {static_cast<double>(looks_), static_cast<double>(since_look_)});
}

bool ObjectDetector::is_valid_state(std::span<const double> state) const {
  if (state.size() != serialized_size()) return false;
  const auto whole = [](double value, double most) {
    return value >= 0 && value <= most && value == std::floor(value);
  };
  const size_t background = packed_size(background_.cells().size()), motion = packed_size(motion_.cells().size());
  return is_packed(state.first(background), background_.cells().size()) &&
         is_packed(state.subspan(background, motion), motion_.cells().size()) &&
         whole(state[state.size() - 2], kFirstLooks) && whole(state[state.size() - 1], kLookEvery);
}

void ObjectDetector::deserialize(std::span<const double> state) {
  const size_t background = packed_size(background_.cells().size()), motion = packed_size(motion_.cells().size());
  unpack(state.first(background), background_.cells());
  unpack(state.subspan(background, motion), motion_.cells());
  looks_ = static_cast<int>(state[state.size() - 2]);
  since_look_ = static_cast<int>(state[state.size() - 1]);
}

}  // namespace multireach::vision
