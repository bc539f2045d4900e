#include "sim/scenario/robot.h"

#include "sim/scenario/keys.h"

namespace sim::scenario {
namespace {

using physics::RobotFile;

constexpr const char *kFile = "robot.yaml", *kWalk = "walk", *kSideways = "walk_sideways",
                     *kStabilizer = "stabilizer", *kSlam = "slam", *kFriction = "floor_friction";
constexpr std::array kSides{"right", "left"};  // as walking::Side

/// Reads a robot's file; all functions throw ConfigError.
class RobotReader {
 public:
  explicit RobotReader(const Yaml& root) : root_(root) {}

  RobotFile read(const fs::path& folder) {
    robot_.folder = folder;
    require_map(root_, "", "the keys of a robot, as in base: pelvis");
    const auto no_key_of_the_robot = [](const Yaml&) {};
    files::read_map(
        root_, {{"model", [this](const Yaml& node) { model(node); }},
                {"packages", [this](const Yaml& node) { packages(node); }},
                {"base", [this](const Yaml& node) { text("base", node, robot_.base); }},
                {"head_camera", [this](const Yaml& node) { mount("head_camera", node, robot_.head_camera); }},
                {"imu", [this](const Yaml& node) { mount("imu", node, robot_.imu); }},
                {"legs", [this](const Yaml& node) { sides("legs", node, &RobotReader::texts, robot_.legs); }},
                {"feet",
                 [this](const Yaml& node) {
                   sides("feet", node, &RobotReader::table<RobotFile::Foot>, robot_.feet);
                 }},
                {"arms", [this](const Yaml& node) { sides("arms", node, &RobotReader::texts, robot_.arms); }},
                {"posture_deg", [this](const Yaml& node) { posture(node); }},
                {"servos", [this](const Yaml& node) { servos(node); }},
                {"step", [this](const Yaml& node) { table("step", node, robot_.step); }},
                {kFriction, no_key_of_the_robot},
                {kWalk, no_key_of_the_robot},
                {kSideways, no_key_of_the_robot},
                {kStabilizer, no_key_of_the_robot},
                {kSlam, no_key_of_the_robot}});
    for (const char* key : {"base", "head_camera", "imu", "legs", "feet", "servos"})
      if (!root_.find(key)) fail(root_, key, "missing, expected in a robot's file");
    for (std::size_t side = 0; side < 2; ++side) {
      if (!robot_.arms[side].empty() && robot_.arms[side].size() != 2)
        fail(*root_.find("arms"), "arms", "expected two joints per side, shoulder and elbow");
      if (robot_.feet[side].body.empty())
        fail(*root_.find("feet"), "feet", "{}.body is missing", kSides[side]);
    }
    return std::move(robot_);
  }

 private:
  void note(const std::string& key, const Yaml& node) {
    robot_.places[key] = fmt::format("{}:{}:{}", node.origin.file, node.origin.line, node.origin.column);
  }

  void text(const std::string& key, const Yaml& node, std::string& value) {
    note(key, node);
    scenario::read(node, key, {}, value);
  }
  void model(const Yaml& node) {
    note("model", node);
    if (!node.is_scalar() || node.text.empty())
      fail(node, "model", "expected the path of an MJCF or URDF file");
    robot_.model = node.text;
  }
  void packages(const Yaml& node) {
    require_map(node, "packages", "a map of packages and folders, as in {g1_description: ../g1_description}");
    for (const auto& [name, folder] : node.entries())
      robot_.packages[name.text] = files::read_path(folder, "packages", robot_.folder);
  }
  void texts(const std::string& key, const Yaml& node, std::vector<std::string>& value) {
    value = read_texts(node, key, "[left_hip, left_knee]");
  }

  /// Reads a map into options with a table of keys.
  template <class Options>
  void table(const std::string& path, const Yaml& node, Options& options) {
    note(path, node);
    require_map(node, path, "a map of keys and values");
    MapReaders readers;
    const std::vector<Key> keys = keys_of<Options>();
    for (const Key& key : keys)
      readers.emplace_back(key.name, [&](const Yaml& value) { key.read(value, options); });
    files::read_map(node, readers);
  }

  void mount(const std::string& key, const Yaml& node, rig::Mount& mount) {
    table(key, node, mount);
    if (!mount.on_link()) fail(node, key, "has no link, expected a body of the model");
  }

