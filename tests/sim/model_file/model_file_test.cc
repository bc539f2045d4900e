#include "sim/model_file/model_file.h"

#include <numbers>

#include "tests/sim/files/temporary_folder.h"

namespace sim::model_file {
namespace {

using files::error_of, files::TemporaryFolder;
using testing::ElementsAre, testing::EndsWith, testing::Pair;
using tests::Has, tests::Lacks;

/// The schema of a small library, in the form that mj_printSchema writes.
const Schema& schema() {
  static const Schema known(R"(mujoco (!)                    model 
   compiler (*)               angle eulerseq meshdir autolimits 
                              balanceinertia settotalmass 
   default (R)                class 
   asset (*)                  
      mesh (*)                name file scale vertex 
      material (*)            name texture rgba 
      texture (*)             name type builtin file 
   (world)body (R)            name pos quat axisangle euler 
      inertial (?)            pos mass diaginertia fullinertia 
      joint (*)               name type axis range ref damping limited 
      freejoint (*)           name 
      geom (*)                name type size pos quat euler fromto 
                              mesh material mass density rgba 
                              friction contype conaffinity 
      site (*)                name pos quat 
      light (*)               dir         directional 
   visual (*)                 
      headlight (?)           active 
   equality (*)               
      connect (*)             body1 body2 anchor active 
)");
  return known;
}

constexpr const char* kInertial = "<inertial pos='0 0 0' mass='2' diaginertia='1 1 1'/>";

/// Reads a robot.xml whose root has this content; %I stands for an inertial.
ModelFile read(const TemporaryFolder& folder, const std::string& content, const Parts& parts = {}) {
  files::write_text(folder / "robot.xml",
                    tests::replaced("<mujoco model='m'>\n" + content + "</mujoco>", "%I", kInertial));
  return read_model(folder / "robot.xml", schema(), parts);
}
/// The same for a base with this content.
ModelFile read_base(const TemporaryFolder& folder, const std::string& content, const std::string& more = "") {
  return read(folder, "<compiler angle='radian'/>" + more + "<worldbody><body name='base'><freejoint/>%I\n" +
                          content + "</body></worldbody>");
}
const Element& body_of(const ModelFile& model) { return model.root.child("worldbody")->children.at(0); }
std::vector<std::string> notes_of(const ModelFile& model, Fate fate) {
  std::vector<std::string> all;
  for (const Note& note : model.notes)
    if (note.fate == fate) all.push_back(note.what + " x" + std::to_string(note.count));
  return all;
}
auto Near(const std::vector<double>& values) {
  return testing::Pointwise(testing::DoubleNear(1e-12), values);
}
/// Position and quaternion (w x y z).
void expect_place(const Element& element, const std::vector<double>& p, const std::vector<double>& q) {
  EXPECT_THAT(numbers(element, "pos", 3, 3), Near(p));
  EXPECT_THAT(numbers(element, "quat", 4, 4), Near(q));
}

TEST(ModelFile, OnlyTheRobotIsKeptAndItsMotorLimitsAreStoredSeparately) {
  const TemporaryFolder folder;
  const ModelFile model = read(folder, R"(
    <compiler angle='radian' autolimits='true'/>
    <option integrator='implicitfast'/><sensor><contact/></sensor><keyframe><key ctrl='0'/></keyframe>
    <default><joint damping='3' actuatorfrclimited='true'/><default class='strong'><motor ctrlrange='-9 9'/></default></default>
    <worldbody>
      <light/><geom type='plane' name='floor'/><body name='table'/>
      <body name='base'><joint type='free' name='root'/>%I<camera mode='targetbody'/>
        <body name='leg' gravcomp='0'><joint name='hip' actuatorfrcrange='-88 88' range='-1 1'/>%I
          <body name='foot'><joint name='ankle' range='-1 1'/>%I</body></body></body>
    </worldbody>
    <actuator><position joint='hip' kp='100' kv='2'/><motor class='strong' joint='ankle' gear='10'/></actuator>
)");
  EXPECT_THAT(to_xml(model.root), Lacks("floor", "table", "light", "camera", "actuator", "default",
                                        "gravcomp", "actuatorfrc", "implicitfast", "sensor"));
  EXPECT_EQ(body_of(model).children.at(0).name, "freejoint");
  EXPECT_EQ(body_of(model).children.at(0).attributes.size(), 1u) << "the free base has no damping";
  EXPECT_EQ(body_of(model).children.at(2).child("joint")->get("damping"), "3");
  EXPECT_THAT(model.efforts, testing::UnorderedElementsAre(Pair("ankle", 90), Pair("hip", 88)));
  EXPECT_EQ(model.mass_kg, 6);
  EXPECT_THAT(notes_of(model, Fate::dropped), testing::Contains("joint actuatorfrclimited x2"));
  EXPECT_THAT(
      notes_of(model, Fate::converted),
      ElementsAre("joint of type free: a freejoint, without damping x1", "body gravcomp 0: left out x1"));
}

TEST(ModelFile, ATotalMassScalesTheMassesUnlessItIsNegative) {
  const TemporaryFolder folder;
  const ModelFile scaled = read_base(folder, "", "<compiler settotalmass='5'/>");
  EXPECT_EQ(scaled.mass_kg, 5);
  EXPECT_THAT(notes_of(scaled, Fate::converted),
              ElementsAre("settotalmass: masses of 2 kg scaled to 5 kg x1"));
  EXPECT_EQ(read_base(folder, "", "<compiler settotalmass='-1'/>").mass_kg, 2);
}

TEST(ModelFile, DefaultsOfAClassAndItsParentsAreWrittenOut) {
  const TemporaryFolder folder;
  const ModelFile model =
      read_base(folder, R"(
      <geom name='a' class='soft'/><geom name='b' friction='0.5' type='sphere'/>
      <body childclass='soft'><geom name='c' fromto='0 0 0 0 0 1'/></body>)",
                R"(<default class='top'><geom type='box' friction='1 0.1 0.2' pos='0 0 1'/>
      <default class='soft'><geom friction='2'/></default></default>)");
  const auto geom = [&](std::size_t i) { return body_of(model).children.at(2 + i); };
  EXPECT_EQ(geom(0).get("friction"), "2 0.1 0.2");
  EXPECT_EQ(geom(0).get("type"), "box");
  EXPECT_EQ(geom(1).get("friction"), "0.5 0.1 0.2");
  EXPECT_EQ(geom(1).get("type"), "sphere");
  EXPECT_EQ(geom(2).children.at(0).get("friction"), "2 0.1 0.2");
}

TEST(ModelFile, AFrameLeavesItsContentInTheBodyAtTheSamePlace) {
  const TemporaryFolder folder;
  const ModelFile model = read_base(folder, R"(
      <frame pos='1 0 0' euler='0 0 1.5707963267948966'><frame pos='1 0 0'>
        <geom type='box' pos='0 2 0'/><geom type='capsule' fromto='0 0 0 1 0 0'/></frame></frame>)");
  const double r = std::sqrt(0.5);
  expect_place(body_of(model).children.at(2), {-1, 1, 0}, {r, 0, 0, r});
  EXPECT_THAT(numbers(body_of(model).children.at(3), "fromto", 6, 6), Near({1, 1, 0, 1, 2, 0}));
}

TEST(ModelFile, DegreesAndAnySequenceOfEulerAnglesBecomeRadiansAndQuaternions) {
  const TemporaryFolder folder;
  const ModelFile model =
      read(folder, R"(<compiler eulerseq='ZYX'/><worldbody><body name='base' euler='90 0 90'>
      <freejoint/>%I<body name='leg' axisangle='1 0 0 180'><joint name='hip' range='-90 45' ref='180'/>
      <joint name='rail' type='slide' range='-90 45'/>%I</body></body></worldbody>)");
  expect_place(body_of(model), {0, 0, 0}, {0.5, 0.5, -0.5, 0.5});
  const Element& leg = body_of(model).children.at(2);
  expect_place(leg, {0, 0, 0}, {0, 1, 0, 0});
  const double pi = std::numbers::pi;
  EXPECT_THAT(numbers(leg.children.at(0), "range", 2, 2), ElementsAre(-pi / 2, pi / 4));
  EXPECT_THAT(numbers(leg.children.at(0), "ref", 1, 1), ElementsAre(pi));
  EXPECT_EQ(leg.children.at(1).get("range"), "-90 45");
}

TEST(ModelFile, IncludesAndAssetsAreFoundRelativeToTheFile) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "parts");
  files::write_text(folder / "parts/leg.STL", "");
  files::write_text(folder / "assets.xml", R"(<mujoco><compiler meshdir='parts'/><asset>
      <mesh file='leg.STL' content_type='model/stl'/><mesh name='unused' file='none.stl'/>
      <material name='skin' texture='cloth'/><texture name='cloth' builtin='flat'/></asset></mujoco>)");
  const ModelFile model = read_base(folder, "<geom mesh='leg' material='skin' mass='0'/><geom material=''/>",
                                    "<include file='assets.xml'/>");
  const Element& geom = body_of(model).children.at(2);
  EXPECT_THAT(geom.attributes,
              ElementsAre(Pair("mesh", "robot/leg"), Pair("material", "robot/skin"), Pair("mass", "0")));
  EXPECT_TRUE(body_of(model).children.at(3).attributes.empty());
  const std::vector<Element>& assets = model.root.child("asset")->children;
  ASSERT_EQ(assets.size(), 3u);
  EXPECT_EQ(assets[0].get("name"), "robot/leg");
  EXPECT_EQ(assets[0].get("file"), (folder / "parts/leg.STL").string());
  EXPECT_EQ(assets[1].get("texture"), "robot/cloth");
}

