#include "sim/files/csv.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/files/text.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::files {
namespace {

using testing::ElementsAre;

class CsvTest : public testing::Test {
 protected:
  std::filesystem::path file(const std::string& text) const {
    write_text(folder_ / "rows.csv", text);
    return folder_ / "rows.csv";
  }
  std::vector<std::vector<std::string>> rows(const std::string& text) const {
    std::vector<std::vector<std::string>> all;
    for (CsvReader csv(file(text)); csv.next();) {
      all.emplace_back();
      for (std::size_t i = 0; i < csv.fields(); ++i) all.back().emplace_back(csv.text(i));
    }
    return all;
  }
  std::string complaint(const std::string& text) const {
    return error_of([&] { rows(text); }).substr(folder_.path().string().size() + 1);
  }
  const TemporaryFolder folder_;
};

TEST_F(CsvTest, AQuotedFieldIsReadAsItIs) {
  EXPECT_THAT(rows("a,b\n\"1, 2\",3\n"), ElementsAre(ElementsAre("1, 2", "3")));
  EXPECT_THAT(rows("a,b\n\"\",\" say \"\"no\"\" \"\r\n"), ElementsAre(ElementsAre("", " say \"no\" ")));
  EXPECT_THAT(rows("\xef\xbb\xbf\"a,\",b\n1,2"), ElementsAre(ElementsAre("1", "2")));
  EXPECT_THAT(rows("a,b\n 5\" ,x\"y\"\n"), ElementsAre(ElementsAre("5\"", "x\"y\""))) << "within a field";
  EXPECT_THAT(rows("a\n" + csv_field("two\nlines \"\"") + "\n"), ElementsAre(ElementsAre("two lines \"\"")));
}

TEST_F(CsvTest, NamesOfStrangersAreNoFormulasAndNoCommands) {
  for (const auto& [name, field] : {std::pair{"=1+1", "'=1+1"},
                                    {"@sum", "'@sum"},
                                    {"-0.5", "-0.5"},
                                    {"-x,y", "\"'-x,y\""},
                                    {"a\x1b[2J\n", "a?[2J?"},
                                    {"plain", "plain"}})
    EXPECT_EQ(neutral_field(name), field);
}

TEST_F(CsvTest, WhatIsWrongWithQuotesIsNamedWithItsPlace) {
  EXPECT_EQ(complaint("a,b\n1,\"2\n3,4\n"), "rows.csv:2: a quoted field does not end");
  EXPECT_EQ(complaint("a,b\n\"1\"2,3\n"), "rows.csv:2:4: expected a comma after the quoted field");
  EXPECT_EQ(complaint("a,b\n\"1\",2\n3\n"), "rows.csv:3: expected 2 fields, found 1");
  EXPECT_EQ(complaint("\""), "rows.csv:1: a quoted field does not end");
}

TEST_F(CsvTest, NumbersMayBeQuotedAndComplaintsNameTheirColumn) {
  CsvReader csv(file("a,b\n\"1.5\",\"x\"\n"));
  ASSERT_TRUE(csv.next());
  EXPECT_EQ(csv.number(0), 1.5);
  EXPECT_THAT(error_of([&] { csv.number(1); }),
              testing::EndsWith("rows.csv:2:8: expected a finite number, found \"x\""));
}

}  // namespace
}  // namespace sim::files