  template <class Value>
  void sides(const std::string& key, const Yaml& node,
             void (RobotReader::*reader)(const std::string&, const Yaml&, Value&),
             std::array<Value, 2>& values) {
    note(key, node);
    require_map(node, key, "a map with left and right");
    MapReaders readers;
    for (std::size_t side = 0; side < 2; ++side)
      readers.emplace_back(kSides[side], [&, side](const Yaml& value) {
        const std::string path = fmt::format("{}.{}", key, kSides[side]);
        note(path, value);
        (this->*reader)(path, value, values[side]);
      });
    files::read_map(node, readers);
    for (const char* side : kSides)
      if (!node.find(side)) fail(node, key, "{} is missing", side);
  }

  void posture(const Yaml& node) {
    require_map(node, "posture_deg", "a map of joints and angles, as in {left_knee: 30}");
    for (const auto& [key, value] : node.entries()) {
      const std::string& joint = key.text;
      double degrees = 0;
      note("posture_deg." + joint, key);
      scenario::read(value, "posture_deg." + joint, {-360, 360}, degrees);
      robot_.posture_rad[joint] = to_radians(degrees);
    }
  }

  void servos(const Yaml& node) {
    note("servos", node);
    if (!node.is_list())
      fail(node, "servos", "expected a list, as in [{joints: [knee], kp_nm_rad: 500, kd_nms_rad: 5}]");
    for (const Yaml& item : node.items) {
      RobotFile::Servo& servo = robot_.servos.emplace_back();
      require_map(item, "servos", "a servo, as in {joints: [knee], kp_nm_rad: 500, kd_nms_rad: 5}");
      const auto number = [](const char* key, auto& value, double least = 0) {
        return [=, &value](const Yaml& at) { scenario::read(at, key, {least, 1e6}, value.emplace()); };
      };
      std::optional<double> kp, kd;
      files::read_map(item, {{"joints", [&](const Yaml& at) { texts("joints", at, servo.joints); }},
                             {"kp_nm_rad", number("kp_nm_rad", kp)},
                             {"kd_nms_rad", number("kd_nms_rad", kd)},
                             {"armature_kg_m2", number("armature_kg_m2", servo.armature_kg_m2)},
                             {"effort_nm", number("effort_nm", servo.effort_nm, 0.001)}});
      if (servo.joints.empty() || !kp || !kd)
        fail(item, "servos", "expected joints, kp_nm_rad and kd_nms_rad");
      servo.kp_nm_rad = *kp, servo.kd_nms_rad = *kd;
    }
  }

  const Yaml& root_;
  RobotFile robot_;
};

/// Adds the values below a node with their dotted keys.
void flatten(const std::string& path, const Yaml& node, std::vector<std::pair<std::string, Yaml>>& all) {
  if (!node.is_map()) return all.emplace_back(path, node), void();
  for (const auto& [key, value] : node.entries()) flatten(path + "." + key.text, value, all);
}

}  // namespace

fs::path standard_models() {
  std::error_code fault;
  if (fs::is_directory(GAITSLAM_MODELS, fault)) return GAITSLAM_MODELS;
  return fs::read_symlink("/proc/self/exe", fault).parent_path().parent_path() / "share/gaitslam/models";
}

fs::path robot_folder(const std::string& robot) {
  return robot.find('/') != robot.npos ? fs::path(robot) : standard_models() / "robots" / robot;
}

RobotFile read_robot(const fs::path& folder) {
  const Yaml root = parse_yaml_file(folder / kFile);
  return RobotReader(root).read(folder);
}

RobotFile read_robot(const Scenario& scenario) { return read_robot(robot_folder(scenario.world.robot)); }

std::vector<std::pair<std::string, Yaml>> robot_defaults(const fs::path& folder, walking::Gait gait) {
  std::vector<std::pair<std::string, Yaml>> all;
  std::error_code fault;
  if (!fs::is_regular_file(folder / kFile, fault)) return all;
  const Yaml root = parse_yaml_file(folder / kFile);
  for (const char* section : {kSideways, kWalk, kStabilizer, kSlam}) {
    const Yaml* const node = root.find(section);
    if (!node || (section == kSideways && gait != walking::Gait::sideways)) continue;
    require_map(*node, section, "keys of a scenario and their values");
    flatten(section == kSideways ? kWalk : section, *node, all);
  }
  if (const Yaml* const node = root.find(kFriction)) all.emplace_back("world.floor_friction", *node);
  return all;
}

}  // namespace sim::scenario
