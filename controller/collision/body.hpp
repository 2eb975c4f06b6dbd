#pragma once

namespace multireach::controller {

/// The collision model of the robot's body, and the distances that it keeps.
struct Body {
  double link_radius_m = 0;        ///< every link is a capsule of this radius between its joints; 0 means no body: then
                                   ///< obstacles and self-collision are ignored
  double margin_m = 0.005;         ///< minimum distance between surfaces
  bool self_collision = true;      ///< whether links that are not neighbours avoid each other
  double query_distance_m = 0.25;  ///< pairs further apart than this plus the margin are ignored
};

}  // namespace multireach::controller
