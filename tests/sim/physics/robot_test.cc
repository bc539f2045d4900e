#include "sim/physics/robot.h"

#include "tests/sim/physics/test_worlds.h"
#include "tests/walking/robots.h"

namespace sim::physics {
namespace {

// The tests' table was written from published numbers, independently of the model.
TEST(ReadRobot, HasTheJointsSolesAndBushesOfThePublishedRobot) {
  const walking::Robot read = on_floor().robot, expected = walking::hrp2_robot();
  ASSERT_EQ(read.joints.size(), expected.joints.size());
  for (std::size_t i = 0; i < read.joints.size(); ++i) {
    const walking::Joint &a = read.joints[i], &b = expected.joints[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.parent, b.parent) << a.name;
    EXPECT_LT((a.axis - b.axis).norm(), 1e-12) << a.name;
    EXPECT_LT((a.offset - b.offset).norm(), i < 22 ? 1e-12 : 0.1) << a.name;
    if (i >= 16) continue;                            // the table has no ranges of the arms
    EXPECT_NEAR(a.lowest, b.lowest, 1e-5) << a.name;  // six digits
    EXPECT_NEAR(a.highest, b.highest, 1e-5) << a.name;
  }
  for (const walking::Side side : {walking::Side::right, walking::Side::left}) {
    const walking::Leg &a = read.leg(side), &b = expected.leg(side);
    EXPECT_EQ(a.joints, b.joints);
    EXPECT_LT((a.X_FS.matrix() - b.X_FS.matrix()).norm(), 1e-12);
    EXPECT_LT((a.sole_min - b.sole_min).norm() + (a.sole_max - b.sole_max).norm(), 1e-12);
    ASSERT_EQ(a.bush.size(), b.bush.size());
    for (std::size_t i = 0; i < a.bush.size(); ++i) {
      EXPECT_EQ(a.bush[i].turns, b.bush[i].turns);
      EXPECT_EQ(a.bush[i].stiffness, b.bush[i].stiffness);
      EXPECT_NEAR(a.bush[i].lag_s, b.bush[i].lag_s, 1e-12);
      EXPECT_LT((a.bush[i].axis - b.bush[i].axis).norm(), 1e-12);
    }
  }
  EXPECT_EQ(read.chest, expected.chest);
  EXPECT_NEAR(read.upper_arm, 0.25, 1e-12);
  EXPECT_NEAR(read.base_height, expected.base_height, 1e-12);
  EXPECT_NEAR(read.sole_ahead, expected.sole_ahead, 1e-12);
  EXPECT_NEAR(read.mass, 56.867992, 1e-6);
  // The model's links are rounded to 1e-5 m, and the hand's share is an assumption.
  EXPECT_LT((read.com - expected.com).norm(), 2e-5);
  EXPECT_NEAR(read.com_height(), 0.808291, 2e-5);
}

TEST(ReadRobot, ReportsMismatchesWithTheirPlace) {
  const std::string yaml = (models() / "robots/hrp2/robot.yaml").string();
  const std::vector<std::pair<std::function<void(RobotFile&, mjModel&)>, std::string>> cases{
      {[](RobotFile& f, mjModel&) { f.base = "CHEST_LINK0"; },
       yaml + ":4:7: base: body 'CHEST_LINK0' has no free joint, expected the model's first joint"},
      {[](RobotFile& f, mjModel&) { f.legs[1][2] = "HIP"; },
       ": legs.left: the model has no joint 'HIP' with a servo"},
      {[](RobotFile& f, mjModel&) { f.legs[0].pop_back(); },
       ": feet.right: body 'RLEG_SOLE' is not on the link of RLEG_JOINT4"},
      {[](RobotFile& f, mjModel&) { f.legs[0].erase(f.legs[0].begin()); },
       "the right leg is not a chain from base to foot: RLEG_JOINT1 is not on the link of "},
      {[](RobotFile& f, mjModel&) { f.posture_rad["NECK"] = 1; },
       "posture_deg.NECK: the model has no joint 'NECK'"},
      {[](RobotFile& f, mjModel&) { f.posture_rad.clear(); }, "leg cannot move its sole in every direction"},
      {[](RobotFile&, mjModel& m) { m.jnt_limited[1] = 0; }, "the right leg has no range at RLEG_JOINT0"},
      {[](RobotFile&, mjModel& m) {
         const int sole = mj_name2id(&m, mjOBJ_SITE, "right_sole");
         m.site_sameframe[sole] = 0, m.site_pos[3 * sole + 2] -= 0.02;
       },
       " m above the point sole_m, expected this point on the ground"},
      {[](RobotFile&, mjModel& m) { std::fill_n(m.geom_contype, m.ngeom, 0); },
       ": feet.right: body 'RLEG_SOLE' has no sole, expected geoms that touch the floor at several places"},
      {[](RobotFile&, mjModel& m) { m.jnt_stiffness[mj_name2id(&m, mjOBJ_JOINT, "RLEG_BUSH_YAW")] = 0; },
       "robot.xml: joint RLEG_BUSH_YAW below the ankle has neither a servo nor a stiffness"}};
  for (const auto& [change, complaint] : cases) {
    RobotFile file = robot_file();
    const Model model = copy_of(on_floor().on_floor);
    change(file, *model);
    EXPECT_THAT(files::error_of<std::invalid_argument>([&] { read_robot(*model, file); }),
                testing::HasSubstr(complaint));
  }
}

}  // namespace
}  // namespace sim::physics
