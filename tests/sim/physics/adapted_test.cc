#include "sim/physics/adapted.h"

#include <mujoco/mujoco.h>

#include <regex>

#include "sim/physics/robot.h"
#include "sim/scenario/robot.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::physics {
namespace {

using files::TemporaryFolder;
using tests::Has;

/// A file of a robot of few links in the style of public models: degrees, newer attributes, visuals without
/// meshes.
std::string given(const std::string& name) {
  return files::read_text(GAITSLAM_SOURCE_DIR "/tests/sim/physics/robot/" + name);
}
const std::string& model() {
  static const std::string text = given("robot.xml");
  return text;
}

/// The robot in a folder, with its file.
class Adapted : public testing::Test {
 protected:
  Adapted() {
    for (const char* name : {"robot.xml", "robot.yaml"}) files::write_text(folder / name, given(name));
    file = scenario::read_robot(folder.path());
  }
  void write(const std::string& text) const { files::write_text(folder / "robot.xml", text); }
  /// Writes the model with each match of a regular expression replaced.
  void change(const char* from, const std::string& to) const {
    write(std::regex_replace(model(), std::regex(from), to));
  }
  std::string guess() const { return first_robot_file(folder / "robot.xml", "robot.xml"); }
  /// Returns the guess for a changed model.
  std::string guess_with(const char* from, const std::string& to) const {
    change(from, to);
    return guess();
  }
  /// Returns the guessed file as it is read again. The robot can be read by it.
  RobotFile guessed_file() const {
    files::write_text(folder / "robot.yaml", guess());
    const RobotFile guessed = scenario::read_robot(folder.path());
    EXPECT_NO_THROW(read_robot(*load_mjcf(adapt(guessed).root, "robot.xml"), guessed));
    return guessed;
  }
  Model loaded() const { return load_mjcf(adapt(file).root, "the robot"); }
  /// Bends the knees, and leaves limits and armatures to the model.
  void bend() {
    for (RobotFile::Servo& servo : file.servos) servo.effort_nm.reset(), servo.armature_kg_m2.reset();
    for (const char* side : {"left", "right"})
      for (const auto& [part, angle] :
           {std::pair("_hip_joint", -0.15), {"_knee_joint", 0.3}, {"_ankle_joint", -0.15}})
        file.posture_rad[side + std::string(part)] = angle;
  }

