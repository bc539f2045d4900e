// Seeds as users write them.
#include "sim/scenario/yaml_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

namespace sim::scenario {
namespace {

using testing::ElementsAre;

std::string seeds_error(std::string_view text) {
  try {
    parse_seeds(text);
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "none";
}

TEST(Seeds, KeepTheOrderInWhichTheyAreWritten) {
  EXPECT_THAT(parse_seeds("7"), ElementsAre(7));
  EXPECT_THAT(parse_seeds("9,1..3,5"), ElementsAre(9, 1, 2, 3, 5));
  EXPECT_THAT(parse_seeds("18446744073709551614..18446744073709551615"),
              ElementsAre(18446744073709551614U, 18446744073709551615U));
}

TEST(Seeds, FaultsAreNamed) {
  EXPECT_EQ(seeds_error(""), "'' is not a seed, expected for example 1..5 or 1,2,7");
  EXPECT_THAT(seeds_error("1,"), testing::StartsWith("'' is not a seed"));
  EXPECT_THAT(seeds_error("1,x"), testing::StartsWith("'x' is not a seed"));
  EXPECT_THAT(seeds_error("3..1"), testing::StartsWith("'3..1' goes backwards"));
  EXPECT_THAT(seeds_error("1..3,2"), testing::StartsWith("a seed is given twice"));
  EXPECT_THAT(seeds_error("1..100001"), testing::StartsWith("more than 100000 seeds"));
}

}  // namespace
}  // namespace sim::scenario
