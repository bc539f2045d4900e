// Seeds as users write them.
#include "sim/scenario/yaml.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sim::scenario {
namespace {

using testing::ElementsAre;

TEST(Seeds, KeepTheOrderInWhichTheyAreWritten) {
  EXPECT_THAT(parse_seeds("7"), ElementsAre(7));
  EXPECT_THAT(parse_seeds("9,1..3,5"), ElementsAre(9, 1, 2, 3, 5));
  EXPECT_THAT(parse_seeds("18446744073709551614..18446744073709551615"),
              ElementsAre(18446744073709551614U, 18446744073709551615U));
}

TEST(Seeds, FaultsAreNamed) {
  for (const auto& [text, problem] : {std::pair("", "'' is not a seed, expected for example 1..5 or 1,2,7"),
                                      {"1,", "'' is not a seed"},
                                      {"1,x", "'x' is not a seed"},
                                      {"3..1", "'3..1' goes backwards"},
                                      {"1..3,2", "a seed is given twice"},
                                      {"1..100001", "more than 100000 seeds"}})
    EXPECT_THAT([seeds = text] { parse_seeds(seeds); },
                testing::ThrowsMessage<std::invalid_argument>(testing::StartsWith(problem)));
}

}  // namespace
}  // namespace sim::scenario