  const TemporaryFolder folder;
  RobotFile file;
};
using FirstRobotFile = Adapted;

std::string rejection(const RobotFile& file) {
  try {
    load_mjcf(adapt(file).root, "the robot");
  } catch (const std::exception& e) {
    return e.what();
  }
  return "";
}

TEST_F(Adapted, RobotHasTheBenchsServosPartsAndContacts) {
  const Model model = loaded();
  const mjModel& m = *model;
  EXPECT_EQ(m.nu, 12);
  EXPECT_EQ(m.njnt, 13) << "joints without a servo are rigid";
  const auto joint_of = [&](int servo) {
    return std::string(mj_id2name(&m, mjOBJ_JOINT, m.actuator_trnid[2 * servo]));
  };
  EXPECT_EQ(joint_of(0), "left_yaw_joint") << "in the order of the model";
  EXPECT_EQ(m.actuator_gainprm[0], 1000);
  EXPECT_EQ(m.actuator_forcerange[1], 50) << "of the model";
  EXPECT_EQ(m.actuator_forcerange[13], 30) << "of robot.yaml";
  EXPECT_EQ(m.dof_damping[6], 10);
  EXPECT_EQ(m.dof_armature[6], 0.02);
  EXPECT_EQ(m.dof_damping[0], 0) << "the base";
  EXPECT_NEAR(m.jnt_range[3], M_PI / 2, 1e-12);
  const int imu = part(m, mjOBJ_SITE, "imu"), camera = part(m, mjOBJ_CAMERA, "head_camera");
  EXPECT_EQ(m.site_bodyid[imu], part(m, mjOBJ_BODY, "chest"));
  EXPECT_EQ(m.cam_bodyid[camera], part(m, mjOBJ_BODY, "head"));
  const int sole = part(m, mjOBJ_SITE, "left_sole"), box = part(m, mjOBJ_GEOM, "left_box");
  EXPECT_EQ(m.site_pos[3 * sole + 2], -0.07);
  EXPECT_EQ(m.geom_contype[box], 3);
  for (const char* sensor : {"left_force", "left_torque", "right_force", "right_torque"})
    part(m, mjOBJ_SENSOR, sensor);
  for (int geom = 0; geom < m.ngeom; ++geom) {
    const std::string body = mj_id2name(&m, mjOBJ_BODY, m.geom_bodyid[geom]);
    const bool is_box = m.geom_type[geom] == mjGEOM_BOX;
    EXPECT_EQ(m.geom_group[geom], body == "head" ? 2 : is_box && body != "chest" ? 3 : 1) << body;
    if (body == "chest") {
      EXPECT_EQ(m.geom_contype[geom] | m.geom_conaffinity[geom], 0);
    }
  }
  EXPECT_NEAR(m.body_subtreemass[0], 20, 1e-9);
}

TEST_F(Adapted, RobotThatNamesSomethingMissingInItsModelIsRejectedAtThatKey) {
  const RobotFile good = file;
  file.places["imu"] = "robot.yaml:7:1", file.imu.link = "torso";
  EXPECT_THAT(rejection(file),
              Has("robot.yaml:7:1: imu: the model has no body 'torso', expected one of arm, chest"));
  file = good, file.feet[1].contacts = {"left_toe"};
  EXPECT_THAT(rejection(file), Has("feet.left: of the contacts left_toe body 'left_foot' has 0"));
  file = good, file.feet[1].body = "left_ankle";
  EXPECT_THAT(rejection(file), Has("feet.left: body 'left_ankle' has no colliding geom, expected the sole"));
  file = good, file.feet[1].body = "left_toe";
  EXPECT_THAT(rejection(file), Has("feet.left: the model has no body 'left_toe', expected one of arm"));
  file = good, file.servos[0].joints[0] = "knee";
  EXPECT_THAT(rejection(file), Has("servos: the model has no joint 'knee'"));
  file = good, file.servos[0].joints[0] = "left_yaw_joint";
  EXPECT_THAT(rejection(file), Has("servos: joint 'left_yaw_joint' has two servos"));
  files::write_text(folder / "robot.yaml", "servos: [{joints: [knee], effort_nm: 0}]\n");
  EXPECT_THAT([&] { scenario::read_robot(folder.path()); },
              testing::ThrowsMessage<std::exception>(Has("robot.yaml:1:", "effort_nm: is '0', expected")));
  file = good, file.head_camera.link = "left_knee";
  EXPECT_THAT(rejection(file),
              Has("head_camera: link 'left_knee' is moved by a leg, expected an upper-body link"));
  file = good, file.base = "waist";
  EXPECT_THAT(rejection(file), Has("robot.xml:1: mujoco: has no body 'waist', the base"));
}

// Each part of the model is wrong once. Errors that the library itself reports also have a place.
TEST_F(Adapted, WrongModelIsRejectedWithFileLineAndElement) {
  const std::string good = model();
  const auto error_with = [&](const std::string& from, const std::string& part, const std::string& instead) {
    std::string text = good;
    text.replace(text.find(part, text.find(from)), part.size(), instead);
    write(text);
    return rejection(file);
  };
  EXPECT_EQ(error_with("left_knee", "mass='1'", "mass='2'"), "");
  for (const auto& row : tests::rows_of("sim/physics/wrong_models.txt"))
    EXPECT_THAT(error_with(row[0], row[1], row[2]), Has(row.at(3))) << row[1] << row[2];
}

/// The torques of a joint for the most negative and the most positive commands to all actuators.
std::array<double, 2> extremes(const mjModel& m, const char* joint) {
  const Data data(mj_makeData(&m));
  std::array<double, 2> torques{};
  for (const int sign : {-1, 1})  // sign of the torque
    for (int i = 0; i < m.nu; ++i) {
      std::fill_n(data->ctrl, m.nu, 0);
      data->ctrl[i] = sign * std::copysign(1e9, m.actuator_gear[6 * i]);
      mj_forward(&m, data.get());
      torques[sign > 0] += data->qfrc_actuator[m.jnt_dofadr[part(m, mjOBJ_JOINT, joint)]];
    }
  return torques;
}

/// Compares MuJoCo's own model of a user's file with the bench's.
void expect_same(const mjModel& own, const RobotFile& file) {
  const Model adapted = load_mjcf(adapt(file).root, "the robot");
  const mjModel& m = *adapted;
  const auto same = [](const mjtNum* a, const mjtNum* b, int count, const std::string& what) {
    for (int i = 0; i < count; ++i) EXPECT_NEAR(a[i], b[i], 1e-12) << what;
  };
  for (int body = 1; body < own.nbody; ++body) {
    const std::string name = mj_id2name(&own, mjOBJ_BODY, body);
    const int mine = mj_name2id(&m, mjOBJ_BODY, name.c_str());
    if (mine < 0) continue;
    same(own.body_mass + body, m.body_mass + mine, 1, name);
    same(own.body_inertia + 3 * body, m.body_inertia + 3 * mine, 3, name);
    same(own.body_ipos + 3 * body, m.body_ipos + 3 * mine, 3, name);
    same(own.body_iquat + 4 * body, m.body_iquat + 4 * mine, 4, name);
    same(own.body_pos + 3 * body, m.body_pos + 3 * mine, 3, name);
    same(own.body_quat + 4 * body, m.body_quat + 4 * mine, 4, name);
  }
  for (int servo = 0; servo < m.nu; ++servo) {
    const int mine = m.actuator_trnid[2 * servo];
    const std::string name = mj_id2name(&m, mjOBJ_JOINT, mine);
    const int joint = part(own, mjOBJ_JOINT, name), dof = own.jnt_dofadr[joint];
    same(own.jnt_range + 2 * joint, m.jnt_range + 2 * mine, 2, name);
    same(own.jnt_axis + 3 * joint, m.jnt_axis + 3 * mine, 3, name);
    same(own.dof_armature + dof, m.dof_armature + m.jnt_dofadr[mine], 1, name);
    same(own.dof_frictionloss + dof, m.dof_frictionloss + m.jnt_dofadr[mine], 1, name);
  }
}

TEST_F(Adapted, NumbersAreThoseOfMuJoCosOwnModelOfTheFile) {
  for (const char* name : {"hrp2", "g1"}) {
    const RobotFile file = scenario::read_robot(fs::path(GAITSLAM_SOURCE_DIR) / "models/robots" / name);
    RobotFile bare = file;
    for (RobotFile::Servo& servo : bare.servos) servo.armature_kg_m2.reset();
    expect_same(*load_mjcf(model_file::read_xml(file.folder / file.model), name), bare);
  }
}

TEST_F(Adapted, ClassesAnglesAndActuatorsAreThoseOfMuJoCo) {
  bend();
  std::string text = std::regex_replace(model(), std::regex(" actuatorfrcrange='-50 50'"), "");
  text = std::regex_replace(text, std::regex("(left_roll_joint'|left_hip_joint')"), "$1 class='strong'");
  text.insert(text.find("<worldbody>"), R"(<compiler autolimits='true' eulerseq='zyx' inertiafromgeom='auto'/>
    <default><joint armature='0.03' frictionloss='0.2'/><general forcerange='-7 9'/><default class='strong'>
    <joint armature='0.1' range='-10 20'/><motor ctrlrange='-1 1' forcerange='-4 4' gear='5'/></default>
    <default class='free'><motor forcelimited='false'/></default></default>)");
  text.insert(text.find("</mujoco>"), R"(<actuator><position joint='left_yaw_joint' kp='100'/>
    <motor joint='left_roll_joint' class='strong'/><motor joint='left_roll_joint' gear='-2' class='free' ctrlrange='-3 1'/>
    <motor joint='left_hip_joint' class='free'/><velocity joint='left_knee_joint' kv='1' forcerange='-1 3' gear='-2'/>
    <general joint='left_ankle_joint' gainprm='2' ctrlrange='-8 3'/></actuator>)");
  write(text);
  const Model own = load_mjcf(model_file::read_xml(folder / "robot.xml"), "the file");
  expect_same(*own, file);
  const Model adapted = loaded();
  for (const char* joint : {"left_yaw_joint", "left_roll_joint", "left_knee_joint", "left_ankle_joint"}) {
    const int servo = part(*adapted, mjOBJ_ACTUATOR, joint);
    const mjtNum* const range = adapted->actuator_forcerange + 2 * servo;
    EXPECT_THAT(extremes(*own, joint), testing::ElementsAre(testing::DoubleNear(range[0], 1e-12),
                                                            testing::DoubleNear(range[1], 1e-12)))
        << joint;
    EXPECT_TRUE(adapted->actuator_forcelimited[servo]);
  }
  EXPECT_FALSE(adapted->actuator_forcelimited[part(*adapted, mjOBJ_ACTUATOR, "left_hip_joint")]);
  const walking::Robot walker = read_robot(*adapted, file);
  EXPECT_EQ(walker.joints[3].lowest_effort, -6);
  EXPECT_EQ(walker.joints[3].effort, 2);
}

// MuJoCo 2.2.2 does not know these attributes.
TEST_F(Adapted, ForceRangesOfJointsLimitTheirActuatorsUnlessTheyAreSwitchedOff) {
  std::string text = std::regex_replace(model(), std::regex("(left_knee_joint'.*range='-50) 50'"), "$1 40'");
  text = std::regex_replace(text, std::regex("left_ankle_joint'"), "$& class='off'");
  text.insert(text.find("<worldbody>"),
              "<default><default class='off'><joint actuatorfrclimited='false'/></default></default>");
  text.insert(text.find("</mujoco>"),
              "<actuator><motor joint='left_knee_joint' ctrlrange='-30 90'/></actuator>");
  write(text);
  const Model m = loaded();
  const auto range = [&](const char* joint) {
    const int servo = part(*m, mjOBJ_ACTUATOR, joint);
    return std::pair(m->actuator_forcerange[2 * servo], m->actuator_forcerange[2 * servo + 1]);
  };
  EXPECT_EQ(range("left_knee_joint"), std::pair(-30.0, 40.0));
  EXPECT_EQ(range("left_hip_joint"), std::pair(-50.0, 50.0));
  EXPECT_FALSE(m->actuator_forcelimited[part(*m, mjOBJ_ACTUATOR, "left_ankle_joint")]);
}

TEST_F(Adapted, FramesMeshesAndBodiesWithoutMassLeaveEverythingInItsPlace) {
  const std::string mesh = "vertex='0 0 0 .1 0 0 0 .1 0 0 0 .1 .2 .1 .1' scale='1 2 1'";
  std::string text = std::regex_replace(
      model(), std::regex("<geom type='box' size='0.1 0.2 0.2'/>"),
      "<frame pos='0 0 1' euler='0 90 0'><frame pos='1 0 0'>"
      "<geom name='shape' type='mesh' mesh='m' pos='0 .1 0' euler='30 0 0'/></frame></frame>");
  text.insert(text.find("<worldbody>"), "<asset><mesh name='m' " + mesh + "/></asset>");
  text.replace(text.find("<body name='pelvis' pos='0 0 1'><joint type='free'/>"), 52,
               "<body name='footprint' pos='0 0 1'><joint type='free'/><inertial pos='0 0 0' mass='0' "
               "diaginertia='0 0 0'/>"
               "<body name='pelvis'>");
  text.insert(text.find("</worldbody>"), "</body>");
  write(text);
  const Model m = loaded();
  EXPECT_EQ(m->nbody, 17);
  EXPECT_EQ(part(*m, mjOBJ_BODY, "pelvis"), 1);
  const Data data(mj_makeData(m.get()));
  mj_kinematics(m.get(), data.get());
  const int geom = part(*m, mjOBJ_GEOM, "shape");
  EXPECT_EQ(m->geom_bodyid[geom], part(*m, mjOBJ_BODY, "chest"));
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : corners(*m, *data, geom, Eigen::Isometry3d::Identity())) box.extend(p);
  // The chest is at z = 1.3; the frames are at z = 1 and, turned, 1 below: the shape's x axis points down.
  EXPECT_NEAR(box.min().z(), 1.1, 1e-6);
  EXPECT_NEAR(box.max().z(), 1.3, 1e-6);
  EXPECT_NEAR(box.min().y(), 0.1 - 0.1 * std::sin(M_PI / 6), 1e-6);
}