TEST(ModelFile, ThreeSlidesAndABallFormAFreeBase) {
  const TemporaryFolder folder;
  const ModelFile model = read(folder, R"(<worldbody><body name='base'>%I<joint type='slide' axis='1 0 0'/>
      <joint type='slide' axis='0 1 0'/><joint type='slide' axis='0 0 1'/><joint type='ball'/></body></worldbody>)");
  EXPECT_EQ(body_of(model).children.at(0).name, "freejoint");
  EXPECT_EQ(body_of(model).children.size(), 2u);
}

TEST(ModelFile, AFloorInAContactPairIsRejectedUnlessRobotYamlNamesTheContactsOfTheFeet) {
  const TemporaryFolder folder;
  const auto paired = [&](const Parts& parts) {
    return read(folder,
                "<worldbody><body name='base'><freejoint/>%I<geom name='sole' size='1'/></body></worldbody>"
                "<contact><pair geom1='sole' geom2='floor'/></contact>",
                parts);
  };
  EXPECT_EQ(paired({"", std::vector<std::string>{"sole"}}).root.child("contact"), nullptr);
  EXPECT_THAT(paired({}).paired_with_floor, ElementsAre("sole"));
  EXPECT_THAT(error_of([&] {
                paired({"", std::vector<std::string>()});
              }),
              Has("robot.xml:2: pair geom2: is 'floor', which is not a geom of the robot"));
}

