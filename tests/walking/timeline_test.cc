#include "walking/timeline.h"

#include "tests/walking/walks.h"

namespace walking {
namespace {

Timeline timeline_of(std::vector<Command> commands) {
  return {kRobot, walk_of(std::move(commands)), {}, Eigen::Vector2d::Zero()};
}

TEST(Timeline, AlternatesDoubleAndSingleSupportWithTheGivenDurations) {
  const auto timeline = timeline_of({Stand{2}, TangentArc{}, Stand{3}});
  const auto& phases = timeline.phases();
  ASSERT_EQ(phases.size(), 2u + 2 * 9);
  EXPECT_EQ(phases.front().ticks, 400);
  for (std::size_t i = 1; i + 1 < phases.size(); i += 2) {
    EXPECT_EQ(phases[i].support, Support::both);
    EXPECT_EQ(phases[i].ticks, 4);
    EXPECT_EQ(phases[i + 1].support, (i / 2) % 2 == 0 ? Support::left : Support::right);
    EXPECT_EQ(phases[i + 1].ticks, 156);
  }
  EXPECT_EQ(phases.back().ticks, 600);
  EXPECT_EQ(timeline.ticks(), 400u + 9 * 160 + 600);
}

TEST(Timeline, ShortStandingAtBothEndsIsLengthenedToWhatThePlanNeeds) {
  const auto without = timeline_of({Straight{0.15, 0}});
  const auto with = timeline_of({Stand{0.1}, Straight{0.15, 0}, Stand{0.1}});
  EXPECT_EQ(without.ticks(), with.ticks());
  EXPECT_EQ(with.phases().front().ticks, 330);  // the preview and the smoothing window
  EXPECT_EQ(with.phases().back().ticks, 400);
  EXPECT_EQ(timeline_of({Stand{5}, Straight{0.15, 0}, Stand{5}}).ticks(), 1000u + 320 + 1000);
}

TEST(Timeline, RepeatCarriesOutTheLastCommandsAgainAndRecordsTheLaps) {
  const auto repeated = timeline_of({Stand{2}, Straight{0.3, 0}, Turn{}, Stand{1}, Repeat{3, 1}, Stand{2}});
  const auto written = timeline_of(
      {Stand{2}, Straight{0.3, 0}, Turn{}, Stand{1}, Straight{0.3, 0}, Turn{}, Stand{1}, Stand{2}});
  EXPECT_EQ(repeated.ticks(), written.ticks());
  EXPECT_EQ(written.ticks(), 400u + 2 * (3 * 160 + 10 * 160 + 200) + 400);
  ASSERT_EQ(repeated.laps().size(), 2u);
  EXPECT_EQ(repeated.laps()[0].begin, 400u);
  EXPECT_EQ(repeated.laps()[0].end, repeated.laps()[1].begin);
  EXPECT_EQ(repeated.laps()[1].end - repeated.laps()[1].begin, repeated.laps()[0].end - 400);
  EXPECT_EQ(repeated.laps()[1].end, repeated.ticks() - 400);
  EXPECT_TRUE(written.laps().empty());
}

TEST(Timeline, ImpossibleCommandsAreRefusedByName) {
  const std::vector<std::pair<std::vector<Command>, const char*>> cases{
      {{}, "walk.commands"},
      {{Stand{1}, Turn{0}}, "walk.commands[1].turn"},
      {{Stand{1}, Repeat{2, 1}}, "walk.commands[1].repeat.last: 2 commands"},
      {{Stand{1}, Repeat{1, 1}, Repeat{1, 1}}, "one of them is itself a repeat"}};
  for (const auto& [commands, named] : cases)
    EXPECT_THAT([&c = commands] { timeline_of(c); },
                testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr(named)));
}

TEST(ZmpReference, MovesLinearlyToTheFootInDoubleSupportAndEndsMidwayBetweenTheFeet) {
  const Timeline timeline = timeline_of({Stand{3}, Straight{0.15, 0}, Stand{3}});
  const int end = 600 + 320;
  // The left foot carries the robot first. A double support has 4 ticks, the last one half as many.
  const std::map<int, Eigen::Vector2d> expected{
      {600, {0, 0}},        {602, {0, .0475}},   {604, {0, .095}},
      {759, {0, .095}},     {762, {.075, 0}},    {764, {.15, -.095}},
      {end, {.15, -.0475}}, {end + 1, {.15, 0}}, {end + 100000, {.15, 0}}};
  for (const auto& [tick, zmp] : expected)
    EXPECT_LT((zmp_reference(timeline, tick) - zmp).norm(), 1e-15) << tick;
}

TEST(ZmpReference, LiesUnderTheChosenPointOfTheFoot) {
  const Timeline timeline(kRobot, walk_of({Stand{3}, Straight{0.15, 0}}), {{0, 0}, 90 * kDegree}, {0.004, 0});
  EXPECT_LT((zmp_reference(timeline, 0) - Eigen::Vector2d(0, 0.004)).norm(), 1e-15);
  EXPECT_LT((zmp_reference(timeline, 700) - Eigen::Vector2d(-0.095, 0.004)).norm(), 1e-15);
}

TEST(ZmpReference, SmoothingKeepsConstantsAndSpreadsAStepOverNineTicks) {
  const Timeline timeline = timeline_of({Stand{3}, Straight{0.15, 0}, Stand{3}});
  const auto smoothed = [&](int tick) { return smoothed_zmp(timeline, tick); };
  EXPECT_EQ(smoothed(500), zmp_reference(timeline, 500));
  for (int k = 599; k < 615; ++k) EXPECT_GE(smoothed(k + 1).y(), smoothed(k).y());
  EXPECT_EQ(smoothed(599).y(), 0);  // at 601 it starts to move; the window looks one tick ahead
  EXPECT_GT(smoothed(600).y(), 0);
  EXPECT_NEAR(smoothed(603).y() + smoothed(607).y(), 0.095, 1e-15) << "the same before and after the middle";
  EXPECT_LT(smoothed(610).y(), 0.095);
  EXPECT_NEAR(smoothed(611).y(), 0.095, 1e-15);
}

constexpr double kSingleSupport = 0.78, kStride = 0.30, kHeight = 0.07;

Eigen::Vector3d at(double t, SwingPolynomial polynomial = SwingPolynomial::quintic) {
  return swing_foot({}, {{kStride, 0}, 0}, t / kSingleSupport, kHeight, polynomial).translation();
}

TEST(SwingFoot, QuinticMatchesTheReference) {
  const double rows[][3] = {{.1, .001720697, .013991280},
                            {.2, .024882097, .040715108},
                            {.39, .15, .07},
                            {.6, .282426446, .035292882}};
  for (const auto& [t, x, z] : rows)
    EXPECT_LT((at(t) - Eigen::Vector3d(x, 0, z)).norm(), 7.1e-10) << "at " << t;  // nine decimals each
  double along = 0, up = 0;
  constexpr double h = 1e-4;
  for (double t = 0; t < kSingleSupport - h; t += h) {
    const Eigen::Vector3d velocity = (at(t + h) - at(t)) / h;
    along = std::max(along, velocity.x());
    up = std::max(up, velocity.z());
  }
  EXPECT_NEAR(along, .801, 5e-4);  // three decimals
  EXPECT_NEAR(up, .276, 5e-4);
}

TEST(SwingFoot, LeavesAndMeetsTheGroundVertically) {
  for (const auto polynomial : {SwingPolynomial::quintic, SwingPolynomial::cubic}) {
    EXPECT_EQ(at(0.04 * kSingleSupport, polynomial).x(), 0);
    EXPECT_NEAR(at(0.96 * kSingleSupport, polynomial).x(), kStride, 1e-15);
    EXPECT_EQ(at(0, polynomial).z(), 0);
    EXPECT_EQ(at(kSingleSupport, polynomial).z(), 0);
  }
  const double s = (.2 / kSingleSupport - .05) / .9;
  EXPECT_NEAR(at(.2, SwingPolynomial::cubic).x(), kStride * (3 * s * s - 2 * s * s * s), 1e-15);
}

TEST(SwingFoot, GoesExactlyFromPlaceToPlaceAndTurnsOnlyAboutTheVertical) {
  const FootPose from{{0.3, -0.2}, 0.4}, to{{0.55, -0.13}, 0.9};
  const auto X = [&](double s) { return swing_foot(from, to, s, kHeight, SwingPolynomial::quintic); };
  EXPECT_TRUE(X(0).isApprox(sole(from), 1e-15));
  EXPECT_TRUE(X(1).isApprox(sole(to), 1e-15));
  EXPECT_NEAR(yaw_of(X(0.5)), 0.65, 1e-15);
  EXPECT_EQ(X(0.5).linear().col(2), Eigen::Vector3d::UnitZ());
}

TEST(WaistYaw, IsACubicWhoseRateIsItsDerivative) {
  Phase phase;
  phase.ticks = 156;
  phase.waist_yaw_from = 0.5;
  phase.waist_yaw_to = 0.7;
  for (const auto& [s, yaw] : {std::pair(0.0, 0.5), {0.5, 0.6}, {1.0, 0.7}})
    EXPECT_NEAR(waist_yaw(phase, s).yaw, yaw, 1e-15);
  EXPECT_EQ(waist_yaw(phase, 0).rate, 0);
  EXPECT_EQ(waist_yaw(phase, 1).rate, 0);
  constexpr double h = 1e-5;
  for (const double s : {0.1, 0.4, 0.8}) {
    const double change = waist_yaw(phase, s + h).yaw - waist_yaw(phase, s - h).yaw;
    EXPECT_NEAR(waist_yaw(phase, s).rate, change / (2 * h * kSingleSupport), 1e-9);  // h² and eps / h
  }
}

TEST(ArmSwing, HandMovesOppositeToTheFootAtItsHeight) {
  for (const double foot : {-0.3, -0.1, 0.0, 0.05, 0.15, 0.4}) {
    const ArmAngles arm = arm_swing(kRobot, Side::right, foot);
    // Shoulder and elbow rotate about y; a positive pitch moves the hand back.
    const double x = -0.25 * std::sin(arm.shoulder_pitch) - 0.25 * std::sin(arm.shoulder_pitch + arm.elbow);
    const double z = -0.25 * std::cos(arm.shoulder_pitch) - 0.25 * std::cos(arm.shoulder_pitch + arm.elbow);
    EXPECT_NEAR(x, -0.2267747 * foot, 1e-7);
    EXPECT_NEAR(z, -0.4829629, 1e-7);
  }
}

JointVector swinging(Reference reference) {
  reference.arms = arm_swing(kRobot, reference);
  return inverse_kinematics(kRobot, reference, kRobot.posture).q;
}

TEST(ArmSwing, EachArmFollowsTheFootOnItsSideByTheReferenceAngles) {
  EXPECT_LT((swinging(standing()) - kRobot.posture).cwiseAbs().maxCoeff(), 1e-12);
  Reference stride = standing();
  stride.X_PL.translation().x() += 0.15;
  stride.X_PR.translation().x() -= 0.15;
  const Eigen::Isometry3d X(Eigen::Translation3d(3, 1, 0) * Eigen::AngleAxisd(2, Eigen::Vector3d::UnitZ()));
  for (auto* pose : {&stride.X_PB, &stride.X_PL, &stride.X_PR}) *pose = X * *pose;
  const JointVector swung = swinging(stride);
  JointVector difference = swung - inverse_kinematics(kRobot, stride, kRobot.posture).q;
  for (const auto& [joint, degrees] :  // left and right shoulder, elbows
       {std::pair(23, 18.48963), {16, 10.43198}, {26, -28.92161}, {19, -28.92161}}) {
    EXPECT_NEAR(swung(joint) / kDegree, degrees, 5e-6);  // five decimals
    difference(joint) = 0;
  }
  EXPECT_TRUE(difference.isZero(0));
}

}  // namespace
}  // namespace walking
