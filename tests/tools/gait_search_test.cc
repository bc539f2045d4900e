#include "tools/cli/gait_search.h"

#include "sim/files/text.h"
#include "sim/scenario/robot.h"

namespace cli {
namespace {

using testing::HasSubstr;

TEST(LongGaitSearch, WritesTheGuessFirstThenBetterGaitsAndRepeatsWithTheSameSeed) {
  const fs::path model = scenario::standard_models() / "robots/g1/robot.xml";
  const auto search = [&](std::uint64_t seed) {
    std::vector<std::string> files;
    double last = 0;
    search_gait(
        model, "robot.xml", {.generations = 1, .population = 4, .seed = seed},
        [&](const std::string& yaml) { files.push_back(yaml); },
        [&](double part, const std::string&) {
          EXPECT_GT(part, last);
          last = part;
        });
    EXPECT_EQ(last, 1);
    return files;
  };
  const std::vector<std::string> files = search(1);
  ASSERT_GE(files.size(), 3u);
  EXPECT_THAT(files.front(), HasSubstr("# guess: not walked yet\n"));
  EXPECT_THAT(files.back(), HasSubstr("# found by walking: arrives at the end of 18 of 18 short walks"));
  EXPECT_EQ(search(1), files);
}

}  // namespace
}  // namespace cli