TEST_F(Adapted, NamesWithSlashesAndBlanksAreThoseOfTheModel) {
  change("left_", "robot/left ");
  EXPECT_EQ(guessed_file().feet[1].body, "robot/left foot");
}

// The same robot as MJCF and as URDF.
TEST_F(Adapted, AUrdfIsReadByMuJoCo) {
  const std::string text = given("robot.urdf");
  files::write_text(folder / "robot.urdf", text);
  file.model = "robot.urdf";
  bend();
  const Model m = loaded();
  EXPECT_NEAR(m->body_subtreemass[part(*m, mjOBJ_BODY, "pelvis")], 15, 1e-12);
  EXPECT_EQ(m->jnt_type[0], mjJNT_FREE);
  EXPECT_EQ(m->jnt_bodyid[0], part(*m, mjOBJ_BODY, "pelvis"));
  EXPECT_EQ(m->actuator_forcerange[0], -50);
  const walking::Robot walker = read_robot(*m, file);
  EXPECT_NEAR(walker.base_height, 0.17 + 0.6 * std::cos(0.15), 1e-9);
  EXPECT_EQ(walker.joints[0].highest, 1.5);
  for (const auto& [joints, error] :
       {std::pair("<joint name='a' type='fixed'><parent link='chest'/><child link='head'/></joint>",
                  "joint: URDF body has multiple parents"),
        {"<joint name='a' type='fixed'><parent link='none'/><child link='tail'/></joint><link name='tail'/>",
         "joint: URDF joint parent or child missing"},
        {"<joint name='a' type='fixed'><parent link='a'/><child link='a'/></joint><link name='a'/>",
         "link: URDF body not found"}}) {
    files::write_text(folder / "robot.urdf",
                      tests::replaced(text, "</robot>", joints + std::string("</robot>")));
    EXPECT_THAT(rejection(file), Has("robot.urdf:32: " + std::string(error)));
  }
}

