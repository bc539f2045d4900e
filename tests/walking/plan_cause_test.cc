#include "walking/plan_cause.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <stdexcept>

#include "walking/pattern_generator.h"

namespace walking {
namespace {

using testing::EndsWith;
using testing::HasSubstr;

std::string refusal_of(const WalkOptions& options) {
  try {
    PatternGenerator generator(options);
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "";
}

WalkOptions walk_of(const Command& command) {
  WalkOptions options;
  options.commands = {Stand{0.1}, command};
  return options;
}

TEST(PlanCause, IsTheLengthOfTheStepsWhereThatIsTooLong) {
  WalkOptions options = walk_of(Straight{2, 0});
  options.step_length_m = 0.4;
  EXPECT_THAT(refusal_of(options),
              EndsWith("the cause is walk.step_length_m 0.4, with 0.15 the legs can follow"));
}

TEST(PlanCause, IsTheKeyOfTheWalkThatThrowsTheBodyAside) {
  WalkOptions options = walk_of(Straight{0, 1});
  options.com_height_m = 0.3;
  EXPECT_THAT(refusal_of(options),
              EndsWith("the cause is walk.com_height_m 0.3, with 0.814 the legs can follow"));
  options = walk_of(Straight{0, 1});
  options.preview_s = 0.1;
  EXPECT_THAT(refusal_of(options), HasSubstr("the cause is walk.preview_s 0.1, with 1.6"));
}

TEST(PlanCause, IsTheRadiusOfATightCircle) {
  for (const Command& command : {Command(TangentArc{0.2, 1.5}), Command(PerpendicularArc{0.2, 1.5})})
    EXPECT_THAT(refusal_of(walk_of(command)), HasSubstr("_arc.radius_m 0.2, with 0.75 the legs can follow"));
}

TEST(PlanCause, IsTheFieldOfTheFirstStepThatIsBeyondTheLegs) {
  const Step good{0.1, 0.19, 0}, turned{0, 0.2, std::numbers::pi / 2}, far{0.9, -0.19, 0};
  EXPECT_THAT(refusal_of(walk_of(Steps{{turned}})),
              EndsWith("the cause is walk.commands[1].steps[0].turn_deg 90, with 0 the legs can follow"));
  EXPECT_THAT(refusal_of(walk_of(Steps{{good, far, good}})),
              EndsWith("the cause is walk.commands[1].steps[1].forward_m 0.9, with 0 the legs can follow"));
}

TEST(PlanCause, IsNoneWhereSeveralKeysAreWrong) {
  WalkOptions options = walk_of(Straight{0, 1});
  EXPECT_EQ(cause_of_infeasible(options, 1, [](const WalkOptions&) { return false; }),
            "no single key is the cause");
  EXPECT_EQ(cause_of_infeasible(options, 1, [](const WalkOptions&) { return true; }),
            "no single key is the cause")
      << "the command alone is feasible";
}

}  // namespace
}  // namespace walking
