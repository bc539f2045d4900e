#include "sim/scenario/keys.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <set>
#include <sstream>

#include "sim/scenario/scenario.h"
#include "sim/score/metrics.h"
#include "tests/sim/scenario/complaint.h"

namespace sim::scenario {
namespace {

using testing::HasSubstr;

/// Values of all types; each key takes one of them that is not its default.
std::vector<std::string> values_for(const Key& key) {
  std::vector<std::string> values{
      "true",
      "false",
      "37",
      "20000",
      "3",
      "0.0625",
      "0.3",
      "0.7",
      "2.5",
      "0.004",
      "1e5",
      "[fell]",
      "[[1, 2, 3]]",
      "{program: [./mine, --stdio], options: {a: {b: 1}}}",
      "[{stand: {duration_s: 2}}]",
      "[{gyro_silent: {}}]",
      "[{push: {time_s: 1, impulse_ns: 3}}]",
      "[{patch: {x_min_m: 1, x_max_m: 2, y_min_m: 1, y_max_m: 2, friction: 0.3}}]"};
  const std::string one_of = "one of ";
  if (!key.expected.starts_with(one_of)) return values;
  std::string words = key.expected.substr(one_of.size());
  std::replace(words.begin(), words.end(), ',', ' ');
  std::istringstream in(words);
  return {std::istream_iterator<std::string>(in), {}};
}

/// The default scenario with another value of that key.
std::optional<Scenario> changed(const Key& key) {
  for (const std::string& value : values_for(key)) {
    Scenario scenario = default_scenario();
    if (!complaint_of([&] { key.read(parse_yaml(value, {"test"}), scenario); }).empty()) continue;
    if (key.print(scenario) != key.print(default_scenario())) return scenario;
  }
  return std::nullopt;
}

TEST(Keys, ReadWhatTheyPrintAndTouchNothingElse) {
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

TEST(Keys, EveryDefaultLiesWithinItsOwnRange) {
  for (const auto& key : scenario_keys()) {
    if (key.name == "name" || key.name == "walk.commands") continue;  // these two have no default
    Scenario s = default_scenario();
    EXPECT_NO_THROW(key.read(parse_yaml(key.print(s), {"default"}), s)) << key.name;
    EXPECT_FALSE(key.doc.empty() || key.expected.empty()) << key.name;
  }
}

TEST(Keys, EachHasATextThatNoOtherHas) {
  std::set<std::string> meanings;
  for (const auto& key : scenario_keys()) EXPECT_TRUE(meanings.insert(key.doc).second) << key.name;
}

/// Stands for a member of any type in an aggregate's braces.
struct AnyMember {
  template <class T>
  operator T() const;  // NOLINT: meant to convert
};

/// How many members an aggregate has: as many as its braces take.
template <class T, class... Members>
constexpr int members() {
  if constexpr (requires { T{Members{}..., AnyMember{}}; }) {
    return members<T, Members..., AnyMember>();
  } else {
    return sizeof...(Members);
  }
}

/// A visitor of `keys` that expects one key for each member of the options and of their parts.
class Count : public walking::KeyVisitor {
 public:
  template <class Options>
  static void expect_one_for_each_member(const std::string& name) {
    Count count;
    Options::keys(count);
    EXPECT_EQ(count.count_, members<Options>()) << name;
  }

  void number(auto&&...) { ++count_; }
  void degrees(auto&&...) { ++count_; }
  void choice(auto&&...) { ++count_; }
  void value(auto&&...) { ++count_; }
  template <class Part, class Owner>
  void part(std::string_view name, Part Owner::*) {
    ++count_;
    expect_one_for_each_member<Part>(std::string(name));
  }

 private:
  int count_ = 0;
};

TEST(Keys, ThereIsOneForEachOption) {
  Count::expect_one_for_each_member<walking::WalkOptions>("walk");
  Count::expect_one_for_each_member<walking::StabilizerOptions>("stabilizer");
  Count::expect_one_for_each_member<physics::WorldOptions>("world");
  Count::expect_one_for_each_member<camera::CameraOptions>("camera");
  Count::expect_one_for_each_member<sensor_errors::ErrorOptions>("errors");
  Count::expect_one_for_each_member<slam::Options>("slam");
}

TEST(Keys, ThereIsOneForEachFieldOfAnItem) {
  Count::expect_one_for_each_member<walking::Stand>("stand");
  Count::expect_one_for_each_member<walking::Straight>("straight");
  Count::expect_one_for_each_member<walking::TangentArc>("tangent_arc");
  Count::expect_one_for_each_member<walking::PerpendicularArc>("perpendicular_arc");
  Count::expect_one_for_each_member<walking::Step>("steps");
  Count::expect_one_for_each_member<walking::Turn>("turn");
  Count::expect_one_for_each_member<walking::GoTo>("go_to");
  Count::expect_one_for_each_member<walking::Repeat>("repeat");
  Count::expect_one_for_each_member<physics::Push>("push");
  Count::expect_one_for_each_member<physics::FloorPatch>("patch");
}

TEST(Keys, NamesAreUniqueAndSectionsStandTogether) {
  std::vector<std::string> names, sections;
  for (const auto& key : scenario_keys()) {
    names.push_back(key.name);
    const std::string section = key.name.substr(0, key.name.rfind('.'));
    if (sections.empty() || sections.back() != section) sections.push_back(section);
  }
  for (auto* list : {&names, &sections}) {
    std::sort(list->begin(), list->end());
    EXPECT_EQ(std::adjacent_find(list->begin(), list->end()), list->end());
  }
}

TEST(Keys, TakeTheirNamesFromTheirMembers) {
  static_assert(walking::member_name<&physics::Push::impulse_ns>() == "impulse_ns");
  EXPECT_NE(find_key("errors.gyro.sigma_rad_s"), nullptr);
}

TEST(Keys, FormerNamesGetAMessageWithTheNewOne) {
  for (const auto& [line, note] : std::vector<std::pair<std::string, std::string>>{
           {"slam.vision.lasting_s", "was renamed to slam.vision.match_bias_s"},
           {"slam.tracking.height_bound", "is gone: it is a constant"},
           {"limits.tracked_share.at_most", "metric tracked_share was renamed to tracked_fraction"},
           {"limits.yaw_rmse_deg.at_most", "metric yaw_rmse_deg is gone: no limit, page or README used it"}})
    EXPECT_EQ(complaint(kAll + line + ": 1\n"), "test.yaml:4:1: " + line + ": " + note);
  EXPECT_EQ(former_name("slam"), "");
}

TEST(Keys, CarryTheirUnitInTheName) {
  EXPECT_EQ(unit_of("walk.step_length_m"), "m");
  EXPECT_EQ(unit_of("slam.gyro.sigma_rad_s"), "rad/s");
  EXPECT_EQ(unit_of("slam.motion.sigma_acceleration_m_s2"), "m/s²");
  EXPECT_EQ(unit_of("slam.vision.visible_landmarks"), "");
}

}  // namespace
}  // namespace sim::scenario