TEST_F(Adapted, LinksFixedToAFootBelongToItsSole) {
  change("<geom name='(left|right)_box'[^>]*>",
         "<body name='$1_toe'><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>$&</body>");
  const Model m = loaded();
  EXPECT_EQ(contacts(*m, part(*m, mjOBJ_BODY, "left_foot")), std::vector{part(*m, mjOBJ_GEOM, "left_box")});
  EXPECT_THAT(guess(), Has("  left: {body: left_foot, sole_m: [0, 0, -0.07]}\n"));
}

TEST_F(Adapted, SolesCountEvenIfOnlyAPairOrAFloorWithOtherBitsTouchesThem) {
  for (const char* bits : {"2", "0"}) {
    change("_box' ", fmt::format("$&contype='{0}' conaffinity='{0}' ", bits));
    if (*bits == '0') file.feet[0].contacts = {"right_box"}, file.feet[1].contacts = {"left_box"};
    const Model m = loaded();
    EXPECT_EQ(contacts(*m, part(*m, mjOBJ_BODY, "left_foot")), std::vector{part(*m, mjOBJ_GEOM, "left_box")})
        << bits;
  }
}

TEST_F(FirstRobotFile, RobotsWithWeakAnklesStandBehindTheMiddleOfTheirSoles) {
  const auto knees = [&](const char* ankle) {
    const std::string guess =
        guess_with("(_ankle_joint' axis='0 1 0' range='-90 90' actuatorfrcrange=)'-50 50'", ankle);
    return guess.substr(guess.find("posture_deg"), guess.find("servos") - guess.find("posture_deg"));
  };
  EXPECT_EQ(knees("$1'-50 50'"), knees("$1'-80 80'"));
  EXPECT_NE(knees("$1'-50 50'"), knees("$1'-1 1'"));
}

