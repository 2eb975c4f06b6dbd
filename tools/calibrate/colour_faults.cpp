#include "tools/calibrate/colour_faults.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <opencv2/imgproc.hpp>

#include "vision/colour/find.hpp"
#include "vision/colour/join_parts.hpp"
#include "vision/colour/learn_colour.hpp"
#include "vision/stereo_tracker.hpp"

namespace multireach {
namespace {

constexpr double kFewest = 0.25;  // least share of the object's area by which something is found, or the object itself
constexpr double kFilled = 0.5;   // share of the picture from which on vision says that the colour is everywhere
constexpr double kSimilar = 0.7;  // another object of this share of the object's area passes as the object
// Share of something in the region from which it is not another object, but what was clicked; the second where several
// objects were: of one that moves, a click may show no more than the middle.
constexpr double kClicked = 0.5, kClickedOfSeveral = 0.25;
constexpr double kPart = 0.1;  // least share of the object's area of a part of it that is worth a click
/// How many of a blob's pixels are in a region's mask, or box.
double area_inside(const vision::Blob& blob, const ObjectRegion& region) {
  double area = 0;
  for (const vision::Run& run : blob.runs) {
    if (region.mask.empty()) {
      area += (cv::Rect(run.begin, run.row, run.end - run.begin, 1) & region.box).area();
    } else {
      area += cv::countNonZero(region.mask.row(run.row).colRange(run.begin, run.end));
    }
  }
  return area;
}

/// The boxes around the connected parts of a region.
std::vector<cv::Rect> boxes_of(const ObjectRegion& region) {
  if (region.mask.empty() || region.box.empty()) return {region.box};
  cv::Mat labels, stats, centres;
  const int count = cv::connectedComponentsWithStats(region.mask(region.box), labels, stats, centres);
  std::vector<cv::Rect> boxes;
  for (int k = 1; k < count; ++k) {
    const int* of = stats.ptr<int>(k);
    boxes.emplace_back(region.box.x + of[cv::CC_STAT_LEFT], region.box.y + of[cv::CC_STAT_TOP], of[cv::CC_STAT_WIDTH],
                       of[cv::CC_STAT_HEIGHT]);
  }
  return boxes;
}

/// What to do where something is found that may be a part of the object which the region does not reach, as beyond a
/// highlight or on another face.
std::string if_part(const PicturePart& part) {
  const bool rectangle = part.region->mask.empty();
  return rectangle ? "if that is a part of the object, draw the rectangle around all of it"
                   : "if that is a part of the object, click there as well, or draw a rectangle around all of it";
}

/// What to do where another object is found.
std::string if_other(const PicturePart& part) {
  const bool rectangle = part.region->mask.empty();
  return fmt::format(
      "if it looks alike, {}; else take a picture without it, or give the part that counts (--within-left, "
      "--within-right)",
      rectangle ? "click on each instead of drawing a rectangle" : "click on it as well");
}

/// Whether so much of something is in the region that it is what was clicked.
bool was_clicked(const vision::Blob& blob, const PicturePart& part) {
  return area_inside(blob, *part.region) > (part.boxes.size() > 1 ? kClickedOfSeveral : kClicked) * blob.area;
}

/// Whether something may be a part of the object that a click did not reach: it is no farther from a part of the
/// region than twice its length. A rectangle is drawn around all of the object: only what reaches into it is near.
bool is_near(const cv::Rect& other, const PicturePart& part) {
  return std::ranges::any_of(part.boxes, [&](const cv::Rect& box) {
    const int margin = part.region->mask.empty() ? 0 : 2 * std::max(box.width, box.height);
    const cv::Rect around = box + cv::Size(2 * margin, 2 * margin) - cv::Point(margin, margin);
    return !(around & other).empty();
  });
}

/// "X,Y" in the picture.
std::string position_of(const Eigen::Vector2d& px, const cv::Point& corner) {
  return fmt::format("{},{}", cvRound(px.x()) + corner.x, cvRound(px.y()) + corner.y);
}

/// Where something else has the object's colours, which learning from the whole picture leaves out, as the end of a
/// sentence; empty where nothing large has.
std::string others_like_it(const PicturePart& part) {
  const cv::Mat& bgr = part.bgr;
  const ObjectRegion& region = *part.region;
  const int margin = std::max(region.box.width, region.box.height) / 2;
  const cv::Rect near =
      (region.box + cv::Size(2 * margin, 2 * margin) - cv::Point(margin, margin)) & cv::Rect(0, 0, bgr.cols, bgr.rows);
  const vision::LearnedColour alone = region.mask.empty() ? vision::learn_colour(bgr(near), region.box - near.tl())
                                                          : vision::learn_colour_of(bgr(near), region.mask(near));
  if (alone.status != vision::LearnedColour::Status::kLearned) return {};
  vision::BlobFinder finder;
  const vision::FoundBlobs found = finder.find(bgr, {0, 0, bgr.cols, bgr.rows}, vision::ColourTable(alone.model));
  const vision::Blob* largest = nullptr;
  for (const vision::Blob& blob : found.blobs) {
    if (area_inside(blob, region) > 0.1 * blob.area) continue;
    if (!largest || blob.area > largest->area) largest = &blob;
  }
  const bool rectangle = region.mask.empty();
  if (!largest)
    return std::string(": ") + (rectangle ? "" : "draw a rectangle around all of it, ") +
           "give it more light, or choose one that differs from what is around it";
  const auto longest =
      std::ranges::max_element(largest->runs, {}, [](const vision::Run& run) { return run.end - run.begin; });
  return fmt::format(
      "; what is at {} has the same colours: if it is the object, or a part of it, draw {} rectangle around all of "
      "it{}; "
      "else take a picture without it, or set search_region_m in vision.yaml and give --within-left and --within-right",
      position_of({0.5 * (longest->begin + longest->end - 1), longest->row}, part.corner), rectangle ? "the" : "a",
      rectangle ? "" : ", or click on it");
}

/// Why the finder does not find the object in the picture that its colour was learned from; empty when it does.
std::string finder_fault(const PicturePart& part, const vision::ColourModel& model) {
  const cv::Mat& bgr = part.bgr;
  const ObjectRegion& region = *part.region;
  vision::BlobFinder finder;
  const vision::FoundBlobs found = finder.find(bgr, {0, 0, bgr.cols, bgr.rows}, vision::ColourTable(model));
  if (found.too_many_runs) return "the learned colours are all over the picture";
  if (static_cast<double>(found.members) > kFilled * static_cast<double>(bgr.total()))
    return "the learned colours fill most of the picture: show more of what is around the object";
  const std::vector<vision::Blob> blobs = vision::join_parts(found.blobs);
  if (blobs.empty()) return "no colour tells the object from what is around it" + others_like_it(part);
  const vision::Blob* object = nullptr;
  double inside = 0;
  double all_inside = 0;  // also of the object's other parts, as beside a stripe
  for (const vision::Blob& blob : blobs) {
    const double area = area_inside(blob, region);
    all_inside += area;
    if (area <= inside) continue;
    inside = area;
    object = &blob;
  }
  if (!object) {
    return fmt::format("with the learned colours another object is found, at {}, and not this one",
                       position_of(blobs[0].centroid, part.corner));
  }
  if (inside < 0.5 * object->area) {
    return std::string("with the learned colours the object is found together with much of what is around it: ") +
           if_part(part) + "; else click where it differs from that, or show it before something else";
  }
  for (const vision::Blob& blob : blobs) {
    if (blob.area < kSimilar * object->area || was_clicked(blob, part)) continue;
    return fmt::format("with the learned colours another object is found, at {}, {:.0f} % as large as this one: {}",
                       position_of(blob.centroid, part.corner), 100 * blob.area / object->area,
                       (is_near(blob.box, part) ? if_part(part) + "; " : "") + if_other(part));
  }
  const double whole = area_of(region);
  if (all_inside < kFewest * whole)
    return fmt::format("only {:.0f} % of the object is found with the learned colours", 100 * all_inside / whole) +
           others_like_it(part);
  return {};
}

/// Where something beside the object has its colours, as a sentence; empty where nothing has.
std::string doubt_of_region(const PicturePart& part, const vision::ColourModel& model) {
  const cv::Mat& bgr = part.bgr;
  vision::BlobFinder finder;
  const vision::FoundBlobs found = finder.find(bgr, {0, 0, bgr.cols, bgr.rows}, vision::ColourTable(model));
  for (const vision::Blob& blob : found.blobs) {
    if (blob.area < kPart * area_of(*part.region) || was_clicked(blob, part)) continue;
    if (is_near(blob.box, part))
      return fmt::format("what is at {} has its colours, too: {}", position_of(blob.centroid, part.corner),
                         if_part(part));
  }
  return {};
}

/// Where something was clicked that has none of the learned colours, as a sentence; empty where all has some of them.
/// The share of the whole region does not tell that of a small part.
std::string doubt_of_parts(const PicturePart& part, const vision::ColourModel& model) {
  const vision::ColourTable members(model);
  for (const cv::Rect& box : part.boxes) {
    int pixels = 0, learned = 0;
    count_learned(part, box, members, pixels, learned);
    if (learned >= kPart * pixels) continue;
    const cv::Point at = part.corner + (box.tl() + box.br()) / 2;
    return fmt::format(
        "what was clicked at {},{} does not have the learned colours: leave that click out, or show it in another "
        "picture",
        at.x, at.y);
  }
  return {};
}

/// Why an outlined region is a highlight: brighter and less saturated than what is around it, which is a surface of the
/// same hue and of one saturation. Empty where it is none.
std::string fault_of_outline(const PicturePart& part) {
  if (part.region->mask.empty()) return {};
  // Choices, set on rendered balls.
  constexpr double kSameHue = 0.97;    // cosine of 14 degrees
  constexpr double kSaturation = 1.4;  // largest ratio of the saturations of one surface
  constexpr double kColoured = 8;      // chroma in Lab, from which on it has a hue
  constexpr double kMost = 0.7;        // share of what is around
  constexpr int kBlurred = 2;          // pixels around the outline that the lens blurs
  const cv::Rect& box = part.region->box;
  const int width = std::max(3, std::max(box.width, box.height) / 4), margin = kBlurred + width + 1;
  const cv::Rect window = cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) &
                          cv::Rect({}, part.bgr.size());
  const cv::Mat mask = part.region->mask(window);
  cv::Mat distance, lab;
  cv::distanceTransform(mask == 0, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  cv::cvtColor(part.bgr(window), lab, cv::COLOR_BGR2Lab);
  const cv::Scalar mean = cv::mean(lab, mask);
  const Eigen::Vector2d hue(mean[1] - 128, mean[2] - 128);
  if (hue.norm() < kColoured) return {};
  int around = 0;
  std::vector<double> saturation;  // of what has the hue and is darker
  for (int row = 0; row < lab.rows; ++row) {
    for (int column = 0; column < lab.cols; ++column) {
      const float away = distance.at<float>(row, column);
      if (away <= kBlurred || away > static_cast<float>(kBlurred + width)) continue;
      ++around;
      const auto& p = lab.at<cv::Vec3b>(row, column);
      const Eigen::Vector2d chroma(p[1] - 128, p[2] - 128);
      if (p[0] < mean[0] && chroma.norm() > kColoured && chroma.dot(hue) > kSameHue * chroma.norm() * hue.norm())
        saturation.push_back(chroma.norm() / std::max<double>(p[0], 1));
    }
  }
  if (saturation.empty()) return {};
  const auto middle = saturation.begin() + static_cast<std::ptrdiff_t>(saturation.size() / 2);
  std::ranges::nth_element(saturation, middle);
  const double median = *middle;
  const auto same =
      std::ranges::count_if(saturation, [&](double s) { return s < kSaturation * median && s * kSaturation > median; });
  if (hue.norm() > median * mean[0] || static_cast<double>(same) < kMost * around) return {};
  return "what is around the outline of the click has the same colour, but is darker, as around a highlight: click "
         "beside the highlight, or draw a rectangle around the object";
}

/// Whether a point of the part is in a box around what was clicked.
bool is_clicked(const Eigen::Vector2d& px, const PicturePart& part) {
  const cv::Point at(cvRound(px.x()), cvRound(px.y()));
  return std::ranges::any_of(part.boxes, [&](const cv::Rect& box) { return box.contains(at); });
}

/// Whether what is found around a point was clicked. Of an object of which patches were clicked, the centre may be
/// between them, as may that of something else.
bool shows_clicked(const Eigen::Vector2d& px, const PicturePart& part, const vision::ColourModel& model) {
  const cv::Mat& bgr = part.bgr;
  vision::BlobFinder finder;
  std::vector<vision::Blob> blobs =
      vision::join_parts(finder.find(bgr, {0, 0, bgr.cols, bgr.rows}, vision::ColourTable(model)).blobs);
  const cv::Point at(cvRound(px.x()), cvRound(px.y()));
  std::erase_if(blobs, [&](const vision::Blob& blob) { return !blob.box.contains(at); });
  const auto nearest =
      std::ranges::min_element(blobs, {}, [&](const vision::Blob& blob) { return (blob.centroid - px).norm(); });
  if (nearest == blobs.end()) return false;
  return was_clicked(*nearest, part) || (is_clicked(px, part) && area_inside(*nearest, *part.region) > 0);
}

/// Why vision would not answer with the object; empty when it would.
std::string doubt_of_vision(const FoundByVision& found, const PicturePart& part, const vision::ColourModel& model) {
  if (!found) return {};
  using Status = vision::StereoMatch::Status;
  if (found->match.status == Status::kSeen) {
    const Eigen::Vector2d& px = found->match.left_px;
    if (shows_clicked(px, part, model)) return {};
    return fmt::format("by the colours alone vision would take what is at {} for it", position_of(px, part.corner));
  }
  if (found->match.status != Status::kAmbiguous)
    return std::string("by the colours alone vision would say: ") + description(found->match.status);
  const auto other = std::ranges::find_if(found->candidates, [&](const vision::Candidate& candidate) {
    return !is_clicked(candidate.match.left_px, part);
  });
  if (other == found->candidates.end() && part.boxes.size() > 1) return {};  // several that look alike
  if (other == found->candidates.end())
    return "by the colours alone vision may take a part of the object for all of it: " + if_part(part);
  return fmt::format(
      "by the colours alone vision may take what is at {} for the object, or not choose between the two: set "
      "search_region_m, or ball_radius_m of a ball",
      position_of(other->match.left_px, part.corner));
}

/// Where vision would take something else for the object, as "X,Y" in the picture; empty where it would not. What is
/// near the region may be the object: the click may be beside it, or show a part.
std::string taken_for_it(const FoundByVision& found, const PicturePart& part) {
  if (!found || found->match.status != vision::StereoMatch::Status::kSeen) return {};
  const Eigen::Vector2d& px = found->match.left_px;
  if (is_near({cvRound(px.x()), cvRound(px.y()), 1, 1}, part)) return {};
  return position_of(px, part.corner);
}

/// What vision would take for the object when that is occluded, as a sentence; empty where nothing.
std::string doubt_when_occluded(const PicturePart& part, const vision::ColourModel& model) {
  PicturePart covered{part.bgr.clone(), part.region, part.corner, part.boxes};
  const cv::Rect picture({}, part.bgr.size());
  const vision::ColourTable members(model);
  const bool black = members.contains(0, 0, 0);
  if (black && members.contains(255, 255, 255)) return {};
  const auto cover = [&](const cv::Rect& box) { covered.bgr(box & picture).setTo(cv::Scalar::all(black ? 255 : 0)); };
  for (const cv::Rect& box : part.boxes) cover(box);
  vision::BlobFinder finder;
  for (const vision::Blob& blob : finder.find(part.bgr, picture, members).blobs) {
    if (is_near(blob.box, part)) cover(blob.box);
  }
  const std::string other = taken_for_it(found_by_vision(covered, model), covered);
  if (other.empty()) return {};
  return fmt::format(
      "when the object is occluded or out of view, vision may take what is at {} for it: give more pictures, set "
      "ball_radius_m of a ball or search_region_m, or choose another object",
      other);
}

/// Whether what is found of the object reaches the border of the picture.
bool is_cut_off(const PicturePart& part, const vision::ColourModel& model) {
  const cv::Rect picture({}, part.bgr.size());
  vision::BlobFinder finder;
  const std::vector<vision::Blob> blobs =
      vision::join_parts(finder.find(part.bgr, picture, vision::ColourTable(model)).blobs);
  const auto object =
      std::ranges::max_element(blobs, {}, [&](const vision::Blob& blob) { return area_inside(blob, *part.region); });
  if (object == blobs.end()) return false;
  const cv::Rect& box = object->box;
  return box.x == 0 || box.y == 0 || box.br().x == picture.width || box.br().y == picture.height;
}

/// Why the object, which the border of the picture cuts off, is not the thing that vision would take; empty where it is
/// not cut off, or nothing else could be taken.
std::string fault_at_border(const FoundByVision& found, const PicturePart& part, const vision::ColourModel& model) {
  using Status = vision::StereoMatch::Status;
  if (!found || (found->match.status != Status::kAmbiguous && found->match.status != Status::kSeen)) return {};
  std::optional<Eigen::Vector2d> other;
  if (found->match.status == Status::kSeen) {
    if (!shows_clicked(found->match.left_px, part, model)) other = found->match.left_px;
  } else {
    for (const vision::Candidate& candidate : found->candidates) {
      const Eigen::Vector2d& px = candidate.match.left_px;
      if (!other && !is_near({cvRound(px.x()), cvRound(px.y()), 1, 1}, part)) other = px;
    }
  }
  if (!other || !is_cut_off(part, model)) return {};
  return fmt::format(
      "the border cuts off the object, and by the colours alone vision may take what is at {} for it: show all of "
      "the object; {}",
      position_of(*other, part.corner), if_other(part));
}

}  // namespace

PicturePart part_of(const cv::Mat& bgr, const std::optional<ObjectRegion>& region, const cv::Rect& within) {
  PicturePart part{bgr(within), std::nullopt, within.tl(), {}};
  if (!region) return part;
  part.region =
      ObjectRegion{(region->box & within) - within.tl(), region->mask.empty() ? cv::Mat() : region->mask(within)};
  part.boxes = boxes_of(*part.region);
  return part;
}

double area_of(const ObjectRegion& region) {
  return region.mask.empty() ? region.box.area() : cv::countNonZero(region.mask);
}

void count_learned(const PicturePart& part, const cv::Rect& box, const vision::ColourTable& members, int& pixels,
                   int& learned) {
  const cv::Mat& mask = part.region->mask;
  for (int row = box.y; row < box.br().y; ++row) {
    for (int column = box.x; column < box.br().x; ++column) {
      if (!mask.empty() && mask.at<uint8_t>(row, column) == 0) continue;
      const auto& p = part.bgr.at<cv::Vec3b>(row, column);
      ++pixels;
      learned += members.contains(p[0], p[1], p[2]);
    }
  }
}

FoundByVision found_by_vision(const PicturePart& part, const vision::ColourModel& model) {
  constexpr int kLeast = 40;  // pixels
  const cv::Mat& bgr = part.bgr;
  if (std::min(bgr.cols, bgr.rows) < kLeast) return std::nullopt;
  vision::TrackerOptions options;
  options.rig = parallel_rig(bgr.cols, bgr.rows, bgr.cols, 0.06);
  options.rig.right.cx += 0.12 * bgr.cols;
  options.colour = {model, model};
  vision::StereoTracker tracker(options);
  return tracker.find(bgr, bgr);
}

std::string fault_of(const FoundByVision& found, const PicturePart& part, const vision::ColourModel& model) {
  if (std::string fault = finder_fault(part, model); !fault.empty()) return fault;
  if (std::string fault = fault_of_outline(part); !fault.empty()) return fault;
  const std::string other = taken_for_it(found, part);
  if (!other.empty())
    return fmt::format("by the colours alone vision would take what is at {} for it: {}", other, if_other(part));
  return fault_at_border(found, part, model);
}

std::vector<std::string> doubts_of(const FoundByVision& found, const PicturePart& part,
                                   const vision::ColourModel& model) {
  std::vector<std::string> doubts;
  for (const std::string& doubt :
       {doubt_of_parts(part, model), doubt_of_region(part, model), doubt_of_vision(found, part, model)}) {
    if (!doubt.empty()) doubts.push_back(doubt);
  }
  if (!doubts.empty()) return doubts;
  if (const std::string doubt = doubt_when_occluded(part, model); !doubt.empty()) doubts.push_back(doubt);
  return doubts;
}

std::string fault_without_object(const PicturePart& part, const vision::ColourModel& model, double area) {
  const cv::Mat& bgr = part.bgr;
  vision::BlobFinder finder;
  const vision::FoundBlobs found = finder.find(bgr, {0, 0, bgr.cols, bgr.rows}, vision::ColourTable(model));
  if (found.too_many_runs) return "the learned colours are all over the picture, which does not have the object";
  for (const vision::Blob& blob : vision::join_parts(found.blobs)) {
    if (blob.area < kFewest * area) continue;
    return fmt::format(
        "with the learned colours something is found at {}, {:.0f} % as large as the object, which is not there",
        position_of(blob.centroid, part.corner), 100 * blob.area / area);
  }
  return {};
}

std::string not_found(const PicturePart& part, const std::string& name, const vision::ColourModel& model) {
  using Status = vision::StereoMatch::Status;
  const std::string in_picture = name.empty() ? "" : " in " + name;
  const auto found = found_by_vision(part, model);
  if (const std::string other = taken_for_it(found, part); !other.empty())
    return fmt::format("by their colours vision would take what is at {}{} for the object", other, in_picture);
  if (!found || found->match.status == Status::kSeen || found->match.status == Status::kCutOff ||
      found->match.status == Status::kMoreAtBorder)
    return {};
  if (found->match.status == Status::kAmbiguous && std::ranges::any_of(found->candidates, [&](const auto& candidate) {
        const Eigen::Vector2d& px = candidate.match.left_px;
        return is_near({cvRound(px.x()), cvRound(px.y()), 1, 1}, part);
      }))
    return {};
  return fmt::format("by their colours vision would not find the object{} ({})", in_picture,
                     description(found->match.status));
}

}  // namespace multireach
