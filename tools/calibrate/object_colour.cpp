#include "tools/calibrate/object_colour.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "tools/calibrate/colour_faults.hpp"
#include "vision/colour/colour_table.hpp"

namespace multireach {
namespace {

PicturePart part_of(const ObjectPicture& picture) {
  return part_of(picture.bgr, picture.region, picture.within.value_or(cv::Rect({0, 0}, picture.bgr.size())));
}

std::string about(const ObjectPicture& picture, const std::string& sentence) {
  return picture.name.empty() ? sentence : picture.name + ": " + sentence;
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
  std::vector<PicturePart> parts;
  std::vector<vision::TrainingPicture> training;
  double smallest = 0;  // area of the object, pixels
  for (const ObjectPicture& picture : pictures) {
    const PicturePart& part = parts.emplace_back(part_of(picture));
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
    const PicturePart& part = parts[k];
    const auto found = part.region ? found_by_vision(part, colour.model) : std::nullopt;
    const std::string fault =
        part.region ? fault_of(found, part, colour.model) : fault_without_object(part, colour.model, smallest);
    if (fault.empty()) {
      if (!part.region) continue;
      for (const std::string& doubt : doubts_of(found, part, colour.model))
        object.warnings.push_back(about(pictures[k], doubt));
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
    for (auto k = alone.rbegin(); k != alone.rend(); ++k) leave_out(*k);
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
    if (agreeing.doubt.empty()) agreeing.doubt = not_found(part_of(pictures[k]), pictures[k].name, object.colour.model);
  }
  return agreeing;
}

double largest_share(std::span<const ObjectPicture> pictures, const vision::ColourModel& model) {
  const vision::ColourTable members(model);
  double largest = 0;
  for (const ObjectPicture& picture : pictures) {
    if (!picture.region) continue;
    const PicturePart part = part_of(picture);
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