TEST_F(FirstRobotFile, RobotsWithWeakHipsStepFasterAndNearerToTheMiddle) {
  const auto with_hips_of = [&](const char* effort) {  // 20 kg * 9.81 m/s^2 * 0.1 m = 20 N m
    return guess_with("(_roll_joint' axis='1 0 0' range='-90 90' actuatorfrcrange=)'-50 50'", effort);
  };
  EXPECT_THAT(with_hips_of("$1'-50 50'"), Has("walk: {single_support_s: 0.6, "));
  EXPECT_THAT(with_hips_of("$1'-20 20'"), Has("walk: {single_support_s: 0.5, ", "zmp_inwards_m: 0.03, "));
}

TEST_F(FirstRobotFile, AnUpsideDownFootIsTurnedBack) {
  change(
      "(_foot' pos='0 0 0')(>[^>]*>[^>]*)axis='1 0 0'([^>]*>"
      "<geom name='[a-z]+_box' type='box' )size='0.1 0.05 0.01' pos='0.02 0 -0.06'",
      "$1 quat='0 0.7071068 0 0.7071068'$2axis='0 0 1'$3size='0.01 0.05 0.1' pos='-0.06 0 0.02'");
  EXPECT_NEAR(std::abs(guessed_file().feet[0].sole_pitch_rad), std::numbers::pi / 2, 1e-5);
}

