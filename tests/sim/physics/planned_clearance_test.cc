#include <gmock/gmock.h>

#include "sim/physics/clearance.h"
#include "tests/sim/physics/half_sitting_world.h"

namespace sim::physics {
namespace {

std::optional<PlannedCollision> collision(std::vector<walking::Command> commands, const std::string& room) {
  walking::WalkOptions walk;
  walk.commands = std::move(commands);
  WorldOptions world;
  world.room = room;
  return first_collision(walking::PatternGenerator(walk), load_model("hrp2", world.room, models()));
}

TEST(PlannedClearance, NineMetersAheadAreTooLongForTheOfficeAndFreeInTheHall) {
  const auto found = collision({walking::Stand{1}, walking::Straight{9, 0}}, "office");
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->command, 1);
  EXPECT_GT(found->t_s, 10);  // 2.5 m at 0.15 m in 0.8 s
  EXPECT_LT(found->t_s, 30);
  EXPECT_GT(found->p_W.x(), 2);
  EXPECT_LT(found->p_W.x(), 4);
  EXPECT_FALSE(collision({walking::Straight{9, 0}}, "hall").has_value());
  EXPECT_FALSE(collision({walking::Straight{9, 0}}, "floor").has_value());
}

TEST(PlannedClearance, FourteenMetersAheadAreTooLongForTheHall) {
  const auto found = collision({walking::Straight{14, 0}}, "hall");
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->p_W.x(), 13.4, 0.3);
}

TEST(PlannedClearance, AWalkIntoTheLeftWallEndsThere) {
  const auto found = collision({walking::Straight{-0.9, 0}, walking::Straight{0, 4}}, "office");
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->command, 1);
  EXPECT_EQ(found->object, "wall_left");
  EXPECT_THAT(found->link, testing::StartsWith("LARM_LINK"));
}

}  // namespace
}  // namespace sim::physics
