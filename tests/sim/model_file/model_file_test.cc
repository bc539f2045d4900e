#include "sim/model_file/model_file.h"

#include "tests/sim/files/temporary_folder.h"

namespace sim::model_file {
namespace {

using files::error_of, files::TemporaryFolder;
using testing::ElementsAre;
using tests::Has, tests::Lacks;

/// The schema of a small library, in the format of mj_printSchema.
const Schema& schema() {
  static const Schema known(files::read_text(GAITSLAM_SOURCE_DIR "/tests/sim/model_file/schema.txt"));
  return known;
}

constexpr const char* kInertial = "<inertial pos='0 0 0' mass='2' diaginertia='1 1 1'/>";

/// Reads a robot.xml whose root has this content; %I stands for an inertial.
ModelFile read(const TemporaryFolder& folder, const std::string& content, const std::string& base = "") {
  files::write_text(folder / "robot.xml",
                    tests::replaced("<mujoco model='m'>\n" + content + "</mujoco>", "%I", kInertial));
  return read_model(folder / "robot.xml", schema(), base);
}
/// The same for a base with this content.
ModelFile read_base(const TemporaryFolder& folder, const std::string& content, const std::string& more = "") {
  return read(folder, "<compiler angle='radian'/>" + more + "<worldbody><body name='base'><freejoint/>%I\n" +
                          content + "</body></worldbody>");
}
std::vector<std::string> notes_of(const ModelFile& model, Fate fate) {
  std::vector<std::string> all;
  for (const Note& note : model.notes)
    if (note.fate == fate) all.push_back(note.what + " x" + std::to_string(note.count));
  return all;
}

TEST(ModelFile, OnlyTheRobotIsKeptAndWhatTheLibraryDoesNotKnowIsMarkedOrDropped) {
  const TemporaryFolder folder;
  const ModelFile model = read(folder, R"(
    <option integrator='implicitfast'/><sensor><contact/></sensor><keyframe><key ctrl='0'/></keyframe>
    <default><joint damping='3' actuatorfrclimited='false'/><camera fovy='1'/></default>
    <worldbody>
      <light/><geom type='plane' name='floor'/><body name='table'><joint name='drawer'/></body>
      <body name='base'><joint type='free' name='root'/>%I<camera mode='targetbody'/>
        <body name='leg' gravcomp='0'><joint name='hip' actuatorfrcrange='-88 80' user='1' range='-1 1'/>%I</body></body>
    </worldbody>
    <contact><pair geom1='sole' geom2='floor'/></contact>
    <actuator><position joint='hip' kp='100' kv='2'/><motor joint='ankle' gear='10'/><motor joint='drawer'/></actuator>
)");
  EXPECT_THAT(to_xml(model.root), Lacks("floor", "table", "drawer", "light", "camera", "pair", "gravcomp",
                                        "actuatorfrc", "implicitfast", "sensor", "kv"));
  EXPECT_THAT(
      to_xml(model.root),
      Has("<joint damping=\"3\" group=\"2\"/>", "<joint name=\"hip\" range=\"-1 1\" user=\"-88 80\"/>",
          "<compiler autolimits=\"true\"/>", "<motor joint=\"ankle\" gear=\"10\"/>"));
  ASSERT_EQ(model.pairs.size(), 1u);
  EXPECT_EQ(model.pairs[0].get("geom2"), "floor");
  EXPECT_THAT(notes_of(model, Fate::dropped),
              testing::IsSupersetOf({"camera x2", "position kv x1", "body of the world x1"}));
  EXPECT_THAT(notes_of(model, Fate::converted), ElementsAre("body gravcomp 0: left out x1"));
  EXPECT_EQ(model.named("joint", "hip").line, 8);
  EXPECT_EQ(&model.named("joint", "none"), &model.root);
}

TEST(ModelFile, TheBaseMayBeBelowAnotherBody) {
  const TemporaryFolder folder;
  const std::string world =
      "<worldbody><body name='a'><joint/><joint/></body><body name='b'><body name='c'/></body></worldbody>";
  EXPECT_THAT(to_xml(read(folder, world).root), Has("\"a\""));
  EXPECT_THAT(to_xml(read(folder, world, "c").root), Has("\"b\""));
  EXPECT_THAT(to_xml(read(folder, world, "c").root), Lacks("\"a\""));
}

TEST(ModelFile, AFrameIsAFixedBodyWithoutMassOfItsOwn) {
  const TemporaryFolder folder;
  const std::string frame = "<frame name='f' pos='1 0 0' euler='0 0 1' childclass='k'><geom/></frame>";
  const std::string body = "<body pos=\"1 0 0\" euler=\"0 0 1\" childclass=\"k\"";
  EXPECT_THAT(tests::replaced(to_xml(read_base(folder, frame).root), " name=\"frame/1\"", ""),
              Has(body, "<inertial pos=\"0 0 0\" mass=\"0\" diaginertia=\"0 0 0\"/>"));
  EXPECT_THAT(to_xml(read(folder, "<worldbody><body name='b'>" + frame + "</body></worldbody>").root),
              Has("<geom/>"))
      << "the shapes give the body its mass";
}

TEST(ModelFile, IncludesAndAssetsAreFoundRelativeToTheFile) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "parts");
  files::write_text(folder / "parts/leg.STL", "");
  files::write_text(folder / "assets.xml", R"(<mujoco><compiler meshdir='parts'/><asset>
      <mesh file='leg.STL' class='mm' content_type='model/stl'/><mesh name='unused' file='none.stl'/>
      <material name='skin' texture='cloth'/><texture name='cloth' builtin='flat'/></asset>
      <default><mesh scale='1 1 1'/><default class='mm'><geom material='skin'/>
      <default class='mm_too'/><mesh scale='.001 .001 .001'/></default></default></mujoco>)");
  const ModelFile model =
      read_base(folder, "<geom class='mm' mesh='leg' mass='0'/>", "<include file='assets.xml'/>");
  const std::string file = (folder / "parts/leg.STL").string();
  EXPECT_THAT(to_xml(model.root), Has("<mesh file=\"" + file + "\" class=\"mm\" name=\"leg\"/>", "cloth"));
  EXPECT_THAT(to_xml(model.root), Lacks("unused", "meshdir", "content_type"));
  ASSERT_EQ(model.assets.size(), 2u);
  EXPECT_EQ(model.assets[0].get("scale"), ".001 .001 .001");
  EXPECT_EQ(model.assets[0].attributes.size(), 3u) << "name, file and scale";
  EXPECT_THAT(files_of(folder / "robot.xml"), testing::SizeIs(3));
}

