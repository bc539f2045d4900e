#include "sim/files/text_table.h"

#include <gmock/gmock.h>

#include <sstream>

namespace sim::files {
namespace {

using testing::HasSubstr;

TEST(TextTable, ColumnsAreAsWideAsTheyNeedToBe) {
  EXPECT_EQ(text_table({{"name", "n"}, {"a", "1"}, {"a", "10"}, {"b", "2"}}, {}),
            "name   n\na      1\na     10\n\nb      2\n");
}

TEST(TextTable, LongTitlesAreBrokenBeforeColumnsAreMoved) {
  const std::string text =
      text_table({{"s", "slam.vision.sigma_px", "x"}, {"hall", "0.5", "1"}}, {.width = 24});
  EXPECT_EQ(text, "         slam.\n       vision.\ns     sigma_px  x\nhall       0.5  1\n");
}

TEST(TextTable, NoLineIsWiderThanAskedFor) {
  std::vector<std::vector<std::string>> rows{{"scenario"}, {"tangent_circle"}};
  for (int i = 0; i < 12; ++i) {
    rows[0].push_back("navigation_end_position_error_m" + std::to_string(i));
    rows[1].push_back("0.01234");
  }
  const std::string text = text_table(rows, {});
  std::istringstream lines(text);
  int named = 0;
  for (std::string line; std::getline(lines, line);) {
    EXPECT_LE(line.size(), kTerminalWidth) << line;
    named += line.starts_with("tangent_circle");
  }
  EXPECT_EQ(named, 2) << "each table repeats the naming column";
  for (int i = 0; i < 12; ++i) EXPECT_THAT(text, HasSubstr("m" + std::to_string(i)));
}

}  // namespace
}  // namespace sim::files
