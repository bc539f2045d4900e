#include "sim/result/about_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/files/text.h"
#include "tests/sim/files/temporary_folder.h"

namespace sim::result {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

class AboutFile : public testing::Test {
 protected:
  About read(const std::string& text) const {
    files::write_text(folder_ / "about.json", text);
    return read_about(folder_ / "about.json");
  }
  const files::TemporaryFolder folder_;
};

TEST_F(AboutFile, WhatIsLeftOutIsEmpty) {
  const About about = read(R"({"walk_ending": "fell", "seed": 3, "set_by": {"seed": "argument 1"}})");
  ASSERT_TRUE(about.walk);
  EXPECT_EQ(about.walk->ending, scenario::Ending::fell);
  EXPECT_EQ(about.seed, 3u);
  EXPECT_EQ(about.set_by.at("seed"), "argument 1");
  EXPECT_EQ(about.program, "");
  EXPECT_THAT(([&] { read("{}"), read_about_of_walk(folder_ / "about.json"); }),
              ThrowsMessage<files::FileError>(HasSubstr("about.json: walk_ending: is missing")));
}

TEST_F(AboutFile, AnotherTypeIsNamedWithItsKey) {
  for (const auto& [text, complaint] :
       {std::pair{R"({"program": 1})", "about.json: program: expected text, found number"},
        {R"({"seed": -1})", "about.json: seed: expected a whole number from 0, found number"},
        {R"({"set_by": []})", "about.json: set_by: expected an object, found array"},
        {R"({"set_by": {"seed": 1}})", "about.json: set_by.seed: expected text, found number"},
        {R"({"recording_xxh3_128": {}})", "about.json: recording_xxh3_128: expected text, found object"},
        {"[]", "about.json: expected a JSON object"}})
    EXPECT_THAT(([&, file = text] { read(file); }), ThrowsMessage<files::FileError>(HasSubstr(complaint)));
}

}  // namespace
}  // namespace sim::result
