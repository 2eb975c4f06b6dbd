#include "tools/calibrate/object_colour.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <ranges>

#include "vision/colour/colour_table.hpp"
#include "vision/colour/find.hpp"
#include "vision/colour/join_parts.hpp"
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
constexpr char kIfOther[] =
    "if it looks alike, click on it as well; else take a picture without it, or give the part that counts "
    "(--within-left, --within-right)";
// What is near the object may be a part of it that the click did not reach, as beyond a highlight or on another face.
constexpr char kIfPart[] = "if that is a part of the object, click there as well, or draw a rectangle around all of it";

double area_of(const ObjectRegion& region) {
  return region.mask.empty() ? region.box.area() : cv::countNonZero(region.mask);
}

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

/// The part of a picture that counts, with what it shows of the object.
struct Part {
  cv::Mat bgr;
  std::optional<ObjectRegion> region;
  cv::Point corner;             // in the picture
  std::vector<cv::Rect> boxes;  // around the parts of the region: each object that was clicked, or each patch of one
};

Part part_of(const ObjectPicture& picture) {
  const cv::Rect within = picture.within.value_or(cv::Rect({0, 0}, picture.bgr.size()));
  Part part{picture.bgr(within), std::nullopt, within.tl(), {}};
  if (picture.region) {
    const ObjectRegion& region = *picture.region;
    part.region =
        ObjectRegion{(region.box & within) - within.tl(), region.mask.empty() ? cv::Mat() : region.mask(within)};
    part.boxes = boxes_of(*part.region);
  }
  return part;
}

/// Whether so much of something is in the region that it is what was clicked.
bool was_clicked(const vision::Blob& blob, const Part& part) {
  return area_inside(blob, *part.region) > (part.boxes.size() > 1 ? kClickedOfSeveral : kClicked) * blob.area;
}

/// Whether something may be a part of the object that a click did not reach: it is no farther from a part of the
/// region than twice its length. A rectangle is drawn around all of the object: only what reaches into it is near.
bool is_near(const cv::Rect& other, const Part& part) {
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
std::string others_like_it(const Part& part) {
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
  if (!largest)
    return ": draw a rectangle around all of it, give it more light, or choose one that differs from what is around it";
  const auto longest =
      std::ranges::max_element(largest->runs, {}, [](const vision::Run& run) { return run.end - run.begin; });
  return fmt::format(
      "; what is at {} has the same colours: if it is the object, draw a rectangle around all of it; else take a "
      "picture without it, or set search_region_m in vision.yaml and give --within-left and --within-right",
      position_of({0.5 * (longest->begin + longest->end - 1), longest->row}, part.corner));
}

/// Why the finder does not find the object in the picture that its colour was learned from; empty when it does.
std::string finder_fault(const Part& part, const vision::ColourModel& model) {
  const cv::Mat& bgr = part.bgr;
  const ObjectRegion& region = *part.region;
  vision::BlobFinder finder;
  const vision::FoundBlobs found = finder.find(bgr, {0, 0, bgr.cols, bgr.rows}, vision::ColourTable(model));
  if (found.too_many_runs) return "the learned colours are all over the picture";
  if (static_cast<double>(found.members) > kFilled * static_cast<double>(bgr.total()))
    return "the learned colours fill most of the picture: show more of what is around the object";
  const std::vector<vision::Blob> blobs = vision::join_parts(found.blobs);
  if (blobs.empty()) return "with the learned colours nothing is found, not even the object" + others_like_it(part);
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
    return "with the learned colours the object is found together with much of what is around it: click where "
           "it differs from that, or show it before something else";
  }
  for (const vision::Blob& blob : blobs) {
    if (blob.area < kSimilar * object->area || was_clicked(blob, part)) continue;
    return fmt::format("with the learned colours another object is found, at {}, {:.0f} % as large as this one: {}",
                       position_of(blob.centroid, part.corner), 100 * blob.area / object->area,
                       is_near(blob.box, part) ? kIfPart : kIfOther);
  }
  const double whole = area_of(region);
  if (all_inside < kFewest * whole)
    return fmt::format("only {:.0f} % of the object is found with the learned colours", 100 * all_inside / whole) +
           others_like_it(part);
  return {};
}

