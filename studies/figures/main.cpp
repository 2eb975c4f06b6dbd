// multireach-figures: computes the data of the figures in the documentation.
#include <functional>
#include <map>

#include "runtime/files.hpp"
#include "runtime/program.hpp"
#include "studies/figures/scenes.hpp"

namespace multireach {
namespace {

using Scene = std::function<Figure(const SceneArm&)>;

/// Wraps a scene that has curves but no measures.
Scene curves_of(Table (*scene)(const Chain&)) {
  return [scene](const SceneArm& arm) { return Figure{scene(arm.chain)}; };
}

const std::map<std::string, Scene> kScenes{{"limits", curves_of(limits_scene)},
                                           {"arrival", curves_of(arrival_scene)},
                                           {"singularity", curves_of(singularity_scene)},
                                           {"targets", curves_of(targets_scene)},
                                           {"posture-choice", curves_of(posture_choice_scene)},
                                           {"push", curves_of(push_scene)},
                                           {"obstacle", curves_of(obstacle_scene)},
                                           {"clutter", curves_of(clutter_scene)},
                                           {"orientation", curves_of(orientation_scene)},
                                           {"fig1", vite_scene},
                                           {"fig4", weight_scene},
                                           {"fig7", failures_scene},
                                           {"fig8", unreached_scene},
                                           {"gamma", gamma_scene},
                                           {"fig9", attractors_scene},
                                           {"fig10", executed_scene},
                                           {"fig11", profile_scene},
                                           {"fig12", straight_scene},
                                           {"fig13", stretched_scene},
                                           {"fig14", neck_scene},
                                           {"fig15", displaced_scene},
                                           {"fig16", pushed_scene},
                                           {"protocol-reaches", protocol_reaches_scene},
                                           {"protocol-lemniscate", protocol_lemniscate_scene}};

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  names.reserve(kScenes.size());
  for (const auto& [name, scene] : kScenes) names.push_back(name);
  return names;
}

}  // namespace
}  // namespace multireach

int main(int argc, char** argv) {
  multireach::Program program("multireach-figures", "The numbers behind the pictures of the documentation, as CSV.");
  std::string scene, urdf, base, tip, csv = "-", measures;
  program.cli().option("scene", scene, "which picture").required().one_of(multireach::scene_names());
  program.cli().option("--urdf", urdf, "URDF file").required();
  program.cli().option("--base", base, "link at the start of the chain; its frame is W").required();
  program.cli().option("--tip", tip, "link at the end of the chain, the hand").required();
  program.cli().option("-o,--output", csv, "CSV file to write; - for standard output").show_default();
  program.cli().option("--measures", measures, "output file for the quantities measured; - for standard output");
  return program.run(argc, argv, [&] {
    using namespace multireach;
    const SceneArm arm{.chain = load_chain(urdf, base, tip), .urdf_xml = read_text_file(urdf)};
    const Figure figure = kScenes.at(scene)(arm);
    write_text_file(csv, figure.curves.csv());
    if (!measures.empty()) write_text_file(measures, measures_csv(scene, figure.measures));
    return 0;
  });
}
