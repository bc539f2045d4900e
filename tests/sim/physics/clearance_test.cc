#include "sim/physics/clearance.h"

#include <gmock/gmock.h>

#include "sim/physics/nominal_body.h"
#include "tests/sim/physics/test_worlds.h"

namespace sim::physics {
namespace {

using testing::StartsWith;

/// The half-sitting robot at places of a room.
class Stander {
 public:
  explicit Stander(const std::string& room, double margin_m = 0)
      : room_(load_model("hrp2", room, models()), margin_m) {}

  Clearance at(double x, double y) {
    walking::BodyPose pose{Eigen::Isometry3d::Identity(), half_sitting()};
    pose.X_PB.translate(Eigen::Vector3d(x, y, walking::hrp2::kWaistHeight));
    return room_.at(robot_positions(room_.model(), pose).data());
  }

  /// The object that the robot touches there; "" if none.
  std::string object(double x, double y) {
    const Clearance clearance = at(x, y);
    return clearance.collision ? clearance.collision->object : "";
  }

 private:
  RoomClearance room_;
};

TEST(RoomClearance, NothingIsNearWhereTheWalksBegin) {
  for (const char* room : {"office", "hall"}) {
    const Clearance clearance = Stander(room).at(0, 0);
    EXPECT_FALSE(clearance.collision.has_value()) << room;
    EXPECT_GT(clearance.distance_m, 1) << room;
  }
}

TEST(RoomClearance, ABareFloorIsEndlesslyFree) {
  EXPECT_EQ(Stander("floor").at(1e4, 0).distance_m, std::numeric_limits<double>::infinity());
}

// A robot with its waist on a wall's plane stands through that wall, everywhere along it: the walls have no
// gap.
TEST(RoomClearance, WallsAreSolidAllAround) {
  struct Extent {
    const char* room;
    double x_min, x_max, y_min, y_max;
  };
  for (const Extent& e :
       {Extent{"office", -4.6, 6.4, -3.35, 3.65}, Extent{"hall", -11.6, 13.4, -5.35, 12.65}}) {
    Stander robot(e.room);
    for (double x = e.x_min; x <= e.x_max; x += 0.2)
      for (const double y : {e.y_min, e.y_max})
        EXPECT_NE(robot.object(x, y), "") << e.room << " " << x << " " << y;
    for (double y = e.y_min; y <= e.y_max; y += 0.2)
      for (const double x : {e.x_min, e.x_max})
        EXPECT_NE(robot.object(x, y), "") << e.room << " " << x << " " << y;
  }
}

TEST(RoomClearance, NamesLinkAndObjectAndTellsWhere) {
  const Clearance clearance = Stander("hall").at(0, -4.965);  // beside the right wall, y = -5.35
  ASSERT_TRUE(clearance.collision.has_value());
  EXPECT_THAT(clearance.collision->link, StartsWith("RARM_LINK"));
  EXPECT_EQ(clearance.collision->object, "wall_right");
  EXPECT_NEAR(clearance.collision->p_W.x(), 0, 0.3);
  EXPECT_NEAR(clearance.collision->p_W.y(), -5.35, 0.05);
  EXPECT_LE(clearance.distance_m, 0);
}

TEST(RoomClearance, FurnitureIsSolid) {
  Stander robot("office");
  EXPECT_EQ(robot.object(3.9, 1.17), "desk_1");
  EXPECT_EQ(robot.object(-4.0, -0.4), "sofa");
  EXPECT_EQ(robot.object(-2.75, -0.5), "low_table");
}

// Its upper surface is 6 mm above the floor's.
TEST(RoomClearance, ARugIsPartOfTheFloor) {
  const Clearance clearance = Stander("office").at(-2.15, 0.4);
  EXPECT_FALSE(clearance.collision.has_value()) << clearance.collision->object;
}

// Walking sideways into a flat wall, in steps of 1 mm.
TEST(RoomClearance, AMarginIsADistance) {
  const auto first = [](double margin_m) {
    Stander robot("hall", margin_m);
    double y = -4.7;
    while (!robot.at(0, y).collision) y -= 0.001;
    return y;
  };
  EXPECT_NEAR(first(0.05) - first(0), 0.05, 0.002);
}

// World's sparse checks rely on this.
TEST(RoomClearance, TheDistanceIsNeverMoreThanTheWayToTheFirstTouch) {
  Stander robot("office");
  double touched_x = 0;
  while (!robot.at(touched_x, 0).collision) touched_x += 0.01;
  EXPECT_GT(touched_x, 2);
  for (double x = 0; x < touched_x; x += 0.05) EXPECT_LE(robot.at(x, 0).distance_m, touched_x - x) << x;
}

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
