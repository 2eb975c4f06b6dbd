#pragma once

#include <string>
#include <vector>

#include "kinematics/chain.hpp"
#include "studies/figures/table.hpp"

namespace multireach {

/// The arm that a scene is made for.
struct SceneArm {
  Chain chain;
  std::string urdf_xml;  ///< the text of its URDF, for what simulates the robot
};

/// One number that a picture shows or that stands beside it.
struct Measure {
  std::string law;       ///< under which law, or what else distinguishes a column of the figure's table
  std::string quantity;  ///< what was measured; a row of the figure's table
  double value;
  std::string unit;  ///< empty for a pure number
};

/// A scene's curves, for the plot, and the quantities taken from them.
struct Figure {
  Table curves;
  std::vector<Measure> measures{};

  void add(const std::string& law, const std::string& quantity, double value, const std::string& unit = "") {
    measures.push_back({law, quantity, value, unit});
  }
};

/// The measures as CSV with the columns figure,law,quantity,value,unit; texts without commas.
std::string measures_csv(const std::string& figure, const std::vector<Measure>& measures);

}  // namespace multireach
