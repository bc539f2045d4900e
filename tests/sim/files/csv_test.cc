#include "sim/files/csv.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>

#include "sim/files/json.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::files {
namespace {

using testing::ElementsAre, testing::StartsWith;

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

std::string json_complaint(const std::string& text, const std::function<void(const Json&)>& read) {
  const std::string error = error_of([&] { read(Json("a.json", text)); });
  EXPECT_TRUE(error.empty() || error.starts_with("a.json: ")) << error;
  return error.substr(std::min<std::size_t>(error.size(), 8));
}

TEST(Json, ValuesAreReadWithTheirTypes) {
  const Json json("a.json", R"({"t": "x", "n": -1.5, "w": 18446744073709551615, "f": true, "nothing": null,
                                "list": [1, {"deep": "y"}], "object": {"b": 1, "a": 2}})");
  EXPECT_EQ(json.at("t").text(), "x");
  EXPECT_EQ(json.at("n").number(), -1.5);
  EXPECT_EQ(json.at("w").whole(), 18446744073709551615u);
  EXPECT_TRUE(json.at("f").flag());
  EXPECT_FALSE(json.at("nothing").number_or_null());
  EXPECT_FALSE(json.find("nothing"));
  EXPECT_FALSE(json.find("else"));
  EXPECT_EQ(json.at("list").items()[1].at("deep").text(), "y");
  EXPECT_EQ(json.at("object").entries()[0].first, "b") << "the order of the file";
}

TEST(Json, AnotherTypeIsNamedWithFileAndKey) {
  const std::string text = R"({"a": {"b": [1, "x"]}, "n": -1, "f": 1.5, "t": "x", "o": {}})";
  const auto says = [&](const std::function<void(const Json&)>& read) { return json_complaint(text, read); };
  EXPECT_EQ(says([](const Json& j) { j.at("a").text(); }), "a: expected text, found object");
  EXPECT_EQ(says([](const Json& j) { j.at("a").at("b").items()[1].number(); }),
            "a.b[1]: expected a number, found string");
  EXPECT_EQ(says([](const Json& j) { j.at("a").at("c"); }), "a.c: is missing");
  EXPECT_EQ(says([](const Json& j) { j.at("t").at("c"); }), "t: expected an object, found string");
  EXPECT_EQ(says([](const Json& j) { j.at("t").find("c"); }), "t: expected an object, found string");
  EXPECT_EQ(says([](const Json& j) { j.at("n").whole(); }),
            "n: expected a whole number from 0, found number");
  EXPECT_EQ(says([](const Json& j) { j.at("f").whole(); }),
            "f: expected a whole number from 0, found number");
  EXPECT_EQ(says([](const Json& j) { j.at("f").flag(); }), "f: expected true or false, found number");
  EXPECT_EQ(says([](const Json& j) { j.at("o").items(); }), "o: expected a list, found object");
  EXPECT_EQ(says([](const Json& j) { j.at("t").entries(); }), "t: expected an object, found string");
}

TEST(Json, OnlyObjectsAreAccepted) {
  for (const char* text : {"", "{", "[]", "1", "null", "{\"a\": 1e999}", "{} {}", "\xff"})
    EXPECT_THROW(Json("a.json", text), FileError) << text;
}

// Printing a deeper tree would exhaust the stack.
TEST(Json, ADeepTreeIsRejected) {
  const auto nested = [](int depth) {
    return "{\"a\": " + std::string(static_cast<std::size_t>(depth), '[') +
           std::string(static_cast<std::size_t>(depth), ']') + "}";
  };
  EXPECT_EQ(json_complaint(nested(60), [](const Json&) {}), "");
  EXPECT_THAT(json_complaint(nested(1'000'000), [](const Json&) {}), StartsWith("is nested deeper"));
}

TEST(Json, BytesThatAreNotUtf8AreReplaced) {
  EXPECT_EQ(json_text({{"file", "a\xff"}}), "{\"file\":\"a\xef\xbf\xbd\"}");
}

}  // namespace
}  // namespace sim::files