/// Why the finder finds something in a picture without the object, which has `area` pixels elsewhere; empty when it
/// does not.
std::string finder_fault(const cv::Mat& bgr, const vision::ColourModel& model, double area, const cv::Point& corner) {
  vision::BlobFinder finder;
  const vision::FoundBlobs found = finder.find(bgr, {0, 0, bgr.cols, bgr.rows}, vision::ColourTable(model));
  if (found.too_many_runs) return "the learned colours are all over the picture, which does not have the object";
  for (const vision::Blob& blob : vision::join_parts(found.blobs)) {
    if (blob.area < kFewest * area) continue;
    return fmt::format(
        "with the learned colours something is found at {}, {:.0f} % as large as the object, which is not there",
        position_of(blob.centroid, corner), 100 * blob.area / area);
  }
  return {};
}

/// Where something beside the object has its colours, as a sentence; empty where nothing has.
std::string doubt_of_region(const Part& part, const vision::ColourModel& model) {
  const cv::Mat& bgr = part.bgr;
  vision::BlobFinder finder;
  const vision::FoundBlobs found = finder.find(bgr, {0, 0, bgr.cols, bgr.rows}, vision::ColourTable(model));
  for (const vision::Blob& blob : found.blobs) {
    if (blob.area < kPart * area_of(*part.region) || was_clicked(blob, part)) continue;
    if (is_near(blob.box, part))
      return fmt::format("what is at {} has its colours, too: {}", position_of(blob.centroid, part.corner), kIfPart);
  }
  return {};
}

