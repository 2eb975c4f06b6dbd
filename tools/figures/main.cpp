// multireach-figures: the numbers behind the pictures of the documentation.
#include <map>

#include "runtime/files.hpp"
#include "runtime/program.hpp"
#include "tools/figures/scenes.hpp"

namespace multireach {
namespace {

const std::map<std::string, Table (*)(const Chain&)> kScenes{{"limits", limits_scene},
                                                             {"arrival", arrival_scene},
                                                             {"singularity", singularity_scene},
                                                             {"targets", targets_scene},
                                                             {"posture-choice", posture_choice_scene},
                                                             {"push", push_scene},
                                                             {"obstacle", obstacle_scene},
                                                             {"clutter", clutter_scene},
                                                             {"orientation", orientation_scene}};

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  for (const auto& [name, scene] : kScenes) names.push_back(name);
  return names;
}

}  // namespace
}  // namespace multireach

int main(int argc, char** argv) {
  multireach::Program program("multireach-figures", "The numbers behind the pictures of the documentation, as CSV.");
  std::string scene, urdf, base, tip, csv = "-";
  program.cli()
      .add_option("scene", scene, "which picture")
      ->required()
      ->check(CLI::IsMember(multireach::scene_names()));
  program.cli().add_option("--urdf", urdf, "URDF file")->required();
  program.cli().add_option("--base", base, "link at the start of the chain; its frame is W")->required();
  program.cli().add_option("--tip", tip, "link at the end of the chain, the hand")->required();
  program.cli().add_option("--csv", csv, "output file; - for standard output")->capture_default_str();
  return program.run(argc, argv, [&] {
    multireach::write_text_file(csv, multireach::kScenes.at(scene)(multireach::load_chain(urdf, base, tip)).csv());
    return 0;
  });
}