TEST_F(FirstRobotFile, ASoleThatIsTiltedAtZeroAnglesIsLaidFlat) {
  for (const char* shape : {"type='box' size='0.1 0.05 0.01'", "type='mesh' mesh='sole'"}) {
    std::string tilted = std::regex_replace(model(), std::regex("type='box' size='0.1 0.05 0.01' pos='0.02"),
                                            fmt::format("{} euler='0 20 0' pos='0.02", shape));
    tilted.insert(tilted.find("<worldbody>"),
                  "<asset><mesh name='sole' vertex='-.1 -.05 -.01  .1 -.05 -.01  -.1 .05 -.01  .1 .05 -.01  "
                  "-.1 -.05 .01  .1 -.05 .01  -.1 .05 .01  .1 .05 .01'/></asset>");
    write(tilted);
    EXPECT_NEAR(guessed_file().feet[0].sole_pitch_rad, 20 * std::numbers::pi / 180, 1e-6) << shape;
  }
}

TEST_F(FirstRobotFile, RobotsThatFaceBackwardAndQuadrupedsAreRejected) {
  const auto rejects = [](const char* text) { return testing::ThrowsMessage<std::runtime_error>(Has(text)); };
  EXPECT_THAT(
      [&] { guess_with("pos='0.02 0 -0.06'", "pos='-0.04 0 -0.06'"); },
      rejects("the toes point backward at right_foot: expected the x axis of the base 'pelvis' ahead"));
  EXPECT_THAT([&] { guess_with("(_knee_joint' axis='0 1 0') range='-90 90'", "$1 range='-90 5'"); },
              rejects("the knee bends backward at right_foot"));
  EXPECT_THAT([&] { guess_with("(<body name='arm' pos=)'0 0.2 0.2'", "$1'0 -.3 -.95'"); },
              testing::Not(rejects("four legs")));
  std::string text = model();
  text.insert(text.find("<body name='left_yaw'"),
              "<body name='fore' pos='.5 .1 -.7'><joint axis='0 1 0' name='a' range='-1 1'/><inertial pos='0 "
              "0 0' mass='1' "
              "diaginertia='1 1 1'/></body><body name='fore2' pos='.5 -.1 -.7'><joint axis='0 1 0' name='b' "
              "range='-1 1'/>"
              "<inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/></body>");
  write(text);
  EXPECT_THAT([&] { guess(); }, rejects("robot.xml: has four legs, "));
}

TEST_F(FirstRobotFile, JointsWithoutARangeAreRigidButNotInALegAndLegsMustBend) {
  EXPECT_THAT(guess_with("(arm_joint' axis='0 1 0') range='-90 90'", "$1"),
              Has("since the model gives no range: arm_joint\n"));
  EXPECT_THAT([&] { guess_with("(knee_joint' axis='0 1 0') range='-90 90'", "$1"); },
              testing::ThrowsMessage<std::runtime_error>(
                  Has("robot.xml: the leg's joint 'right_knee_joint' has no range")));
  EXPECT_THAT([&] { guess_with("axis='[01] [01] 0'", "axis='0 0 1'"); },
              testing::ThrowsMessage<std::runtime_error>(Has("robot.xml: has no posture with flat soles")));
}

TEST_F(FirstRobotFile, AJointThatCarriesBothLegsIsLeftRigid) {
  std::string text = model();
  text.insert(text.find("<body name='chest'"), "</body>");
  text.insert(text.find("<body name='left_yaw'"),
              "<body name='hips'><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>"
              "<joint name='waist' axis='0 0 1' range='-90 90'/>");
  write(text);
  EXPECT_THAT(guess(), Has("  left: [left_yaw_joint, ", "moves legs on the base: waist\n"));
  EXPECT_THAT(guess(), tests::Lacks("[waist", ", waist"));
}

TEST_F(FirstRobotFile, ObliqueHipsAreTurnedUntilTheSolesAreLevel) {
  change("hip_joint' axis='0 1 0'", "hip_joint' axis='0.4 0.9 0'");
  EXPECT_GT(guessed_file().posture_rad.size(), 6u);
}