TEST(ModelFile, UnsupportedContentIsRejectedWithFileLineElementAndAttribute) {
  const TemporaryFolder folder;
  for (const auto& row : tests::rows_of("sim/model_file/unsupported.txt"))
    EXPECT_THAT(error_of([&] { read_base(folder, row[0], row[1]); }), Has(row.at(2))) << row[0] << row[1];
  EXPECT_THAT(error_of([&] { read(folder, "<worldbody/>"); }), Has("has no body, expected a robot"));
}

TEST(ModelFile, ARoomKeepsItsLightsAndItsShapesOfClassFloorAreMarked) {
  const TemporaryFolder folder;
  const auto room = [&](const std::string& world) {
    files::write_text(folder / "room.xml",
                      "<mujoco><option timestep='1'/><visual><headlight active='1'/></visual><actuator/>"
                      "<default><geom material='wood'/></default><worldbody>" +
                          world + "</worldbody></mujoco>");
    return to_xml(read_room(folder / "room.xml", schema()).root);
  };
  const std::string kept = room("<light type='directional'/><camera/><geom user='1'/>");
  EXPECT_THAT(kept, Has("<headlight active=\"1\"/>", "<light directional=\"true\"/>", "<geom/>",
                        "<default class=\"floor\">", "<geom user=\"1\"/>"));
  EXPECT_THAT(kept, Lacks("camera", "timestep", "actuator"));
  EXPECT_THAT(
      room("</worldbody><default><default class='floor'><geom friction='2'/></default></default><worldbody>"),
      Has("<geom friction=\"2\" user=\"1\"/>"));
}

// Reads robot.urdf in folder/arm/urdf with these elements after a root link of 1 kg.
ModelFile read_urdf(const TemporaryFolder& folder, const std::string& content,
                    const Packages& packages = {}) {
  for (const char* mesh : {"arm/meshes/leg.stl", "hand/meshes/leg.stl"}) {
    fs::create_directories((folder / mesh).parent_path());
    files::write_text(folder / mesh, "");
  }
  fs::create_directories(folder / "arm/urdf");
  files::write_text(folder / "arm/urdf/robot.urdf",
                    "<robot name='r'>\n<link name='base'><inertial><mass value='1'/></inertial></link>" +
                        content + "</robot>");
  return read_model(folder / "arm/urdf/robot.urdf", schema(), "", packages);
}
std::string joint(const std::string& parent, const std::string& child, const std::string& type = "fixed") {
  return "<joint name='j' type='" + type + "'><parent link='" + parent + "'/><child link='" + child +
         "'/></joint>";
}
std::string mesh(const std::string& file, const std::string& more = "") {
  return "<visual><geometry><mesh filename='" + file + "' " + more + "/></geometry></visual>";
}

