// Whatever is in a scenario file, its reader gives a scenario or one line with the place: no other exception,
// no crash (the sanitizers see what does not show), no endless reading.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <iterator>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "sim/scenario/scenario.h"
#include "sim/scenario/yaml.h"
#include "tests/sim/files/damage.h"
#include "tests/sim/scenario/scenario_files.h"

namespace sim::scenario {
namespace {

using sensor_errors::Random;
using Lines = std::vector<std::string>;

constexpr int kTrials = 120;  // of each file

std::string content(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

Lines lines_of(const std::string& text) {
  std::istringstream in(text);
  Lines lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::string joined(const Lines& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + '\n';
  return text;
}

std::string repeated(const std::string& piece, int times) {
  std::string text;
  for (int i = 0; i < times; ++i) text += piece;
  return text;
}

/// Values of the wrong type, out of any range, or in letters that are none.
const std::string& odd_value(sensor_errors::Random& random) {
  static const std::array<std::string, 22> kValues{"1e999",
                                                   "-1e308",
                                                   "99999999999999999999999",
                                                   "5e-324",
                                                   "-0",
                                                   ".nan",
                                                   "{}",
                                                   "[]",
                                                   "[[1, [2]], {a: b}]",
                                                   "true",
                                                   "~",
                                                   "!!binary aGVsbG8=",
                                                   "&a [*a]",
                                                   "*a",
                                                   "<<: *a",
                                                   "|\n    text",
                                                   "'",
                                                   "\"\\u2028\\U0010ffff\"",
                                                   "\xe2\x80\xae"
                                                   "0.5",
                                                   "½",
                                                   "\xef\xbb\xbf"
                                                   "1",
                                                   "\xed\xa0\x80"};
  return kValues[random.bits() % kValues.size()];
}

/// One wound to the lines: lost, doubled, moved, indented, or given another value or a deep one.
void wound(Lines& lines, sensor_errors::Random& random) {
  const std::size_t at = random.bits() % lines.size(), other = random.bits() % lines.size();
  std::string& line = lines[at];
  const std::size_t colon = line.find(':');
  switch (random.bits() % 7) {
    case 0:
      lines.erase(lines.begin() + static_cast<long>(at));
      break;
    case 1:
      lines.insert(lines.begin() + static_cast<long>(at), lines[other]);
      break;
    case 2:
      std::swap(line, lines[other]);
      break;
    case 3:
      line = std::string(1 + random.bits() % 5, random.bits() % 4 ? ' ' : '\t') + line;
      break;
    case 4:
      line =
          line.substr(0, colon) + ": " + repeated(random.bits() % 2 ? "[" : "{a: ", 1 << random.bits() % 12);
      break;
    default:
      line = line.substr(0, colon) + ": " + odd_value(random);
  }
}

/// Damaged as the bytes of a file or as lines of YAML.
std::string damaged(const std::string& whole, sensor_errors::Random& random) {
  if (random.bits() % 2) return tests::damaged(whole, random);
  Lines lines = lines_of(whole);
  for (std::uint64_t wounds = 1 + random.bits() % 3; wounds > 0 && !lines.empty(); --wounds)
    wound(lines, random);
  return joined(lines);
}

/// What the reader says; empty of a text that it takes. `place` is what it must begin with.
std::string complaint_at(const std::function<void()>& read, const std::string& place, const std::string& text) {
  try {
    read();
  } catch (const ConfigError& error) {
    const std::string said = error.what();
    EXPECT_TRUE(std::regex_search(said, std::regex("^" + place + ":[1-9][0-9]*:[1-9][0-9]*: .")))
        << said << "\n"
        << text.substr(0, 2000);
    EXPECT_EQ(said.find('\n'), said.npos) << said;
    return said;
  } catch (const std::exception& error) {
    ADD_FAILURE() << "not a ConfigError: " << error.what() << "\n" << text.substr(0, 2000);
    return error.what();
  }
  return "";
}

TEST(DamagedScenario, IsReadOrRefusedWithItsPlace) {
  int read = 0;  // of all damaged files: a short file hardly survives
  for (const std::filesystem::path& file : scenario_files()) {
    Lines lines = lines_of(content(file));  // damage to comments would show nothing
    std::erase_if(lines, [](const std::string& line) { return line.empty() || line.starts_with('#'); });
    const std::string whole = joined(lines);
    sensor_errors::Random random(1, file.filename().string());
    // beside the original, where its bases are
    const std::string place = (file.parent_path() / "a.yaml").string();
    EXPECT_NO_THROW(read_scenario_text(whole, place)) << file;
    int refused = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      const std::string text = damaged(whole, random);
      refused += !complaint_at([&] { read_scenario_text(text, place); }, ".*\\.yaml", text).empty();
    }
    EXPECT_GT(refused, kTrials / 2) << file;
    read += kTrials - refused;
  }
  EXPECT_GT(read, 100);
}

TEST(DamagedScenario, SoIsWhatAnArgumentSays) {
  const std::string whole = content(scenario_folder() / "every_command.yaml");
  const std::vector<std::string> arguments{"slam.gyro.sigma_rad_s=0.02",
                                           "walk.commands=[{stand: {duration_s: 1}}]",
                                           "errors.faults=[{frames_lost: {from_s: 20, duration_s: 2}}]",
                                           "limits.rmse_m.at_most=0.1", "world.room=hall"};
  sensor_errors::Random random(1, "arguments");
  int refused = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const std::string text = tests::damaged(arguments[random.bits() % arguments.size()], random);
    Changes changes;
    changes.overrides = {text};
    refused +=
        !complaint_at([&] { read_scenario_text(whole, "a.yaml", changes); }, "(<argument>|a\\.yaml)", text)
             .empty();
  }
  EXPECT_GT(refused, 200);
}

// A file of 1 MiB is as large as is read at all.
TEST(DamagedScenario, OfOneKindOnlyIsRefusedAsWell) {
  std::string many_keys;
  for (int i = 0; many_keys.size() < (1 << 20) - 20; ++i) many_keys += fmt::format("k{}: 1\n", i);
  const int n = 1 << 20;
  for (const std::string& text :
       {repeated("[", n), repeated("{", n), repeated("- ", n / 2), repeated("a: ", n / 3),
        repeated("[{a: ", n / 5), repeated("? ", n / 2), repeated("\n", n), repeated("#", n),
        repeated("'", n), repeated("&a ", n / 3), repeated("\xff", n), repeated("---\n", n / 4),
        repeated("\"\\x", n / 3), std::string(n, 'a'), "seed: " + std::string(n - 8, '9'),
        "name: " + std::string(n - 8, 'a'), "a: [" + repeated("1,", n / 2 - 4) + "]", many_keys})
    EXPECT_NE(complaint_at([&] { read_scenario_text(text, "a.yaml"); }, "a\\.yaml", text.substr(0, 60)), "")
        << text.substr(0, 60);
}

}  // namespace
}  // namespace sim::scenario
