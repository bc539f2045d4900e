#include <gtest/gtest.h>

#include "tests/sim/physics/test_worlds.h"
#include "walking/kinematics.h"

namespace sim::physics {
namespace {

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
  const World world = standing();
  const std::vector<std::string> names = joint_names();
  EXPECT_EQ(names[kChestYaw], "CHEST_JOINT0");
  EXPECT_EQ(names[kChestPitch], "CHEST_JOINT1");
  EXPECT_EQ(names[kRightArm], "RARM_JOINT0");
  EXPECT_EQ(names[kLeftArm + kElbow], "LARM_JOINT3");
  for (int i = 0; i < 12; ++i) {
    const auto limits = walking::leg_limits(i < 6 ? walking::Side::right : walking::Side::left);
    const std::string& name = names[static_cast<std::size_t>(i)];
    const mjtNum* const range =
        world.model()->jnt_range + 2 * mj_name2id(world.model(), mjOBJ_JOINT, name.c_str());
    EXPECT_NEAR(limits.lowest(i % 6), range[0], 1e-5) << name;  // six digits
    EXPECT_NEAR(limits.highest(i % 6), range[1], 1e-5) << name;
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
