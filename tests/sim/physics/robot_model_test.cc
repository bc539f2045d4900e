#include <gtest/gtest.h>

#include "tests/sim/physics/test_worlds.h"
#include "walking/kinematics.h"

namespace sim::physics {
namespace {

struct Limit {
  const char* joint;
  Eigen::Vector3d axis;
  double low, high;
};

const Eigen::Vector3d kX = Eigen::Vector3d::UnitX(), kY = Eigen::Vector3d::UnitY(),
                      kZ = Eigen::Vector3d::UnitZ();

// Order, axes and limits of HRP-2's joints.
const std::vector<Limit> kLimits{
    {"RLEG_JOINT0", kZ, -.785398, .523599},  {"RLEG_JOINT1", kX, -.610865, .349066},
    {"RLEG_JOINT2", kY, -2.18166, .733038},  {"RLEG_JOINT3", kY, -.0349066, 2.61799},
    {"RLEG_JOINT4", kY, -1.309, .733038},    {"RLEG_JOINT5", kX, -.349066, .610865},
    {"LLEG_JOINT0", kZ, -.523599, .785398},  {"LLEG_JOINT1", kX, -.349066, .610865},
    {"LLEG_JOINT2", kY, -2.18166, .733038},  {"LLEG_JOINT3", kY, -.0349066, 2.61799},
    {"LLEG_JOINT4", kY, -1.309, .733038},    {"LLEG_JOINT5", kX, -.610865, .349066},
    {"CHEST_JOINT0", kZ, -.785398, .785398}, {"CHEST_JOINT1", kY, -.0872665, 1.0472},
    {"HEAD_JOINT0", kZ, -.785398, .785398},  {"HEAD_JOINT1", kY, -.523599, .785398},
    {"RARM_JOINT0", kY, -3.14159, 1.0472},   {"RARM_JOINT1", kX, -1.65806, .174533},
    {"RARM_JOINT2", kZ, -1.6057, 1.6057},    {"RARM_JOINT3", kY, -2.3911, .0349066},
    {"RARM_JOINT4", kZ, -1.6057, 1.6057},    {"RARM_JOINT5", kY, -1.6057, 1.6057},
    {"RARM_JOINT6", kX, -1.0, 1.0},          {"LARM_JOINT0", kY, -3.14159, 1.0472},
    {"LARM_JOINT1", kX, -.174533, 1.65806},  {"LARM_JOINT2", kZ, -1.6057, 1.6057},
    {"LARM_JOINT3", kY, -2.3911, .0349066},  {"LARM_JOINT4", kZ, -1.6057, 1.6057},
    {"LARM_JOINT5", kY, -1.6057, 1.6057},    {"LARM_JOINT6", kX, -1.0, 1.0}};

TEST(RobotModel, HasTheJointsOfHrp2InItsOrderWithItsAxesAndLimits) {
  const World world = standing();
  const mjModel* m = world.model();
  ASSERT_EQ(m->nu, 30);
  for (std::size_t i = 0; i < kLimits.size(); ++i) {
    const int actuator = static_cast<int>(i);
    ASSERT_STREQ(mj_id2name(m, mjOBJ_ACTUATOR, actuator), kLimits[i].joint);
    const int joint = mj_name2id(m, mjOBJ_JOINT, kLimits[i].joint);
    ASSERT_EQ(m->actuator_trnid[2 * actuator], joint);
    EXPECT_EQ(Eigen::Vector3d(m->jnt_axis + 3 * joint), kLimits[i].axis) << kLimits[i].joint;
    EXPECT_TRUE(m->jnt_limited[joint]);
    EXPECT_DOUBLE_EQ(m->jnt_range[2 * joint], kLimits[i].low) << kLimits[i].joint;
    EXPECT_DOUBLE_EQ(m->jnt_range[2 * joint + 1], kLimits[i].high) << kLimits[i].joint;
  }
}

/// A link that one joint moves; the model may make it of two bodies that stand still against each other at
/// zero.
struct Link {
  std::vector<std::string> bodies;
  double mass;
  Eigen::Vector3d com;  // in the joint's frame, of the left side
};

// HRP-2 No. 14: masses as published, centers of mass as its published CoM Jacobian has them.
const std::vector<Link> kTrunk{{{"BODY"}, 15.0295, {-.01435, 0, .23285}},
                               {{"CHEST_LINK0"}, .786369, {-.01580, 0, 0}},
                               {{"CHEST_LINK1"}, 11.5246, {-.02905, .0075, .12076}},
                               {{"HEAD_LINK0"}, .374766, {-.00088, 0, 0}},
                               {{"HEAD_LINK1"}, .993355, {.01299, .00169, .10876}}};
const std::vector<Link> kLeftLimbs{{{"LEG_LINK0"}, 1.23548, {-.00664, -.00461, 0}},
                                   {{"LEG_LINK1"}, .80553, {-.00664, .040, -.00292}},
                                   {{"LEG_LINK2"}, 2.07632, {.00346, .06566, -.15168}},
                                   {{"LEG_LINK3"}, 1.74762, {.01799, .03066, -.13839}},
                                   {{"LEG_LINK4"}, .65375, {0, .003, -.00242}},
                                   {{"LEG_LINK5", "LEG_SOLE"}, 1.63877, {.00264, .00469, -.06538}},
                                   {{"ARM_LINK0"}, .810076, {-.02339, 0, -.00015}},
                                   {{"ARM_LINK1"}, 1.03448, {0, .01204, -.040}},
                                   {{"ARM_LINK2"}, 1.59929, {-.00543, .01413, -.14713}},
                                   {{"ARM_LINK3"}, .77725, {0, 0, -.100}},
                                   {{"ARM_LINK4"}, .554669, {0, 0, -.15623}},
                                   {{"ARM_LINK5", "ARM_LINK6"}, 1.1464661, {.00361, 0, -.09311}}};

void expect_link(const mjModel* m, const Link& link, const std::string& prefix) {
  double mass = 0;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero(), origin = Eigen::Vector3d::Zero();
  for (const std::string& name : link.bodies) {
    const int body = mj_name2id(m, mjOBJ_BODY, (prefix + name).c_str());
    ASSERT_GE(body, 0) << prefix + name;
    if (name != link.bodies.front()) origin = Eigen::Vector3d(m->body_pos + 3 * body);
    mass += m->body_mass[body];
    moment += m->body_mass[body] * (origin + Eigen::Vector3d(m->body_ipos + 3 * body));
  }
  const double outwards = prefix == "R" ? -1 : 1;
  EXPECT_NEAR(mass, link.mass, 1e-9) << prefix + link.bodies.front();
  EXPECT_LT((moment / mass - link.com.cwiseProduct(Eigen::Vector3d(1, outwards, 1))).norm(), 1e-9)
      << prefix + link.bodies.front();
}

TEST(RobotModel, HasTheLinksOfHrp2) {
  const World world = standing();
  for (const Link& link : kTrunk) expect_link(world.model(), link, "");
  for (const Link& link : kLeftLimbs) {
    expect_link(world.model(), link, "L");
    expect_link(world.model(), link, "R");
  }
}

// The constants that the plan is made with, against the model that is simulated.
TEST(RobotModel, HasTheMassAndCenterOfMassOfThePlanInHalfSitting) {
  const World world = standing();
  const int waist = mj_name2id(world.model(), mjOBJ_BODY, "BODY");
  EXPECT_NEAR(world.model()->body_subtreemass[waist], walking::hrp2::kMass, 1e-6);
  const Eigen::Vector3d com = world.com() - world.X_WB().translation();
  // The plan leaves out the offset to the left. The link table is rounded to 1e-5 m, and the hand's share of
  // it is an assumption.
  EXPECT_LT((com - walking::hrp2::kComInWaist - Eigen::Vector3d(0, 0.001550, 0)).norm(), 2e-5);
  EXPECT_NEAR(world.com().z(), walking::hrp2::kComHeight, 2e-5);
}

TEST(RobotModel, HasTheBushesOfLegOdometry) {
  const World world = standing();
  const auto stiffness = [&](const std::string& joint) {
    return world.model()->jnt_stiffness[mj_name2id(world.model(), mjOBJ_JOINT, joint.c_str())];
  };
  for (const std::string leg : {"RLEG_BUSH_", "LLEG_BUSH_"}) {
    EXPECT_EQ(stiffness(leg + "Z"), walking::hrp2::kBushUp_n_m);
    EXPECT_EQ(stiffness(leg + "YAW"), walking::hrp2::kBushYaw_nm_rad);
    EXPECT_EQ(stiffness(leg + "PITCH"), walking::hrp2::kBushPitch_nm_rad);
    EXPECT_EQ(stiffness(leg + "ROLL"), walking::hrp2::kBushRoll_nm_rad);
  }
}

TEST(RobotModel, HasTheSolesAndUpperArmsOfThePlan) {
  const World world = standing();
  const mjModel* m = world.model();
  for (const char* name : {"LLEG_SOLE", "RLEG_SOLE"}) {
    const int geom = mj_name2id(m, mjOBJ_GEOM, name);
    const Eigen::Vector2d middle(m->geom_pos + 3 * geom), half(m->geom_size + 3 * geom);
    EXPECT_LT((middle - half - walking::hrp2::kSoleMin).norm(), 1e-12);
    EXPECT_LT((middle + half - walking::hrp2::kSoleMax).norm(), 1e-12);
  }
  const int forearm = mj_name2id(m, mjOBJ_BODY, "LARM_LINK3");
  EXPECT_NEAR(m->body_pos[3 * forearm + 2], -walking::hrp2::kUpperArm, 1e-12);
}

TEST(RobotModel, HasTheJointsAndLegLimitsOfThePlan) {
  using namespace walking::hrp2;
  const std::vector<std::string> names = joint_names();
  EXPECT_EQ(names[kChestYaw], "CHEST_JOINT0");
  EXPECT_EQ(names[kChestPitch], "CHEST_JOINT1");
  EXPECT_EQ(names[kRightArm], "RARM_JOINT0");
  EXPECT_EQ(names[kLeftArm + kElbow], "LARM_JOINT3");
  for (int i = 0; i < 12; ++i) {
    const auto limits = walking::leg_limits(i < 6 ? walking::Side::right : walking::Side::left);
    const Limit& published = kLimits[static_cast<std::size_t>(i)];
    EXPECT_NEAR(limits.lowest(i % 6), published.low, 1e-5) << published.joint;  // six digits
    EXPECT_NEAR(limits.highest(i % 6), published.high, 1e-5) << published.joint;
  }
}

TEST(RobotModel, MovesByItsFeetAlone) {
  const World world = standing();
  const mjModel* m = world.model();
  EXPECT_EQ(m->neq, 0);  // nothing welded
  EXPECT_EQ(m->nmocap, 0);
  EXPECT_EQ(m->nu, walking::kJoints);  // servos at the joints, none at the base
  EXPECT_EQ(m->opt.gravity[2], -walking::kGravity);
  EXPECT_EQ(m->opt.timestep, 0.001);
}

}  // namespace
}  // namespace sim::physics
