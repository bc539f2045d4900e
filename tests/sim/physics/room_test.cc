#include "tests/sim/physics/test_worlds.h"

namespace sim::physics {
namespace {

using files::error_of, files::TemporaryFolder;
using tests::Has;

Model in_room(const TemporaryFolder& folder, const std::string& world, Shapes shapes = Shapes::all) {
  files::write_text(folder / "room.xml", "<mujoco>\n" + world + "</mujoco>");
  return load_model(robot_file("g1"), folder / "room.xml", models(), shapes);
}

constexpr const char* kFloor = "<worldbody><geom name='floor' type='plane' size='9 9 1'/></worldbody>";

TEST(Room, WhatIsWrongIsRejectedAtItsElement) {
  const TemporaryFolder folder;
  for (const auto& row : tests::rows_of("sim/physics/wrong_rooms.txt")) {
    const std::string world = tests::replaced(row[0], "FLOOR", kFloor);
    EXPECT_THAT(error_of([&] { in_room(folder, world); }), Has(row.at(1))) << world;
  }
}

TEST(Room, NamesThatAreAlsoTheRobotsDoNotClash) {
  const TemporaryFolder folder;
  const Model model = in_room(
      folder, std::string(kFloor) + "<worldbody><body name='pelvis'><geom size='1'/></body></worldbody>");
  EXPECT_EQ(model->jnt_bodyid[0], part(*model, mjOBJ_BODY, "pelvis"));
  part(*model, mjOBJ_BODY, "pelvis of the room");
}

TEST(Room, ClassesAndAnglesOfARoomAreItsOwn) {
  const TemporaryFolder folder;
  const std::string text = std::string(kFloor) + R"(<compiler eulerseq='zyx'/><default><geom rgba='1 0 0 1'/>
      <default class='floor'><geom contype='0' friction='.5'/><default class='ramp'/></default></default>
      <worldbody><frame pos='0 0 1'><geom name='ball' size='.1' pos='1 0 0' euler='0 0 90'/></frame>
      <geom name='step' class='ramp' type='box' size='.1 .1 .1'/></worldbody>)";
  const Model model = in_room(folder, text);
  const int ball = part(*model, mjOBJ_GEOM, "ball"), step = part(*model, mjOBJ_GEOM, "step");
  EXPECT_EQ(model->geom_pos[3 * ball + 2], 1);
  EXPECT_NEAR(model->geom_quat[4 * ball + 1], std::sqrt(0.5), 1e-12) << "a turn about x comes last";
  EXPECT_EQ(model->geom_rgba[4 * ball + 1], 0);
  EXPECT_EQ(model->geom_friction[3 * step], 0.5);
  const Model floor = in_room(folder, text, Shapes::floor);
  part(*floor, mjOBJ_GEOM, "step");
  EXPECT_LT(mj_name2id(floor.get(), mjOBJ_GEOM, "ball"), 0);
  const int sole = part(*floor, mjOBJ_SITE, "left_sole");
  EXPECT_EQ(floor->geom_rgba[4 * contacts(*floor, floor->site_bodyid[sole]).at(0) + 1],
            model->geom_rgba[4 * contacts(*model, model->site_bodyid[sole]).at(0) + 1]);
}

}  // namespace
}  // namespace sim::physics