TEST(Urdf, FloatsBelowTheWorldAndKeepsItsEfforts) {
  const TemporaryFolder folder;
  const auto limited = [&](const std::string& effort) {
    return read_urdf(folder,
                     "<gazebo/><link name='leg'><collision><geometry><capsule length='1' "
                     "radius='1'/></geometry></collision></link><joint name='hip' type='revolute'><parent "
                     "link='base'/><child link='leg'/>"
                     "<limit lower='-1' upper='2' effort='" +
                         effort + "' velocity='9'/></joint>");
  };
  const ModelFile model = limited("50");
  EXPECT_THAT(to_xml(model.root),
              Has("<parent link=\"world\"/>", "type=\"floating\"", "fusestatic=\"false\""));
  EXPECT_EQ(model.efforts.at("hip"), 50);
  EXPECT_THAT(notes_of(model, Fate::dropped), ElementsAre("gazebo x1", "limit velocity x1"));
  EXPECT_THAT(
      notes_of(model, Fate::converted),
      ElementsAre("the root link is free to move, not welded to the world x1",
                  "link without inertial: without mass x1", "capsule: a cylinder, without round ends x1"));
  EXPECT_TRUE(limited("0").efforts.empty());
  EXPECT_THAT(notes_of(limited("0"), Fate::doubtful), testing::SizeIs(1));
}

TEST(Urdf, ALinkThatStandsForTheWorldGetsAFloatingJoint) {
  const TemporaryFolder folder;
  for (const auto& [link, type] : {std::pair("world", "fixed"), {"map", "floating"}}) {
    const ModelFile model =
        read_urdf(folder, std::string("<link name='") + link + "'/>" + joint(link, "base", type));
    EXPECT_THAT(to_xml(model.root), Has("<joint name=\"j\" type=\"floating\">", "<link name=\"world\"/>"));
  }
}

TEST(Urdf, EachFileAndScaleIsAMeshAndNoPackageTakesAnothersFile) {
  const TemporaryFolder folder;
  const auto files = [&](const std::string& meshes, const Packages& packages = {}) {
    std::vector<std::string> all;
    for (const Element& asset :
         read_urdf(folder, "<link name='leg'>" + meshes + "</link>" + joint("base", "leg"), packages).assets)
      all.push_back(asset.get("file").substr(folder.path().string().size()) + asset.get("scale"));
    return all;
  };
  const std::string arm = mesh("package://arm/meshes/leg.stl"), hand = mesh("package://hand/meshes/leg.stl");
  EXPECT_THAT(files(arm + hand + mesh("../meshes/leg.stl") + mesh("../meshes/leg.stl", "scale='2 2 2'")),
              ElementsAre("/arm/meshes/leg.stl", "/hand/meshes/leg.stl", "/arm/meshes/leg.stl2 2 2"));
  EXPECT_THAT(files(mesh("package://renamed/meshes/leg.stl")), ElementsAre("/arm/meshes/leg.stl"));
  const std::string other = mesh("package://other/meshes/leg.stl");
  EXPECT_THAT(error_of([&] { files(arm + other); }),
              Has("robot.urdf:2: mesh filename: no folder above this file, or "
                  "inside one, is the package 'other' with /meshes/leg.stl"));
  EXPECT_THAT(files(arm + other, {{"other", folder / "hand"}}),
              ElementsAre("/arm/meshes/leg.stl", "/hand/meshes/leg.stl"));
}

TEST(Urdf, IsRejectedIfItIsNotATreeOrNamesSomethingMissing) {
  const TemporaryFolder folder;
  const std::pair<std::string, std::string> cases[]{
      {"<link name='a'/>", "robot: has 2 root links"},
      {joint("base", "base"), "robot: has no root link: its joints are a closed loop"},
      {"<link name='world'/><link name='a'/>" + joint("world", "base") + joint("world", "a"),
       "link: 'world' has 2 joints, expected one, to the robot"},
      {"<link name='a'>" + mesh("leg.dae") + "</link>" + joint("base", "a"),
       "mesh filename: is 'leg.dae', expected a .stl or .obj file"}};
  for (const auto& [content, error] : cases)
    EXPECT_THAT(error_of([&, &content = content] { read_urdf(folder, content); }), Has(error)) << content;
}

}  // namespace
}  // namespace sim::model_file
