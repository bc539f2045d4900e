// Short walks in each direction, as `robot check` and the search for a gait use them.
#include "sim/live/short_walks.h"

#include "sim/scenario/robot.h"
#include "tests/sim/live/run_folder.h"

namespace sim::live {
namespace {

using testing::HasSubstr;

class ShortWalks : public tests::RunFolder {
 protected:
  static Walked walk(const std::vector<walking::Command>& commands,
                     const std::function<void(scenario::Scenario&)>& change = {},
                     std::optional<std::uint64_t> seed = {}) {
    static const scenario::Scenario read =
        RunFolder::read("world: {robot: g1, room: floor}\nwalk: {commands: [{stand: {}}]}\n").scenario;
    static const physics::Models models(scenario::read_robot(read), physics::kPhysicalRoom, kModels);
    scenario::Scenario scenario = read;
    if (change) change(scenario);
    return walked(scenario, models, commands, seed);
  }
};

TEST_F(ShortWalks, GoEightSecondsInEachDirection) {
  walking::WalkOptions options;
  options.single_support_s = 0.6, options.double_support_s = 0.2, options.step_length_m = 0.1;
  std::vector<Eigen::Vector3d> moves;  // ahead, left, turn
  for (const ShortWalk& walk : short_walks(options)) {
    const walking::Command& command = walk.commands[1];
    if (const auto* straight = std::get_if<walking::Straight>(&command))
      moves.emplace_back(straight->forward_m, straight->left_m, 0);
    else
      moves.emplace_back(0, 0, std::get<walking::Turn>(command).angle_rad);
  }
  const double turn = 9 * std::numbers::pi / 18;
  const std::vector<Eigen::Vector3d> expected{{0.9, 0, 0},  {-0.9, 0, 0}, {0, 0.5, 0},
                                              {0, -0.5, 0}, {0, 0, turn}, {0, 0, -turn}};
  ASSERT_EQ(moves.size(), expected.size());
  for (std::size_t i = 0; i < moves.size(); ++i) EXPECT_LT((moves[i] - expected[i]).norm(), 1e-12) << i;
}

TEST_F(ShortWalks, MeasureTheEndOfTheWalkAgainstItsCommands) {
  const Walked ahead = walk({walking::Straight{0.48, 0}},
                            [](scenario::Scenario& s) { s.walk.steering.by = walking::SteeredBy::legs; });
  EXPECT_EQ(ahead.complaint(), "");
  EXPECT_EQ(ahead.lasted, 1);
  EXPECT_NEAR(ahead.path_m, 0.48, 1e-4);
  EXPECT_LT(ahead.error_m, 0.03);
  EXPECT_GE(ahead.landings[0] + ahead.landings[1], 5);
  EXPECT_GT(ahead.slip_m, 0);
  const Walked slippery = walk(
      {walking::Straight{0.48, 0}},
      [](scenario::Scenario& s) {
        s.world.floor_friction = 0.05;
        s.world.variation.friction = 0;
      },
      1);
  EXPECT_GT(slippery.slip_m, 3 * ahead.slip_m);
}

TEST_F(ShortWalks, SteeredByLegOdometryEndWithTheHeadingOfTheirCommands) {
  const auto error_by = [](walking::SteeredBy by) {
    const auto steer = [by](scenario::Scenario& s) { s.walk.steering.by = by, s.world.floor_friction = 0.2; };
    return walk({walking::Turn{std::numbers::pi / 2}}, steer, 1).yaw_error_rad;
  };
  const double by_legs = error_by(walking::SteeredBy::legs);
  const double gyro = 3 * walking::StabilizerOptions{}.gyro_sigma_rad_s * std::sqrt(8 * walking::kPeriod);
  EXPECT_LT(by_legs, 0.5 * std::numbers::pi / 180 + gyro + 1e-3)
      << "the tolerance of steering, 3 sigma of the gyro's noise over 8 s, and the way to stand still";
  EXPECT_GT(error_by(walking::SteeredBy::plan), 2 * by_legs);
}

TEST_F(ShortWalks, SayHowAWalkFellOrWhyItCannotBePlanned) {
  const Walked fell = walk({walking::Straight{0.48, 0}}, [](scenario::Scenario& s) {
    s.walk.single_support_s = 1.5;
    s.stabilizer.enabled = false;
  });
  EXPECT_THAT(fell.complaint(), HasSubstr("fell "));
  EXPECT_LT(fell.lasted, 1);
  const Walked unplanned =
      walk({walking::Straight{2, 0}}, [](scenario::Scenario& s) { s.walk.step_length_m = 0.4; });
  EXPECT_EQ(unplanned.lasted, 0);
  EXPECT_NE(unplanned.complaint(), "");
}

TEST_F(ShortWalks, HaveAComplaintBeyondFifteenDegreesOrATenthOfThePath) {
  Walked walk{.lasted = 1, .path_m = 2, .error_m = 0.199, .yaw_error_rad = 14.9 * std::numbers::pi / 180};
  EXPECT_EQ(walk.complaint(), "");
  walk.error_m = 0.201;
  EXPECT_EQ(walk.complaint(), "ends 0.20 m and 15 deg from the end of its path of 2.00 m");
  walk.error_m = 0, walk.yaw_error_rad = 15.1 * std::numbers::pi / 180;
  EXPECT_NE(walk.complaint(), "");
  const Walked turn{.lasted = 1, .error_m = 0.049};
  EXPECT_EQ(turn.complaint(), "") << "turning on the spot has no path";
}

}  // namespace
}  // namespace sim::live
