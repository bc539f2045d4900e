// Errors that every key has to report, for every key.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/scenario/keys.h"
#include "tests/sim/scenario/complaint.h"

namespace sim::scenario {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

constexpr const char* kRest = "walk.commands: [{stand: {}}]\ncamera: {}\nslam: {}\n";

/// Returns the error of a scenario that starts with this line.
std::string complaint_about(const std::string& line) {
  const bool commands = line.starts_with("walk.commands");
  return complaint(line + "\n" + (commands ? "camera: {}\nslam: {}\n" : kRest));
}

/// The keys with values of one kind: "a number", "a whole number", "true or false", "one of", ...
std::vector<const Key*> keys_of(const std::string& kind) {
  std::vector<const Key*> keys;
  for (const auto& key : scenario_keys()) {
    if (key.expected.starts_with(kind)) keys.push_back(&key);
  }
  EXPECT_FALSE(keys.empty()) << kind;
  return keys;
}

/// Each key of the kind rejects each value at its place, naming the key and the expected values.
void expect_rejected(const std::string& kind, const std::vector<std::string>& values) {
  for (const auto* key : keys_of(kind)) {
    for (const std::string& value : values) {
      const std::string message = complaint_about(key->name + ": " + value);
      EXPECT_THAT(message,
                  StartsWith(fmt::format("test.yaml:1:{}: {}: is ", key->name.size() + 3, key->name)))
          << value;
      EXPECT_THAT(message, HasSubstr("expected " + key->expected)) << value;
    }
  }
}

TEST(BadValues, NumbersAreWrittenOneWay) {
  const std::vector<std::string> values{
      ".nan", "nan", ".inf",  "-inf", "1e999", "0x10",   "0o7",  "010", "-007", "1_0", "0,5", "1 m", "1m",
      "one",  "'1'", "\"1\"", "true", "[1]",   "{a: 1}", "1..2", "--1", "+1",   "1e",  "½",   "1/2"};
  expect_rejected("a number", values);
  expect_rejected("a whole number", values);
  expect_rejected("a whole number", {"1.5", "1.0", "1e3", "99999999999999999999"});
}

TEST(BadValues, NumbersKeepTheirRange) {
  for (const std::string kind : {"a number", "a whole number"}) {
    for (const auto* key : keys_of(kind + " from ")) {
      double lowest = 0, highest = 0;
      ASSERT_EQ(std::sscanf(key->expected.c_str() + kind.size(), " from %lf to %lf", &lowest, &highest), 2)
          << key->name;
      for (const double outside : {lowest - 1, 2 * highest + 1}) {
        EXPECT_THAT(complaint_about(fmt::format("{}: {:.0f}", key->name, outside)),
                    HasSubstr("expected " + key->expected));
      }
    }
  }
}

TEST(BadValues, SwitchesAreTrueOrFalse) {
  expect_rejected("true or false",
                  {"yes", "no", "on", "off", "True", "FALSE", "1", "0", "t", "'true'", "[true]", "{a: 1}"});
}

TEST(BadValues, ChoicesAreTheirWords) {
  expect_rejected("one of", {"neither", "1", "true", "[wide]", "{a: 1}", "''"});
}

TEST(BadValues, NamesDoNotLeaveTheirFolder) {
  expect_rejected("a name", {"../up", "/etc/passwd", "a/b", ".hidden", "..", "'a b'", "'a;b'", "[a]",
                             "{a: 1}", "''", "$HOME", std::string(101, 'a')});
}

TEST(BadValues, AnEmptyValueIsRejected) {
  for (const auto& key : scenario_keys()) {
    for (const std::string nothing : {"", "~", "null"}) {
      const std::string message = complaint_about(key.name + ": " + nothing);
      EXPECT_THAT(message, StartsWith("test.yaml:1:1: " + key.name + ": ")) << nothing;
      EXPECT_THAT(message, HasSubstr("expected ")) << nothing;
    }
  }
}

TEST(BadKeys, ATypoGetsTheNameOfTheKey) {
  for (const auto& key : scenario_keys()) {
    if (key.name.size() < 5) continue;
    std::string doubled = key.name, dropped = key.name, swapped = key.name;
    doubled.insert(doubled.size() - 2, 1, doubled[doubled.size() - 2]);
    dropped.erase(dropped.size() - 2, 1);
    std::swap(swapped[swapped.size() - 1], swapped[swapped.size() - 2]);
    for (const std::string& slip : {doubled, dropped, swapped}) {
      if (slip == key.name || find_key(slip) != nullptr) continue;
      const std::string message = complaint_about(slip + ": 1");
      EXPECT_THAT(message, StartsWith("test.yaml:1:1: " + slip + ": unknown key; did you mean '")) << slip;
    }
    EXPECT_THAT(complaint_about(dropped + ": 1"), HasSubstr("did you mean '" + key.name + "'?"));
  }
}

TEST(BadKeys, NoKeyIsGivenTwice) {
  for (const auto& key : scenario_keys()) {
    if (key.name == "walk.commands" || key.name == "name") continue;
    const std::string line = key.name + ": " + key.print(default_scenario());
    EXPECT_EQ(complaint_about(line + "\n" + line),
              fmt::format("test.yaml:2:1: {}: given twice, first in line 1", key.name));
  }
}

}  // namespace
}  // namespace sim::scenario
