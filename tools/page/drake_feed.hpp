#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/node.hpp"
#include "runtime/robot_config.hpp"

namespace multireach {

/// Sends what Drake's viewer meldis shows, in its messages: the arm as capsules and balls, targets, obstacles. The
/// shapes are sent again every five seconds, for a viewer that is started later; where they are, at most 30 times a
/// second.
class DrakeFeed {
 public:
  static constexpr std::string_view kLoad = "DRAKE_VIEWER_LOAD_ROBOT", kDraw = "DRAKE_VIEWER_DRAW";

  explicit DrakeFeed(const RobotConfig& robot);

  /// A message that the node received.
  void receive(std::string_view channel, std::span<const uint8_t> bytes);
  /// `utime`: now, microseconds.
  void tick(int64_t utime, Outbox& out);

 private:
  struct Shape {
    int8_t type;  // of lcmt_viewer_geometry_data
    Eigen::Isometry3d X_LS;
    Eigen::Vector4d colour;
    std::vector<double> size;
  };
  struct Link {
    std::string name;
    std::vector<Shape> shapes;
    Eigen::Isometry3d X_WL = Eigen::Isometry3d::Identity();
  };

  std::vector<uint8_t> load_message() const;
  std::vector<uint8_t> draw_message(int64_t utime) const;

  Chain chain_;
  double radius_m_;
  std::vector<Link> arm_, obstacles_;
  std::map<std::string, Link> targets_;
  bool moved_ = false, changed_ = true;
  int64_t drawn_us_ = INT64_MIN / 2, loaded_us_ = INT64_MIN / 2;
};

}  // namespace multireach