TEST_F(FirstRobotFile, GuessesFeetLegsChestHeadAndMarksEachGuess) {
  EXPECT_THAT(
      guess(),
      Has("base: pelvis\n", "head_camera: {link: head, position_m: [0.1, 0, 0.08]}  # guess",
          "imu: {link: chest, position_m: [0, 0, 0.1]}  # guess: as in the model",
          "  left: [left_yaw_joint, left_roll_joint, left_hip_joint, left_knee_joint, left_ankle_joint, "
          "left_foot_joint]\n",
          "  right: {body: right_foot, sole_m: [0, 0, -0.07]}\n", "left_hip_joint: -", "left_knee_joint: 39.",
          ", armature_kg_m2: ", "walk: {single_support_s: 0.6", "step_length_m: 0.12, "));
  EXPECT_THAT(guess_with("_knee_joint' ", "$&stiffness='2' "), Has("left_knee_joint: 39."));
  EXPECT_THAT(guess_with("<joint ", "<joint armature='0.01' "), Not(Has("armature")));
  EXPECT_THAT(guess_with("<joint (?!name='\\w+_ankle_)", "$&armature='0.01' "),  // as in some public models
              Has("joints: [right_foot_joint, left_foot_joint],\n     kp_nm_rad: 800, kd_nms_rad: 4.0}\n",
                  "joints: [right_ankle_joint, left_ankle_joint],\n     kp_nm_rad: 800, kd_nms_rad: 4.0, "
                  "armature_kg_m2: 0.008}\n"));
  write(
      "<mujoco><worldbody><body name='b'><freejoint/><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>"
      "</body></worldbody></mujoco>");
  EXPECT_THAT([&] { guess(); }, testing::ThrowsMessage<std::runtime_error>(Has("robot.xml: lacks two feet")));
}

TEST_F(FirstRobotFile, SensorsAreWhereTheModelHasThem) {
  constexpr const char* kChest = "<geom type='box' size='0.1 0.2 0.2'/>";
  const std::string links =
      "<body name='d435_link' pos='0.05 0 0.4' euler='0 47.6 0'/>"
      "<body name='wide_camera' pos='0.1 0 0'/><body name='mid360_link' pos='0 0 0.42' euler='180 0 0'/>";
  EXPECT_THAT(guess_with(kChest, kChest + links),
              Has("head_camera: {link: chest, position_m: [0.05, 0, 0.4], tilt_deg: 47.6}  # guess: as in"));
  EXPECT_EQ(guessed_file().head_camera.position_m.z(), 0.4);
  EXPECT_THAT(physics::FirstRobotFile(folder / "robot.xml").rig(),
              Has("rig:\n  - lidar: {link: chest, position_m: [0, 0, 0.42], roll_deg: 180}\n"));
  EXPECT_THAT(
      guess_with("<body name='chest'", "<site name='imu_in_pelvis' pos='0.04 0 -0.08' euler='0 0 90'/>$&"),
      Has("imu: {link: chest, position_m: [0, 0, 0.1]}"));
  EXPECT_THAT(physics::FirstRobotFile(folder / "robot.xml").rig(),
              Has("\n  - imu: {name: imu1, link: pelvis, position_m: [0.04, 0, -0.08], yaw_deg: 90}\n"));
}

TEST_F(FirstRobotFile, OpticalFramesAndCamerasOfMuJoCoLookAhead) {
  constexpr const char* kChest = "<geom type='box' size='0.1 0.2 0.2'/>";
  for (const char* camera : {"<body name='camera_link' pos='0.1 0 0.2' xyaxes='0 -1 0 0 0 -1'/>",
                             "<camera name='oak' pos='0.1 0 0.2' xyaxes='0 -1 0 0 0 1'/>",
                             "<body name='camera_link' pos='0.1 0 0.2' euler='0 90 0'/>",  // z ahead
                             "<body name='zed' pos='-0.1 0 0.2' euler='0 0 180'/>"
                             "<body name='camera_link' pos='0.1 0 0.2'/>"}) {
    write(std::regex_replace(given("robot.xml"), std::regex(kChest), std::string(kChest) + camera));
    EXPECT_THAT(guess(), Has("head_camera: {link: chest, position_m: [0.1, 0, 0.2]}  # guess: as in"));
  }
  EXPECT_THAT(guess_with("<body name='head'", "$& euler='0 60 0'"),
              Has("tilt_deg: -60}  # guess: in front of"));
}

}  // namespace
}  // namespace sim::physics
