#include "bench/real/clicks.hpp"

#include <algorithm>

#include "tools/calibrate/object_colour.hpp"

namespace multireach::bench {

Clicked learn_clicks(const std::vector<Click>& clicks) {
  std::vector<ObjectPicture> pictures;
  for (const Click& click : clicks)
    pictures.push_back({.bgr = click.image, .region = region_around(click.image, click.at), .within = click.within});
  const AgreeingPictures agreeing = learn_agreeing(pictures);
  const ObjectColour& object = agreeing.object;
  Clicked clicked;
  clicked.fault = object.fault;
  if (clicked.fault.empty()) clicked.fault = agreeing.doubt;
  clicked.warnings = object.warnings;
  if (object.colour.status == vision::LearnedColour::Status::kLearned) clicked.model = object.colour.model;
  for (size_t k = 0; k < pictures.size(); ++k) {
    if (!std::ranges::binary_search(agreeing.left_out, k)) clicked.used.push_back(k);
  }
  return clicked;
}

}  // namespace multireach::bench
