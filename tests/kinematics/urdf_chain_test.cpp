#include "kinematics/urdf_chain.hpp"
#include "kinematics/urdf_document.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "tests/test_arms.hpp"

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
                   "<origin xyz='1 0 0'/><axis xyz='1 0 0'/><limit lower='0' upper='0.5' velocity='3' effort='0'/>")),
      "a", "c");
  JointVector theta(2);
  theta << M_PI / 2, 0.25;
  EXPECT_TRUE(chain.position(theta).isApprox(Eigen::Vector3d(0, 1.25, 0), 1e-12));
  EXPECT_EQ(chain.velocity()[1], 3);
  EXPECT_TRUE(std::isinf(chain.joint(1).effort)) << "zero means no limit";
  const Chain back = chain_from_urdf(
      robot(second("prismatic",
                   "<origin xyz='1 0 0'/><axis xyz='1 0 0'/><limit lower='0' upper='0.5' velocity='3' effort='0'/>")),
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
  // urdfdom reads limits that are not written as 0.
  EXPECT_NE(fault(robot(second("revolute", "<axis xyz='0 0 1'/><limit velocity='1' effort='1'/>")))
                .find("joint 'second' has the limits 0.000000 and 0.000000: it cannot move"),
            std::string::npos);
  EXPECT_NE(fault(robot(second("revolute", "<axis xyz='0 0 1'/>"))), "");
  EXPECT_NE(fault(robot(second("fixed", "")), "a", "nowhere").find("no link 'nowhere'"), std::string::npos);
  EXPECT_NE(fault(robot(second("fixed", "")), "b", "c").find("no moving joint"), std::string::npos);
  EXPECT_NE(fault("<robot").find("not a valid URDF"), std::string::npos);
  EXPECT_NE(fault("").find("not a valid URDF"), std::string::npos);
  EXPECT_EQ(fault(robot(second("revolute", limits))), "");
}

TEST(UrdfChain, AVelocityLimitMustBePositive) {
  const auto with = [](const std::string& velocity) {
    return fault(robot(
        second("revolute", "<axis xyz='0 0 1'/><limit lower='-1' upper='1' effort='1' velocity='" + velocity + "'/>")));
  };
  EXPECT_EQ(with("1e-3"), "");
  EXPECT_EQ(with("0"), "joint 'second' has the velocity limit 0.000000; it must be positive");
  EXPECT_EQ(with("-2"), "joint 'second' has the velocity limit -2.000000; it must be positive");
  EXPECT_NE(with("nan"), "");
  EXPECT_NE(with("inf"), "");
  EXPECT_NE(fault(robot(second("continuous", "<axis xyz='0 0 1'/><limit effort='1' velocity='0'/>"))), "");
  EXPECT_EQ(fault(robot(second("continuous", "<axis xyz='0 0 1'/>"))), "") << "without a limit it has none";
}

