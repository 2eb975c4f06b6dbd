#include "bench/real/clicks.hpp"

#include <ranges>

#include "tools/calibrate/object_colour.hpp"

namespace multireach::bench {

Clicked learn_clicks(const std::vector<Click>& clicks) {
  std::vector<ObjectPicture> pictures;
  Clicked clicked;
  for (const Click& click : clicks) {
    clicked.used.push_back(pictures.size());
    pictures.push_back({.bgr = click.image, .region = region_around(click.image, click.at), .within = click.within});
  }
  const auto leave_out = [&](size_t k) {
    pictures.erase(pictures.begin() + static_cast<ptrdiff_t>(k));
    clicked.used.erase(clicked.used.begin() + static_cast<ptrdiff_t>(k));
  };
  ObjectColour object = learn_object(pictures);
  bool mostly_refused = false;
  if (!object.fault.empty() && pictures.size() > 1) {
    const std::vector<size_t> alone = faulty_alone(pictures);
    mostly_refused = are_most(alone, pictures);
    for (const size_t k : std::views::reverse(alone)) {
      if (pictures.size() > 1) leave_out(k);
    }
    object = learn_object(pictures);
  }
  while (object.faulty_picture && pictures.size() > 1) {
    leave_out(faulty_among(pictures).value_or(*object.faulty_picture));
    object = learn_object(pictures);
  }
  clicked.fault = object.fault;
  if (mostly_refused && clicked.fault.empty()) clicked.fault = "most of the clicks are refused";
  if (object.colour.status == vision::LearnedColour::Status::kLearned) clicked.model = object.colour.model;
  return clicked;
}

}  // namespace multireach::bench
