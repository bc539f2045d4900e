#include "sim/scenario/keys.h"

#include <typeinfo>

#include "tests/sim/scenario/test_scenarios.h"

namespace sim::scenario {
namespace {

using testing::ElementsAre, testing::HasSubstr, testing::Optional, testing::StartsWith;

TEST(Keys, ReadBackWhatTheyPrintAndTouchNothingElse) {
  for (const auto& key : scenario_keys()) {
    const std::optional<Scenario> other = changed(key);
    ASSERT_TRUE(other) << key.name << ": the test has no other value for it";
    Scenario again = default_scenario();
    key.read(parse_yaml(key.print(*other), {"printed"}), again);
    EXPECT_EQ(key.print(again), key.print(*other)) << key.name;
    for (const auto& rest : scenario_keys()) {
      if (rest.name == key.name) continue;
      EXPECT_EQ(rest.print(again), rest.print(default_scenario())) << key.name << " and " << rest.name;
    }
  }
}

TEST(Keys, HaveTheirOwnTextAndADefaultWithinTheirRange) {
  std::set<std::string> meanings;
  for (const auto& key : scenario_keys()) {
    const bool of_mount = key.name.starts_with("imu.");  // like the camera's mount
    EXPECT_NE(meanings.insert(key.doc).second, of_mount) << key.name;
    EXPECT_FALSE(key.doc.empty() || key.expected.empty()) << key.name;
    if (key.name == "name" || key.name == "walk.commands") continue;  // these two have no default
    Scenario s = default_scenario();
    EXPECT_NO_THROW(key.read(parse_yaml(key.print(s), {"default"}), s)) << key.name;
  }
}

/// Stands for a member of any type in the braces of an aggregate.
struct AnyMember {
  template <class T>
  operator T() const;  // NOLINT: meant to convert
};

/// The number of members of an aggregate: the maximum number of initializers in its braces.
template <class T, class... Members>
constexpr int members() {
  if constexpr (requires { T{Members{}..., AnyMember{}}; })
    return members<T, Members..., AnyMember>();
  else
    return sizeof...(Members);
}

/// A visitor of `keys` that expects one key for each member of the options and of their parts.
class Count : public walking::KeyVisitor {
 public:
  template <class... Options>
  static void expect_one_for_each_member_of() {
    const auto expect = []<class Each>(Count count, const Each*) {
      Each::keys(count);
      constexpr int kOfMount = std::is_base_of_v<rig::Mount, Each> ? members<rig::Mount>() - 1 : 0;
      constexpr int kOfImager = std::is_base_of_v<rig::Imager, Each> ? members<rig::Imager>() - 1 : 0;
      constexpr int kOfSizes = std::is_base_of_v<sensor_errors::InertialErrorSizes, Each>
                                   ? members<sensor_errors::InertialErrorSizes>() - 1
                                   : 0;
      EXPECT_EQ(count.count_, members<Each>() + kOfMount + kOfImager + kOfSizes) << typeid(Each).name();
    };
    (expect(Count(), static_cast<const Options*>(nullptr)), ...);
  }

  void number(auto&&...) { ++count_; }
  void degrees(auto&&...) { ++count_; }
  void choice(auto&&...) { ++count_; }
  void value(auto&&...) { ++count_; }
  template <class Part, class Owner>
  void part(std::string_view, Part Owner::*) {
    ++count_;
    expect_one_for_each_member_of<Part>();
  }