TEST(ModelFile, UnsupportedContentIsRejectedWithFileLineElementAndAttribute) {
  const TemporaryFolder folder;
  const std::pair<std::string, std::string> cases[]{
      {"<geom szie='1'/>",
       "robot.xml:3: geom szie: is not known to this MuJoCo, expected one of conaffinity"},
      {"<plugin/>", "robot.xml:3: plugin: is not known to this MuJoCo in body"},
      {"<composite/>", "robot.xml:3: composite: is not known"},
      {"<body gravcomp='1'/>", "robot.xml:3: body gravcomp: is not 0"},
      {"<body name='leg'><joint name='hip'/></body>", "robot.xml:3: body: 'leg' moves but has no mass"},
      {"<body name='leg'><joint/><geom mesh='m'/></body>",
       "robot.xml:3: geom mesh: would define the inertia of 'leg'"},
      {"<body><joint/><inertial mass='1' diaginertia='0 0 0'/></body>",
       "inertial diaginertia: has principal moments 0, 0 and 0"},
      {"<body><inertial mass='1' diaginertia='1 1 3'/></body>",
       "inertial diaginertia: has principal moments 1, 1 and 3"},
      {"<body><inertial mass='1' fullinertia='1 1 1 2 0 0'/></body>",
       "inertial fullinertia: has principal moments -1,"},
      {"<body><inertial diaginertia='1 1 1'/></body>", "inertial mass: is missing"},
      {"<body><joint type='free'/>%I</body>",
       "robot.xml:3: joint type: is free, expected a free joint only on the base"},
      {"<frame><joint/></frame>", "robot.xml:3: joint: is in a frame, expected it directly in the body"},
      {"<geom class='none'/>", "robot.xml:3: geom class: 'none' is not a default class"},
      {"<frame pos='1 2'/>", "robot.xml:3: frame pos: has 2 numbers, expected 3"},
      {"<frame euler='1 2 x'/>", "robot.xml:3: frame euler: has 'x', expected a number"},
      {"<geom>", "robot.xml:3: is not XML"}};
  for (const auto& [content, error] : cases)
    EXPECT_THAT(error_of([&, &content = content] { read_base(folder, content); }), Has(error)) << content;
  const std::pair<std::string, std::string> sections[]{
      {"<include file='none.xml'/>", "none.xml does not exist"},
      {"<include file='robot.xml'/>", "is included twice"},
      {"<extension/>", "robot.xml:2: extension: is not read, expected one of compiler"},
      {"<equality><connect body1='base'/></equality>", "robot.xml:2: connect: closes a loop of bodies"},
      {"<default><default/></default>", "robot.xml:2: default class: is missing"},
      {"<compiler coordinate='global'/>", "robot.xml:2: compiler coordinate: is global"}};
  for (const auto& [more, error] : sections)
    EXPECT_THAT(error_of([&, &more = more] { read_base(folder, "", more); }), Has(error)) << more;
  for (const auto& [file, error] :
       {std::pair("leg.dae", "is 'leg.dae', expected a .stl or .obj file"), {"leg.stl", "does not exist"}})
    EXPECT_THAT(error_of([&, &file = file] {
                  read_base(folder, "<geom mesh='leg' mass='0'/>",
                            std::string("<asset><mesh file='") + file + "'/></asset>");
                }),
                Has("robot.xml:2: mesh file: ", error));
  EXPECT_THAT(error_of([&] { read(folder, "<worldbody><body name='base'>%I</body></worldbody>"); }),
              Has("robot.xml:2: body: 'base' is the base but has no free joint"));
  EXPECT_THAT(error_of([&] { read(folder, "<worldbody/>"); }),
              Has("worldbody: has no body, expected a robot"));
}

