#include "kinematics/urdf_chain.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace multireach {
namespace {

std::string robot(const std::string& joint) {
  return "<robot name='r'><link name='a'/><link name='b'/><link name='c'/>"
         "<joint name='first' type='revolute'><parent link='a'/><child link='b'/><axis xyz='0 0 2'/>"
         "<limit lower='-1' upper='1' velocity='2' effort='3'/></joint>" +
         joint + "</robot>";
}

std::string second(const std::string& type, const std::string& inside) {
  return "<joint name='second' type='" + type + "'><parent link='b'/><child link='c'/>" + inside + "</joint>";
}

std::string fault(const std::string& xml, const std::string& base = "a", const std::string& tip = "c") {
  try {
    chain_from_urdf(xml, base, tip);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(UrdfChain, ReadsLimitsAndNormalisesAxes) {
  const Chain chain = chain_from_urdf(robot(second("fixed", "")), "a", "c");
  ASSERT_EQ(chain.size(), 1);
  EXPECT_EQ(chain.joint(0).axis, Eigen::Vector3d::UnitZ());
  EXPECT_EQ(chain.lower()[0], -1);
  EXPECT_EQ(chain.velocity()[0], 2);
  EXPECT_EQ(chain.joint(0).effort, 3);
}

TEST(UrdfChain, PrismaticJointsMoveAlongTheirAxis) {
  const Chain chain = chain_from_urdf(
      robot(second("prismatic",
                   "<origin xyz='1 0 0'/><axis xyz='1 0 0'/><limit lower='0' upper='0.5' velocity='0' effort='0'/>")),
      "a", "c");
  JointVector theta(2);
  theta << M_PI / 2, 0.25;
  EXPECT_TRUE(chain.position(theta).isApprox(Eigen::Vector3d(0, 1.25, 0), 1e-12));
  EXPECT_TRUE(std::isinf(chain.velocity()[1])) << "zero means no limit";
  const Chain back = chain_from_urdf(
      robot(second("prismatic",
                   "<origin xyz='1 0 0'/><axis xyz='1 0 0'/><limit lower='0' upper='0.5' velocity='0' effort='0'/>")),
      "c", "a");
  EXPECT_TRUE(back.pose(theta.reverse()).isApprox(chain.pose(theta).inverse(), 1e-12));
}

TEST(UrdfChain, ContinuousJointsHaveNoLimits) {
  const Chain chain = chain_from_urdf(robot(second("continuous", "<axis xyz='0 1 0'/>")), "a", "c");
  EXPECT_TRUE(std::isinf(chain.upper()[1]));
  EXPECT_FALSE(chain.joint(1).limited());
}

TEST(UrdfChain, SaysWhatItRefusesByName) {
  const std::string limits = "<axis xyz='0 0 1'/><limit lower='-1' upper='1' velocity='1' effort='1'/>";
  EXPECT_NE(fault(robot(second("revolute", limits + "<mimic joint='first'/>"))).find("'second' mimics joint 'first'"),
            std::string::npos);
  EXPECT_NE(fault(robot(second("floating", ""))).find("'second' is floating"), std::string::npos);
  EXPECT_NE(fault(robot(second("planar", "<axis xyz='0 0 1'/>"))).find("'second' is planar"), std::string::npos);
  EXPECT_NE(fault(robot(second("revolute", "<axis xyz='0 0 0'/><limit lower='-1' upper='1' velocity='1' effort='1'/>")))
                .find("'second'"),
            std::string::npos);
  EXPECT_NE(fault(robot(second("revolute", "<axis xyz='0 0 1'/><limit lower='1' upper='-1' velocity='1' effort='1'/>")))
                .find("'second'"),
            std::string::npos);
  EXPECT_NE(fault(robot(second("revolute", "<axis xyz='0 0 1'/>"))), "");
  EXPECT_NE(fault(robot(second("fixed", "")), "a", "nowhere").find("no link 'nowhere'"), std::string::npos);
  EXPECT_NE(fault(robot(second("fixed", "")), "b", "c").find("no moving joint"), std::string::npos);
  EXPECT_NE(fault("<robot").find("not a valid URDF"), std::string::npos);
  EXPECT_NE(fault("").find("not a valid URDF"), std::string::npos);
  EXPECT_EQ(fault(robot(second("revolute", limits))), "");
}

TEST(UrdfChain, AFaultOutsideTheChainDoesNotMatter) {
  EXPECT_EQ(fault(robot(second("floating", "")), "a", "b"), "");
}

}  // namespace
}  // namespace multireach
