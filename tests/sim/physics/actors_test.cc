#include "sim/physics/actors.h"

#include "sim/physics/clearance.h"
#include "tests/sim/physics/test_worlds.h"
#include "tests/walking/walks.h"

namespace sim::physics {
namespace {

using Eigen::Vector2d, Eigen::Vector3d, testing::HasSubstr;

double yaw_at(const Actor& actor, double t_s) {
  const Eigen::Matrix3d R = pose_at(script_of(actor), t_s).linear();
  return std::atan2(R(1, 0), R(0, 0));
}
Vector2d place_at(const Actor& actor, double t_s) {
  return pose_at(script_of(actor), t_s).translation().head<2>();
}

TEST(Actors, APersonWalksStraightBetweenPlacesAndTurnsToTheNextOne) {
  const Person there{{{2, 1, 0}, {4, 3, 0}, {5, 3, 1}}};
  for (const auto& [t, x, y, yaw] : {std::array{0., 1., 0., 0.},
                                     {2, 1, 0, 0},
                                     {3, 2, 0, 0},
                                     {4, 3, 0, 0},
                                     {4.7, 3, 0.7, M_PI / 2},
                                     {9, 3, 1, M_PI / 2}}) {
    EXPECT_LT((place_at(there, t) - Vector2d(x, y)).norm(), 1e-9) << t;
    EXPECT_NEAR(yaw_at(there, t), yaw, 1e-9) << t;
  }
  EXPECT_GT(yaw_at(there, 4.35), 0.1);
  EXPECT_LT(yaw_at(there, 4.35), 1.5);
  const Person patrol{{{1, 0, 0}, {3, 2, 0}, {5, 0, 0}}, true};
  for (const auto& [t, x] :
       {std::pair(0., 0.), {2, 1}, {4, 1}, {5.5, 0.5}, {1 + 40 + 0.5, 0.5}, {1 + 40 + 3.5, 0.5}})
    EXPECT_NEAR(place_at(patrol, t).x(), x, 1e-9) << t;
}

TEST(Actors, ADoorSwingsAboutItsHinge) {
  const Door door{
      .x_m = 1, .y_m = 2, .width_m = 0.8, .closed_rad = 0.1, .opening_rad = -1, .opens_s = 3, .closes_s = 8};
  for (const auto& [t, yaw] :
       {std::pair(0., 0.1), {3, 0.1}, {4, -0.4}, {5, -0.9}, {8, -0.9}, {9, -0.4}, {99, 0.1}}) {
    EXPECT_NEAR(yaw_at(door, t), yaw, 1e-9) << t;
    EXPECT_EQ(place_at(door, t), Vector2d(1, 2));
  }
  EXPECT_THAT(Door({.opens_s = 3, .closes_s = 4}).problem().value_or(""),
              HasSubstr("closes before it is open"));
}

TEST(Actors, AreInTheRoomWhereverTheRobotStarts) {
  WorldOptions world;
  world.actors = {Person{{{0, 1, 0}, {2, 3, 0}}}, Door{.x_m = 1, .y_m = 2, .closed_rad = 0.3}};
  world.start = {2, -1, 0.7};
  const Eigen::Isometry3d X_WR = world.start.X_RW().inverse();
  for (const std::size_t i : {0u, 1u})
    for (const double t : {0.0, 1.3, 9.0})
      EXPECT_TRUE(pose_at(script_of(world.actors_in_W()[i]), t)
                      .isApprox(X_WR * pose_at(script_of(world.actors[i]), t), 1e-9))
          << i << " " << t;
}

TEST(Actors, WrongPathsAreRejected) {
  for (const auto& [person, problem] :
       {std::pair(Person{}, "has no path"),
        {Person{{{0, 0, 0}, {0, 1, 0}}}, "do not increase"},
        {Person{{{0, 0, 0}, {1, 4, 0}}}, "faster than 3 m/s"},
        {Person{{{0, 0, 0}, {1, 1, 0}}, true}, "does not end where it begins"}})
    EXPECT_THAT(person.problem().value_or(""), HasSubstr(problem));
}

// No part may be faster than clearance assumes, over a path with sharp turns.
TEST(Actors, AreNoFasterThanAssumed) {
  for (const Actor& actor :
       std::vector<Actor>{Person{{{0, 0, 0}, {1, 2.9, 0}, {2, 0, 0}, {3, 0, 2.9}, {4, 0, 0}}, true},
                          Door{.width_m = 1.5, .opening_rad = M_PI, .opens_s = 1}})
    for (double t = 0; t < 6; t += 0.01)
      for (const score::Surface& shape : shapes_of(actor)) {
        const double width =
            std::holds_alternative<Door>(actor) ? shape.size.x() : 0.05;  // the arms are outermost
        const Vector3d p = shape.X_WS * Vector3d(width, std::copysign(0.05, shape.X_WS.translation().y()), 0);
        const auto at = [&](double when) { return Vector3d(pose_at(script_of(actor), when) * p); };
        EXPECT_LE((at(t + 0.01) - at(t)).norm(), 0.01 * kFastestActor_m_s) << t;
      }
}

// The person walks towards the standing robot, which is touched when both are as close as their shapes are
// wide.
TEST(Actors, AreSolidWhereTheyAreAtTheTime) {
  const std::vector<Actor> actors{Person{{{0, 3, 0}, {2, 0, 0}}}};
  RoomClearance room(load_model(robot_file(), "office", models(), Shapes::all, actors));
  walking::BodyPose pose{Eigen::Isometry3d::Identity(), half_sitting()};
  pose.X_PB.translate(Vector3d(0, 0, on_floor().robot.base_height));
  const Eigen::VectorXd q = robot_positions(room.model(), pose);
  EXPECT_FALSE(room.at(q.data(), 0).collision);
  double touched_s = 0;
  for (double free_s = 0, t = 0; touched_s == 0 && t < 2; t += std::max(free_s, 1e-3)) {
    const Clearance clearance = room.at(q.data(), t);
    if (clearance.collision) touched_s = t;
    free_s = clearance.distance_m / kFastest_m_s;
  }
  const auto touched = room.at(q.data(), touched_s).collision;
  ASSERT_TRUE(touched);
  EXPECT_EQ(touched->object, "person 0");
  EXPECT_NEAR(touched_s, 1.7, 0.15) << "half a meter before the robot's middle";
  const auto planned =
      first_collision(walking::PatternGenerator(on_floor().robot, walking::walk_of({walking::Stand{3}})),
                      load_model(robot_file(), "office", models(), Shapes::all, actors));
  ASSERT_TRUE(planned);
  EXPECT_NEAR(planned->t_s, touched_s, 0.1);
}

}  // namespace
}  // namespace sim::physics