TEST(ModelFile, ARoomKeepsItsLightsAndNamesAndMayNotMove) {
  const TemporaryFolder folder;
  const auto room = [&](const std::string& world) {
    files::write_text(folder / "room.xml",
                      "<mujoco><option timestep='1'/><visual><headlight active='1'/></visual>"
                      "<compiler angle='degree'/><asset><material name='wood'/></asset><default><geom "
                      "material='wood'/></default>"
                      "<worldbody><body><geom name='floor' type='plane'/></body>" +
                          world + "</worldbody></mujoco>");
    return read_room(folder / "room.xml", schema());
  };
  const ModelFile kept = room("<light type='directional'/><camera/><body euler='0 0 180'><geom/></body>");
  EXPECT_THAT(to_xml(kept.root), Has("<headlight active=\"1\"/>", "<light directional=\"true\"/>",
                                     "material name=\"wood\"", "material=\"wood\""));
  EXPECT_THAT(to_xml(kept.root), Lacks("camera", "option", "euler"));
  // The class floor needs no declaration; its geoms have the file's defaults and the bits of floors.
  EXPECT_THAT(to_xml(room("<geom class='floor' type='box' size='1 1 1'/>").root),
              Has("<geom type=\"box\" size=\"1 1 1\" contype=\"9\" conaffinity=\"9\" material=\"wood\"/>"));
  EXPECT_THAT(error_of([&] { room("<body><joint/></body>"); }),
              Has("joint: is in a room, expected shapes that do not move"));
  EXPECT_THAT(error_of([&] {
                files::write_text(folder / "room.xml", "<mujoco/>");
                read_room(folder / "room.xml", schema());
              }),
              Has("worldbody: has no plane named 'floor'"));
}

// Reads robot.urdf in folder/arm/urdf with these elements after a root link of 1 kg.
ModelFile read_urdf(const TemporaryFolder& folder, const std::string& content) {
  std::filesystem::create_directories(folder / "arm/urdf");
  std::filesystem::create_directories(folder / "arm/meshes");
  files::write_text(folder / "arm/meshes/leg.stl", "");
  const std::string inertial =
      "<inertial><mass value='1'/><origin rpy='0 0 1.5707963267948966' xyz='0 0 2'/><inertia "
      "ixx='1' iyy='2' izz='2.5' ixy='0' ixz='0' iyz='0'/></inertial>";
  files::write_text(folder / "arm/urdf/robot.urdf",
                    tests::replaced("<robot name='r'>\n<link name='base'>%I</link>" + content + "</robot>",
                                    "%I", inertial));
  return read_model(folder / "arm/urdf/robot.urdf", schema());
}

