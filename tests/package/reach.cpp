// An arm from its URDF reaches for a point: the controller without LCM, as a library.
#include <fstream>
#include <iostream>
#include <iterator>
#include <multireach/controller/law/guarded_law.hpp>
#include <multireach/kinematics/urdf_chain.hpp>

using namespace multireach;

int main(int argc, char** argv) try {
  if (argc != 4) throw std::invalid_argument("usage: reach URDF BASE TIP");
  std::ifstream file(argv[1]);
  const std::string urdf{std::istreambuf_iterator<char>(file), {}};
  controller::GuardedLaw law(chain_from_urdf(urdf, argv[2], argv[3]));
  law.start(law.chain().clamped(JointVector::Constant(law.chain().size(), -0.3)));
  if (law.set_target({.position = {0.1, -0.12, 0.1}}) != controller::TargetResult::kReachable)
    std::cout << "unreachable\n";
  for (int tick = 0; tick < 60; ++tick) {
    for (int step = 0; step < 7; ++step) law.step();  // 140 a second; the gains are per step
    std::cout << 0.05 * (tick + 1) << " s: " << law.theta().transpose() << "\n";
  }
  std::cout << "hand at " << law.x().transpose() << "\n";
} catch (const std::exception& error) {
  std::cerr << "reach: " << error.what() << "\n";
  return 2;
}