/// Adds the number of the region's pixels in a box, and of those of them that have the learned colours.
void count_learned(const Part& part, const cv::Rect& box, const vision::ColourTable& members, int& pixels,
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

/// Where something was clicked that has none of the learned colours, as a sentence; empty where all has some of them.
/// The share of the whole region does not tell that of a small part.
std::string doubt_of_parts(const Part& part, const vision::ColourModel& model) {
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

std::string about(const ObjectPicture& picture, const std::string& sentence) {
  return picture.name.empty() ? sentence : picture.name + ": " + sentence;
}

/// What vision, knowing only the colours, finds in a picture where the other camera sees just the same, as of things
/// half a metre away: its optical axis passes to the right of the middle. Nothing of a picture that is too small.
std::optional<vision::StereoTracker::Found> found_by_vision(const Part& part, const vision::ColourModel& model) {
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

/// Whether a point of the part is in a box around what was clicked.
bool is_clicked(const Eigen::Vector2d& px, const Part& part) {
  const cv::Point at(cvRound(px.x()), cvRound(px.y()));
  return std::ranges::any_of(part.boxes, [&](const cv::Rect& box) { return box.contains(at); });
}

/// Why vision would not answer with the object; empty when it would.
std::string doubt_of_vision(const std::optional<vision::StereoTracker::Found>& found, const Part& part) {
  if (!found) return {};
  using Status = vision::StereoMatch::Status;
  if (found->match.status == Status::kSeen) {
    const Eigen::Vector2d& px = found->match.left_px;
    if (is_clicked(px, part) || part.region->box.contains(cv::Point(cvRound(px.x()), cvRound(px.y())))) return {};
    return fmt::format("by the colours alone vision would take what is at {} for it", position_of(px, part.corner));
  }
  if (found->match.status != Status::kAmbiguous)
    return std::string("by the colours alone vision would say: ") + description(found->match.status);
  const auto other = std::ranges::find_if(found->candidates, [&](const vision::Candidate& candidate) {
    return !is_clicked(candidate.match.left_px, part);
  });
  if (other == found->candidates.end() && part.boxes.size() > 1) return {};  // several that look alike
  return fmt::format(
      "by the colours alone vision would not choose between it and {}, and where it is hidden or cut off, not notice: "
      "set search_region_m, or ball_radius_m of a ball",
      other == found->candidates.end() ? "a part of it"
                                       : "what is at " + position_of(other->match.left_px, part.corner));
}

/// Where vision would take something else for the object, as "X,Y" in the picture; empty where it would not. What is
/// near the region may be the object: the click may be beside it, or show a part.
std::string taken_for_it(const std::optional<vision::StereoTracker::Found>& found, const Part& part) {
  if (!found || found->match.status != vision::StereoMatch::Status::kSeen) return {};
  const Eigen::Vector2d& px = found->match.left_px;
  if (is_near({cvRound(px.x()), cvRound(px.y()), 1, 1}, part)) return {};
  return position_of(px, part.corner);
}

/// Why the colours do not serve to find the object in a picture that has it; empty when they do. `found`: by vision.
std::string fault_of(const std::optional<vision::StereoTracker::Found>& found, const Part& part,
                     const vision::ColourModel& model) {
  const std::string fault = finder_fault(part, model);
  if (!fault.empty()) return fault;
  const std::string other = taken_for_it(found, part);
  return other.empty()
             ? ""
             : fmt::format("by the colours alone vision would take what is at {} for it: {}", other, kIfOther);
}

/// Why vision would not find the object by the colours in a picture that they were not learned from, as a clause; empty
/// where it would, or where the border cuts off the object.
std::string not_found(const ObjectPicture& picture, const vision::ColourModel& model) {
  using Status = vision::StereoMatch::Status;
  const Part part = part_of(picture);
  const std::string in_picture = picture.name.empty() ? "" : " in " + picture.name;
  const auto found = found_by_vision(part, model);
  if (const std::string other = taken_for_it(found, part); !other.empty())
    return fmt::format("by their colours vision would take what is at {}{} for the object", other, in_picture);
  if (!found || found->match.status == Status::kSeen || found->match.status == Status::kCutOff) return {};
  if (found->match.status == Status::kAmbiguous && std::ranges::any_of(found->candidates, [&](const auto& candidate) {
        const Eigen::Vector2d& px = candidate.match.left_px;
        return is_near({cvRound(px.x()), cvRound(px.y()), 1, 1}, part);
      }))
    return {};
  return fmt::format("by their colours vision would not find the object{} ({})", in_picture,
                     description(found->match.status));
}

/// What is doubtful about the colours in one picture.
void warn(const ObjectPicture& picture, const vision::LearnedColour::Rates& rates, std::vector<std::string>& warnings) {
  constexpr double kFew = 0.8, kMuch = 0.01;
  if (picture.region && rates.kept < kFew)
    warnings.push_back(
        about(picture, fmt::format("only {:.0f} % of the object has the learned colours", 100 * rates.kept)));
  if (rates.background > kMuch)
    warnings.push_back(
        about(picture, fmt::format("{:.1f} % of the background has the learned colours", 100 * rates.background)));
}

}  // namespace

ObjectColour learn_object(std::span<const ObjectPicture> pictures) {
  std::vector<Part> parts;
  std::vector<vision::TrainingPicture> training;
  double smallest = 0;  // area of the object, pixels
  for (const ObjectPicture& picture : pictures) {
    const Part& part = parts.emplace_back(part_of(picture));
    const ObjectRegion region = part.region.value_or(ObjectRegion{});
    training.push_back(
        {.bgr = part.bgr, .has_object = part.region.has_value(), .rectangle = region.box, .mask = region.mask});
    if (part.region) smallest = smallest > 0 ? std::min(smallest, area_of(region)) : area_of(region);
  }
  ObjectColour object{.colour = vision::learn_colour(training)};
  const vision::LearnedColour& colour = object.colour;
  if (colour.status != vision::LearnedColour::Status::kLearned) {
    object.faulty_picture = pictures.size() == 1 ? 0 : colour.picture;
    const std::string sentence = description(colour.status);
    object.fault = object.faulty_picture ? about(pictures[*object.faulty_picture], sentence) : sentence;
    return object;
  }
  for (size_t k = 0; k < pictures.size(); ++k) {
    warn(pictures[k], colour.rates[k], object.warnings);
    if (!object.fault.empty()) continue;
    const Part& part = parts[k];
    const auto found = part.region ? found_by_vision(part, colour.model) : std::nullopt;
    const std::string fault =
        part.region ? fault_of(found, part, colour.model) : finder_fault(part.bgr, colour.model, smallest, part.corner);
    if (fault.empty()) {
      if (!part.region) continue;
      for (const std::string& doubt :
           {doubt_of_parts(part, colour.model), doubt_of_region(part, colour.model), doubt_of_vision(found, part)}) {
        if (!doubt.empty()) object.warnings.push_back(about(pictures[k], doubt));
      }
      continue;
    }
    object.faulty_picture = k;
    object.fault = about(pictures[k], fault);
  }
  if (colour.by_brightness)
    object.warnings.emplace_back("only brightness distinguishes the object; lock the camera's exposure");
  return object;
}

ObjectColour learn_object(const ObjectPicture& picture) {
  return learn_object(std::span(&picture, 1));
}

std::vector<size_t> faulty_alone(std::span<const ObjectPicture> pictures) {
  std::vector<size_t> faulty;
  for (size_t k = 0; k < pictures.size(); ++k) {
    if (pictures[k].region && !learn_object(pictures[k]).fault.empty()) faulty.push_back(k);
  }
  return faulty;
}

std::optional<size_t> faulty_among(std::span<const ObjectPicture> pictures) {
  std::optional<size_t> faulty;
  double most = 0;
  for (size_t k = 0; k < pictures.size() && pictures.size() > 2; ++k) {
    if (!pictures[k].region) continue;
    std::vector<ObjectPicture> others(pictures.begin(), pictures.end());
    others.erase(others.begin() + static_cast<ptrdiff_t>(k));
    if (std::ranges::none_of(others, [](const ObjectPicture& other) { return other.region.has_value(); })) continue;
    const ObjectColour learned = learn_object(others);
    if (!learned.fault.empty() || learned.colour.kept <= most) continue;
    most = learned.colour.kept;
    faulty = k;
  }
  return faulty;
}

AgreeingPictures learn_agreeing(std::span<const ObjectPicture> pictures) {
  AgreeingPictures agreeing{learn_object(pictures)};
  std::vector<ObjectPicture> taken(pictures.begin(), pictures.end());
  std::vector<size_t> numbers(pictures.size());
  std::iota(numbers.begin(), numbers.end(), size_t{0});
  const auto objects = [&] {
    return std::ranges::count_if(taken, [](const ObjectPicture& picture) { return picture.region.has_value(); });
  };
  const auto leave_out = [&](size_t k) {
    if (objects() < 2 || !taken[k].region) return false;
    agreeing.left_out.push_back(numbers[k]);
    taken.erase(taken.begin() + static_cast<ptrdiff_t>(k));
    numbers.erase(numbers.begin() + static_cast<ptrdiff_t>(k));
    return true;
  };
  ObjectColour& object = agreeing.object;
  if (!object.fault.empty() && objects() > 1) {
    const std::vector<size_t> alone = faulty_alone(taken);
    if (2 * alone.size() > static_cast<size_t>(objects()))
      agreeing.doubt = "most pictures of the object are refused even alone";
    for (const size_t k : std::views::reverse(alone)) leave_out(k);
    if (!agreeing.left_out.empty()) object = learn_object(taken);
  }
  constexpr size_t kFew = 6;  // pictures, of which it takes seconds to learn from all but one, for each
  while (!object.fault.empty()) {
    const auto among = taken.size() > kFew ? std::nullopt : faulty_among(taken);
    const auto faulty = among ? among : object.faulty_picture;
    if (!faulty || !leave_out(*faulty)) break;
    object = learn_object(taken);
  }
  if (object.faulty_picture) object.faulty_picture = numbers[*object.faulty_picture];
  std::ranges::sort(agreeing.left_out);
  if (object.colour.status != vision::LearnedColour::Status::kLearned) return agreeing;
  for (const size_t k : agreeing.left_out) {
    if (agreeing.doubt.empty()) agreeing.doubt = not_found(pictures[k], object.colour.model);
  }
  return agreeing;
}

double largest_share(std::span<const ObjectPicture> pictures, const vision::ColourModel& model) {
  const vision::ColourTable members(model);
  double largest = 0;
  for (const ObjectPicture& picture : pictures) {
    if (!picture.region) continue;
    const Part part = part_of(picture);
    int pixels = 0, learned = 0;
    for (const cv::Rect& box : part.boxes) count_learned(part, box, members, pixels, learned);
    if (pixels > 0) largest = std::max(largest, static_cast<double>(learned) / pixels);
  }
  return largest;
}

cv::Mat members_picture(const ObjectPicture& picture, const vision::ColourModel& model) {
  const vision::ColourTable members(model);
  cv::Mat shown = picture.bgr.clone();
  for (int row = 0; row < shown.rows; ++row) {
    for (int column = 0; column < shown.cols; ++column) {
      auto& p = shown.at<cv::Vec3b>(row, column);
      if (members.contains(p[0], p[1], p[2])) continue;
      const auto grey = static_cast<uint8_t>((p[0] + 2 * p[1] + p[2]) / 12);
      p = {grey, grey, grey};
    }
  }
  if (!picture.region) return shown;
  const ObjectRegion& region = *picture.region;
  if (region.mask.empty()) {
    cv::rectangle(shown, region.box, {0, 255, 0});
  } else {
    std::vector<std::vector<cv::Point>> contours;
    cv::findContours(region.mask.clone(), contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
    cv::drawContours(shown, contours, -1, {0, 255, 0});
  }
  return shown;
}

}  // namespace multireach
