#pragma once

namespace multireach::controller {

/// The robot's own body and how it keeps away from things.
struct Body {
  double link_radius_m = 0;    ///< every link is a capsule of this radius between its joints; 0 for no body: then
                               ///< obstacles and self-collision are not looked at
  double margin_m = 0.005;     ///< what the surfaces stay apart
  bool self_collision = true;  ///< whether links that are not neighbours keep away from each other
  double sight_m = 0.25;       ///< pairs further apart than this are not looked at
};

}  // namespace multireach::controller