TEST(UrdfChain, SoftLimitsNarrowTheLimits) {
  const auto with = [](const std::string& safety, const std::string& type = "revolute") {
    return robot(second(type,
                        "<axis xyz='0 0 1'/><limit lower='-1' upper='1' velocity='1' effort='1'/>"
                        "<safety_controller k_velocity='10' k_position='20' " +
                            safety + "/>"));
  };
  const auto limits = [&](const std::string& safety) {
    const Chain chain = chain_from_urdf(with(safety), "a", "c");
    return std::pair(chain.lower()[1], chain.upper()[1]);
  };
  EXPECT_EQ(limits("soft_lower_limit='-0.9' soft_upper_limit='0.8'"), std::pair(-0.9, 0.8));
  EXPECT_EQ(limits("soft_lower_limit='-2' soft_upper_limit='2'"), std::pair(-1.0, 1.0)) << "never wider";
  EXPECT_EQ(limits("soft_upper_limit='0.8'"), std::pair(-1.0, 0.8)) << "the lower one is not written";
  EXPECT_EQ(limits("soft_lower_limit='-0.9'"), std::pair(-0.9, 1.0)) << "the upper one is not written";
  EXPECT_EQ(limits(""), std::pair(-1.0, 1.0));
  EXPECT_EQ(limits("soft_lower_limit='0' soft_upper_limit='0'"), std::pair(-1.0, 1.0)) << "means none";
  EXPECT_EQ(fault(with("soft_lower_limit='2' soft_upper_limit='3'")),
            "joint 'second' has soft limits from 2.000000 to 3.000000, which leave nothing of its limits -1.000000 to "
            "1.000000");
  EXPECT_NE(fault(with("soft_lower_limit='0.5' soft_upper_limit='-0.5'")), "");
  const Chain turns = chain_from_urdf(with("soft_lower_limit='-0.9' soft_upper_limit='0.8'", "continuous"), "a", "c");
  EXPECT_TRUE(std::isinf(turns.upper()[1])) << "a continuous joint has no position limits";
  const Chain back = chain_from_urdf(with("soft_lower_limit='-0.9' soft_upper_limit='0.8'"), "c", "a");
  EXPECT_EQ(back.lower()[0], -0.9);
}

TEST(UrdfChain, LinksFormATree) {
  const auto joint = [](const std::string& name, const std::string& parent, const std::string& child) {
    return "<joint name='" + name + "' type='fixed'><parent link='" + parent + "'/><child link='" + child +
           "'/></joint>";
  };
  EXPECT_EQ(fault(robot(second("fixed", "") + joint("third", "a", "c"))),
            "joints 'second' and 'third' both have the child link 'c'; a link has one parent");
  const std::string links = "<link name='d'/><link name='e'/>";
  EXPECT_NE(
      fault(robot(second("fixed", "") + links + joint("x", "d", "e") + joint("y", "e", "d"))).find("cycle of links"),
      std::string::npos);
  EXPECT_NE(fault(robot(second("fixed", "") + links + joint("x", "d", "d"))).find("cycle of links"), std::string::npos);
  EXPECT_NE(fault(robot(second("fixed", "") + joint("back", "c", "a"))).find("cycle of links"), std::string::npos);
}

TEST(UrdfChain, RefusesWhatWouldExhaustMemoryOrTheStack) {
  constexpr int kMany = 200000;
  std::string open, close;
  for (int i = 0; i < kMany; ++i) {
    open += "<a b='>'>";
    close += "</a>";
  }
  EXPECT_NE(fault(open + close).find("nested more than 64 deep"), std::string::npos);
  EXPECT_NE(fault(open).find("nested more than 64 deep"), std::string::npos);
  std::string siblings;
  for (int i = 0; i < 1000; ++i) siblings += "<!-- <a> --><a b='/>'></a><c/>";
  EXPECT_EQ(fault(robot(second("fixed", "") + siblings)), "") << "many, but side by side";
  std::string links;
  for (int i = 0; i < 2001; ++i) links += "<link name='l" + std::to_string(i) + "'/>";
  EXPECT_NE(fault(robot(links)).find("more than 2000 links"), std::string::npos);
  EXPECT_NE(fault(std::string((16 << 20) + 1, ' ')).find("larger than 16 MB"), std::string::npos);
}

TEST(UrdfChain, AFaultOutsideTheChainDoesNotMatter) {
  EXPECT_EQ(fault(robot(second("floating", "")), "a", "b"), "");
}

TEST(UrdfTree, NamesLinksJointsAndTheWayToTheRoot) {
  const UrdfTree tree = urdf_tree(testing::file_text(testing::hoap2_file().path));
  EXPECT_EQ(tree.joints.size() + 1, tree.links.size());
  const std::vector<std::string> way = tree.ancestry("right_hand");
  EXPECT_EQ(way.front(), "right_hand");
  EXPECT_EQ(way.back(), "torso");
  EXPECT_EQ(tree.ancestry("torso"), std::vector<std::string>{"torso"});
}

}  // namespace
}  // namespace multireach
