#pragma once

#include <string>
#include <vector>

#include "kinematics/chain.hpp"
#include "studies/figures/table.hpp"

namespace multireach {

/// The arm of a scene.
struct SceneArm {
  Chain chain;
  std::string urdf_xml;  ///< the text of its URDF, for the simulation
};

/// One number of a figure's table.
struct Measure {
  std::string law;       ///< column of the figure's table: a law or a variant of it
  std::string quantity;  ///< row of the figure's table: the measured quantity
  double value;
  std::string unit;  ///< empty for a dimensionless number
};

/// The curves of a scene, for the plot, and the quantities measured on them.
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
