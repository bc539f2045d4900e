#include "sim/files/json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>

#include "tests/sim/files/temporary_folder.h"

namespace sim::files {
namespace {

using testing::StartsWith;

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