 private:
  int count_ = 0;
};

TEST(Keys, EveryOptionAndEveryFieldOfAnItemHasAKey) {
  Count::expect_one_for_each_member_of<
      walking::WalkOptions, walking::StabilizerOptions, physics::WorldOptions, camera::CameraOptions,
      sensor_errors::ErrorOptions, slam::Options, walking::Stand, walking::Straight, walking::TangentArc,
      walking::PerpendicularArc, walking::Step, walking::Turn, walking::GoTo, walking::Repeat, physics::Push,
      physics::FloorPatch, physics::Person, physics::Door>();
}

TEST(Keys, HaveTheirUnitInTheirName) {
  EXPECT_EQ(unit_of("walk.step_length_m"), "m");
  EXPECT_EQ(unit_of("slam.motion.sigma_acceleration_m_s2"), "m/s²");
  EXPECT_EQ(unit_of("slam.vision.visible_landmarks"), std::nullopt);
}

/// Returns the error of a scenario that starts with this line.
std::string complaint_about(const std::string& line) {
  const bool commands = line.starts_with("walk.commands");
  return complaint(line + (commands ? "\n" : "\nwalk.commands: [{stand: {}}]\n") + "camera: {}\nslam: {}\n");
}

/// Expects that each key of the kind ("a number", ...) rejects each value at its place and names the key and
/// the expected values.
void expect_rejected(const std::string& kind, const std::vector<std::string>& values) {
  int keys = 0;
  for (const Key& key : scenario_keys()) {
    // A model's parts may have any names.
    if (!key.expected.starts_with(kind) || key.name.ends_with("link")) continue;
    ++keys;
    for (const std::string& value : values) {
      const std::string message = complaint_about(key.name + ": " + value);
      EXPECT_THAT(message, StartsWith(fmt::format("test.yaml:1:{}: {}: is ", key.name.size() + 3, key.name)))
          << value;
      EXPECT_THAT(message, HasSubstr("expected " + key.expected)) << value;
    }
  }
  EXPECT_GT(keys, 0) << kind;
}

TEST(BadValues, EachTypeHasOnlyOneNotation) {
  const std::vector<std::string> numbers{".nan",   "nan",  ".inf", "-inf", "1e999", "0x10",  "0o7",  "1_0",
                                         "0,5",    "1 m",  "1m",   "one",  "'1'",   "\"1\"", "true", "[1]",
                                         "{a: 1}", "1..2", "--1",  "+1",   "1e",    "½",     "1/2"};
  expect_rejected("a number", numbers);
  expect_rejected("a whole number", numbers);
  expect_rejected("a whole number", {"1.5", "1.0", "1e3", "99999999999999999999"});
  expect_rejected("true or false",
                  {"yes", "no", "on", "off", "True", "FALSE", "1", "0", "t", "'true'", "[true]", "{a: 1}"});
  expect_rejected("one of", {"neither", "1", "true", "[wide]", "{a: 1}", "''"});
  expect_rejected("a name",
                  {".hidden", "..", "'a b'", "'a;b'", "[a]", "{a: 1}", "''", "$HOME", std::string(101, 'a')});
}

TEST(BadValues, NumbersMustBeWithinTheirRange) {
  for (const Key& key : scenario_keys()) {
    double lowest = 0, highest = 0;
    const std::size_t from = key.expected.find("number from ");
    if (from == key.expected.npos) continue;
    ASSERT_EQ(std::sscanf(key.expected.c_str() + from, "number from %lf to %lf", &lowest, &highest), 2);
    for (const double outside : {lowest - 1, 2 * highest + 1})
      EXPECT_THAT(complaint_about(fmt::format("{}: {:.0f}", key.name, outside)),
                  HasSubstr("expected " + key.expected));
  }
}

TEST(BadValues, AnEmptyValueIsRejected) {
  for (const auto& key : scenario_keys())
    for (const std::string nothing : {"", "~", "null"})
      EXPECT_THAT(complaint_about(key.name + ": " + nothing),
                  testing::AllOf(StartsWith("test.yaml:1:1: " + key.name + ": "), HasSubstr("expected ")));
}

TEST(BadKeys, ATypoIsAnsweredWithTheNameOfTheKey) {
  for (const auto& key : scenario_keys()) {
    if (key.name.size() < 5) continue;
    std::string dropped = key.name, doubled = key.name;
    dropped.erase(dropped.size() - 2, 1);
    doubled.insert(doubled.size() - 2, 1, doubled[doubled.size() - 2]);
    for (const std::string& slip : {dropped, doubled})
      EXPECT_THAT(complaint_about(slip + ": 1"),
                  StartsWith("test.yaml:1:1: " + slip + ": unknown key; did you mean '"));
    EXPECT_THAT(complaint_about(dropped + ": 1"), HasSubstr("did you mean '" + key.name + "'?"));
  }
}

TEST(Seeds, KeepTheOrderInWhichTheyAreWritten) {
  EXPECT_THAT(parse_seeds("7"), ElementsAre(7));
  EXPECT_THAT(parse_seeds("9,1..3,5"), ElementsAre(9, 1, 2, 3, 5));
  EXPECT_THAT(parse_seeds("18446744073709551614..18446744073709551615"),
              ElementsAre(18446744073709551614U, 18446744073709551615U));
}

TEST(Seeds, ErrorsAreReported) {
  for (const auto& [text, problem] : {std::pair("", "'' is not a seed, expected for example 1..5 or 1,2,7"),
                                      {"1,", "'' is not a seed"},
                                      {"1,x", "'x' is not a seed"},
                                      {"3..1", "'3..1' goes backwards"},
                                      {"1..3,2", "a seed is given twice"},
                                      {"1..100001", "more than 100000 seeds"}})
    EXPECT_THAT(files::error_of<std::invalid_argument>([seeds = text] { parse_seeds(seeds); }),
                StartsWith(problem));
}

using walking::SteeredBy;

std::string key_of(Scenario scenario, SteeredBy by = SteeredBy::plan) {
  scenario.walk.steering.by = by;
  return recording_key(scenario, "models", "program");
}

TEST(RecordingKey, ContainsEachKeyOfWalkAndWorldButThoseOfErrorsAndFilterOnlyIfTheySteer) {
  static const std::set<std::string> kSections{"seed", "walk", "stabilizer", "world", "camera", "imu", "rig"};
  for (const auto& key : scenario_keys()) {
    if (key.name == "walk.steering.by") continue;
    const std::optional<Scenario> other = changed(key);
    ASSERT_TRUE(other) << key.name << ": the test has no other value for it";
    const auto changes = [&](SteeredBy by) { return key_of(*other, by) != key_of(default_scenario(), by); };
    const bool walk = kSections.contains(key.name.substr(0, key.name.find('.')));
    EXPECT_EQ(changes(SteeredBy::plan), walk) << key.name;
    EXPECT_EQ(changes(SteeredBy::estimate), walk || shapes_estimate(key.name)) << key.name;
    EXPECT_EQ(changes(SteeredBy::truth), walk || key.name == "errors.faults") << key.name;
  }
  EXPECT_NE(key_of(default_scenario(), SteeredBy::truth), key_of(default_scenario()));
}

TEST(RecordingKey, DependsOnCameraProgramAndModelsButNotOnWhetherThereIsAFilter) {
  Scenario scenario = default_scenario();
  const std::string unchanged = key_of(scenario);
  EXPECT_NE(recording_key(scenario, "models", "program 2"), unchanged);
  EXPECT_NE(recording_key(scenario, "others", "program"), unchanged);
  scenario.slam.reset();
  EXPECT_EQ(key_of(scenario), unchanged);
  scenario.camera.reset();
  EXPECT_NE(key_of(scenario), unchanged);
}

// Includes files in other folders, if robot and room are given by path.
TEST(RecordingKey, DependsOnEachFileThatARobotARoomOrAControllerNames) {
  const files::TemporaryFolder folder;
  fs::create_directories(folder / "bot");
  fs::create_directories(folder / "parts");
  const auto write = [&](const char* name, const std::string& text) { std::ofstream(folder / name) << text; };
  write("bot/robot.yaml",
        "model: ../body.xml\nbase: b\nhead_camera: {link: b}\nimu: {link: b}\nlegs: {left: [l], right: [r]}\n"
        "feet: {left: {body: l}, right: {body: r}}\nservos: []\n");
  write("body.xml", "<mujoco><include file='parts/assets.xml'/></mujoco>");
  write("parts/assets.xml",
        "<mujoco><compiler meshdir='parts' texturedir='.' strippath='true'/><asset>"
        "<mesh file='elsewhere/leg.stl'/><texture file='skin.png'/></asset></mujoco>");
  write("room.xml", "<mujoco><asset><hfield file='parts/hills.png'/></asset></mujoco>");
  for (const char* file : {"parts/leg.stl", "skin.png", "parts/hills.png", "weights.npz"}) write(file, "1");
  Scenario scenario = default_scenario();
  scenario.world.robot = (folder / "bot").string();
  scenario.world.room = (folder / "room.xml").string();
  scenario.controller.source = programs::Source::program;
  scenario.controller.words = {"walker"};
  scenario.controller.options = {{"weights", (folder / "weights.npz").string()}};
  std::string before = key_of(scenario);
  EXPECT_EQ(key_of(scenario), before);
  for (const char* file : {"bot/robot.yaml", "body.xml", "parts/assets.xml", "parts/leg.stl", "skin.png",
                           "room.xml", "parts/hills.png", "weights.npz"}) {
    write(file, files::read_text(folder / file) + "\n");
    EXPECT_NE(key_of(scenario), before) << file;
    before = key_of(scenario);
  }
}

TEST(Counterfactual, IsAReplayWhoseEstimateWouldHaveSteeredADifferentWalk) {
  Scenario recorded = default_scenario(), tuned = recorded, seeded = recorded, limited = recorded;
  tuned.slam->gyro.sigma_rad_s *= 2;
  seeded.seed = 7;
  limited.limits.ending = {"fell"};
  EXPECT_EQ(counterfactual(recorded, tuned), std::nullopt) << "it was not steered";
  recorded.walk.steering.by = SteeredBy::estimate;
  for (const Scenario& same : {recorded, limited}) EXPECT_EQ(counterfactual(recorded, same), std::nullopt);
  EXPECT_THAT(counterfactual(recorded, tuned), Optional(HasSubstr("slam.gyro.sigma_rad_s")));
  EXPECT_THAT(counterfactual(recorded, seeded), Optional(HasSubstr("seed")));
}

TEST(ModelsHash, ChangesWithAnyFileAndNotWithTheirDescription) {
  const files::TemporaryFolder folder;
  const auto hash_with = [&](const std::string& name, const std::string& text) {
    std::ofstream(folder / name) << text;
    return models_hash(folder.path());
  };
  hash_with("robot.xml", "<a/>");
  const std::string before = hash_with("room.xml", "<b/>");
  EXPECT_EQ(hash_with("README.md", "of robot and room"), before);
  EXPECT_NE(hash_with("room.xml", "<c/>"), before);
  EXPECT_EQ(hash_with("room.xml", "<b/>"), before);
  EXPECT_NE(hash_with("texture.png", "x"), before);
  EXPECT_THROW(models_hash(folder / "nowhere"), files::FileError);
}

}  // namespace
}  // namespace sim::scenario