TEST(Urdf, HasAFreeRootWithItsMassAndJointsWithTheirLimits) {
  const TemporaryFolder folder;
  const ModelFile model =
      read_urdf(folder, R"(<link name='leg'>%I<collision><geometry><box size='2 4 6'/></geometry></collision>
      <visual><geometry><mesh filename='package://arm/meshes/leg.stl'/></geometry></visual>
      <visual><geometry><mesh filename='package://of_another_name/meshes/leg.stl'/></geometry></visual></link>
      <link name='point'><inertial><mass value='1'/><inertia ixx='0' iyy='0' izz='1.6e-15' ixy='0' ixz='0' iyz='0'/></inertial></link>
      <joint name='fixed' type='fixed'><parent link='leg'/><child link='point'/></joint>
      <joint name='hip' type='revolute'><parent link='base'/><child link='leg'/><origin xyz='0 0 -1'/><axis xyz='0 1 0'/>
      <limit lower='-1' upper='2' effort='50' velocity='9'/></joint>)");
  EXPECT_EQ(body_of(model).children.at(0).name, "freejoint");
  EXPECT_EQ(model.mass_kg, 3);
  EXPECT_EQ(model.efforts.at("hip"), 50);
  const Element& leg = body_of(model).children.at(2);
  expect_place(leg, {0, 0, -1}, {1, 0, 0, 0});
  EXPECT_EQ(leg.child("joint")->get("range"), "-1 2");
  EXPECT_THAT(numbers(*leg.child("inertial"), "fullinertia", 6, 6), Near({2, 1, 2.5, 0, 0, 0}));
  EXPECT_EQ(leg.child("geom")->get("size"), "1 2 3");
  ASSERT_EQ(model.root.child("asset")->children.size(), 1u) << "both paths are of one file";
  EXPECT_EQ(model.root.child("asset")->child("mesh")->get("file"), (folder / "arm/meshes/leg.stl").string());
}

TEST(Urdf, TheLinkBelowAFloatingJointOfTheWorldIsTheFreeRoot) {
  const TemporaryFolder folder;
  const ModelFile model = read_urdf(folder,
                                    "<link name='world'/><joint name='root' type='floating'>"
                                    "<parent link='world'/><child link='base'/></joint>");
  EXPECT_EQ(body_of(model).get("name"), "base");
  EXPECT_EQ(body_of(model).children.at(0).name, "freejoint");
  EXPECT_EQ(model.mass_kg, 1);
}

TEST(Urdf, IsRejectedIfItIsNotATreeOrNamesSomethingMissing) {
  const TemporaryFolder folder;
  const auto joint = [](const std::string& parent, const std::string& child,
                        const std::string& type = "fixed") {
    return "<joint name='j' type='" + type + "'><parent link='" + parent + "'/><child link='" + child +
           "'/></joint>";
  };
  const auto mesh = [&](const std::string& file) {
    return "<link name='a'><visual><geometry><mesh filename='" + file + "'/></geometry></visual></link>" +
           joint("base", "a");
  };
  const std::pair<std::string, std::string> cases[]{
      {joint("base", "none"), "robot.urdf:2: joint: joins 'none', expected the name of a link"},
      {"<link name='a'/>", "robot: has 2 root links"},
      {joint("base", "base"), "robot: has no root link: its joints are a closed loop"},
      {"<link name='a'/><link name='b'/>" + joint("a", "b") + joint("b", "a"), "2 links in a closed loop"},
      {"<link name='a'/>" + joint("base", "a") + joint("a", "a"),
       "joint: 'a' also hangs on 'j': a closed loop"},
      {"<link name='a'/>" + joint("base", "a", "planar"), "joint type: is planar, expected revolute"},
      {"<link name='a'/>" + joint("base", "a", "floating"),
       "joint type: is floating, expected only the whole robot to float"},
      {"<link name='a'>%I</link>" + joint("base", "a", "revolute"), "joint limit: is missing"},
      {"<link name='a'/>" + joint("base", "a", "continuous"), "body: 'a' moves but has no mass"},
      {mesh("leg.dae"), "mesh file: is 'leg.dae', expected a .stl or .obj file"},
      {mesh("package://other/leg.stl"),
       "mesh filename: no folder above this file, or beside one, has /leg.stl of the package 'other'"}};
  for (const auto& [content, error] : cases)
    EXPECT_THAT(error_of([&, &content = content] { read_urdf(folder, content); }), Has(error)) << content;
}

}  // namespace
}  // namespace sim::model_file
