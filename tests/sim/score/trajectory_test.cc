// Pairing, alignment, spans, statistics and consistency.
#include "sim/score/trajectory.h"

#include "tests/sim/score/score_fixtures.h"

namespace sim::score {
namespace {

using Numbers = std::vector<double>;
using std::numbers::pi, testing::HasSubstr, testing::DoubleEq, testing::ElementsAre;

const Eigen::Matrix3d kTurn =
    Eigen::AngleAxisd(0.9, Eigen::Vector3d(0.3, -0.5, 0.8).normalized()).toRotationMatrix();

TimedPose at(std::int64_t t_ns, double x) { return {Stamp(t_ns), upright(x, 0, 0)}; }

TEST(Trajectory, StampsOfOneMomentArePairedEvenIfRounded) {
  const Trajectory truth{at(1'000'000, 1), at(2'000'000, 2), at(4'000'000, 4)};
  const auto pairs = pair_by_stamp(
      truth, {at(0, 0), at(2'000'001, 2.5), at(2'010'000, 9), at(3'000'000, 3), at(3'900'000, 5)});
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[0].t, Stamp(2'000'001));
  EXPECT_EQ(pairs[0].X_true.translation().x(), 2);
  EXPECT_EQ(pairs[0].X_estimate.translation().x(), 2.5);
  EXPECT_EQ(pairs[1].X_true.translation().x(), 4);
  EXPECT_TRUE(pair_by_stamp(truth, {}).empty());
  EXPECT_TRUE(pair_by_stamp({}, truth).empty());
}

TEST(Trajectory, InterpolatesPositionLinearlyAndOrientationAlongTheShortestTurn) {
  const Trajectory trajectory{{Stamp(0), upright(0, 0, 0, 3.0)}, {Stamp(100), upright(1, 2, 4, -3.0)}};
  const auto X = interpolate(trajectory, Stamp(25));
  ASSERT_TRUE(X);
  EXPECT_TRUE(X->translation().isApprox(Eigen::Vector3d(0.25, 0.5, 1), 1e-15));
  EXPECT_NEAR(yaw(X->linear()), 3.0 + 0.25 * (2 * pi - 6), 1e-12);  // through pi, not through 0
  EXPECT_TRUE(interpolate(trajectory, Stamp(0))->isApprox(trajectory[0].X, 0));
  EXPECT_TRUE(interpolate(trajectory, Stamp(100))->isApprox(trajectory[1].X, 0));
  for (const int outside : {-1, 101}) EXPECT_FALSE(interpolate(trajectory, Stamp(outside)));
  EXPECT_FALSE(interpolate({}, Stamp(0)));
}

TEST(Trajectory, PairsByInterpolationWithinTheTruthsTimeButNotAcrossLongGaps) {
  const Trajectory truth{at(10, 1), at(20, 2), at(60, 6)},
      estimate{at(5, 7), at(15, 7), at(40, 7), at(60, 7), at(65, 7)};
  const auto pairs = pair_by_interpolation(truth, estimate, Stamp(10));
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[0].X_true.translation().x(), 1.5);
  EXPECT_EQ(pairs[1].t, Stamp(60)) << "a true pose needs no interpolation";
  EXPECT_EQ(pair_by_interpolation(truth, estimate, Stamp(40)).size(), 3u);
}

TEST(Trajectory, PairsByNearestUseEachPoseOnceWithTheNearestOfSeveral) {
  const Trajectory many{at(0, 0), at(100, 1), at(200, 2), at(300, 3)}, few{at(95, 7), at(101, 8), at(109, 9)};
  const auto pairs = pair_by_nearest(many, few, Stamp(10)), swapped = pair_by_nearest(few, many, Stamp(10));
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_EQ(pairs[0].X_true.translation().x(), 1);
  EXPECT_EQ(pairs[0].X_estimate.translation().x(), 8);
  ASSERT_EQ(swapped.size(), 1u);
  EXPECT_EQ(swapped[0].X_true.translation().x(), 8);
}

TEST(Trajectory, RotationVectorIsAngleTimesAxis) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, -2, 3).normalized();
  for (const double angle : {0.0, 1e-9, 1e-3, 1.0, 3.0, 3.14159})
    EXPECT_LT((rotation_vector(Eigen::AngleAxisd(angle, axis).toRotationMatrix()) - angle * axis).norm(),
              1e-13)  // rounding of R's entries
        << angle;
  EXPECT_NEAR(rotation_vector(about_z(-pi)).norm(), pi, 1e-12);
}

TEST(Trajectory, YawIsTheNearestRotationAboutTheVertical) {
  for (const double angle : {2.5, -2.5}) EXPECT_NEAR(yaw(about_z(angle)), angle, 1e-15);
  // Checked by brute force, for a rotation that is not about z.
  double best = 0, least = 1e9;
  for (double angle = -pi; angle < pi; angle += 1e-4)
    if (const double distance = (kTurn - about_z(angle)).norm(); distance < least)
      least = distance, best = angle;
  EXPECT_NEAR(yaw(kTurn), best, 1e-4);
}

TEST(Errors, YawIsAboutTheWorldsVerticalAndDriftIsInTheAxesOfTheStart) {
  const Eigen::Isometry3d estimate = looking(0.4);
  EXPECT_NEAR(yaw_error({Stamp(0), looking(0.3), estimate}), -0.1, 1e-15);
  Eigen::Isometry3d pitched = looking(0);
  pitched.linear() = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY()).toRotationMatrix() * pitched.linear();
  EXPECT_NEAR(yaw_error({Stamp(0), pitched, looking(0)}), 0, 1e-15);
  const auto expect_drift = [](double start_yaw, double x, double y) {
    const Eigen::Vector3d found =
        drift(upright(1.1, 0.2, 0.6, 0.3), upright(1, 0.5, 0.7, 0.1), upright(0, 0, 0.7, start_yaw));
    EXPECT_LT((found - Eigen::Vector3d(x, y, 0.2)).cwiseAbs().maxCoeff(), 1e-15);
  };
  expect_drift(0, 0.1, -0.3);
  expect_drift(pi / 2, -0.3, -0.1);  // facing y of W at the start: W (0.1, -0.3) is (-0.3, -0.1)
  EXPECT_NEAR(drift(upright(0, 0, 0, -3.1), upright(0, 0, 0, 3.1), upright(0, 0, 0)).z(), 2 * pi - 6.2,
              1e-14);  // the short way
}

Similarity aligned(const std::vector<PosePair>& pairs, Alignment alignment) {
  return std::get<Similarity>(align(pairs, alignment));
}

std::string reason(const std::vector<PosePair>& pairs, Alignment alignment) {
  return std::get<Absent>(align(pairs, alignment)).reason;
}

double ate(const std::vector<PosePair>& pairs, Alignment alignment) {
  return root_mean_square(position_errors(transformed(aligned(pairs, alignment), pairs)));
}

// Other trajectories are checked against tests/tools/score_oracle.py.
TEST(Alignment, AMirrorImageIsNotATurn) {
  std::vector<PosePair> mirrored = curve_pairs();
  for (PosePair& pair : mirrored) pair.X_estimate.translation().x() *= -1;
  EXPECT_NEAR(aligned(mirrored, Alignment::se3).R.determinant(), 1, 1e-12);
  EXPECT_GT(ate(mirrored, Alignment::se3), 0.1);
}

TEST(Alignment, DegenerateCasesGiveAReason) {
  std::vector<PosePair> point(10), line = point, vertical = point;
  for (int i = 0; i < 10; ++i) {
    const auto place = [i](std::vector<PosePair>& pairs, const Eigen::Vector3d& p) {
      PosePair& pair = pairs[std::size_t(i)];
      pair.X_true.translation() = pair.X_estimate.translation() = p;
    };
    place(point, {1, 2, 3});
    place(line, {1.0 * i, 2.0 * i, 0.5 * i});
    place(vertical, {1, 2, 1.0 * i});
  }
  using enum Alignment;
  for (const Alignment a : {none, origin, yaw_position, se3, sim3})
    EXPECT_THAT(reason({}, a), HasSubstr("no pose"));
  for (const Alignment a : {se3, sim3}) {
    EXPECT_THAT(reason(point, a), HasSubstr("coincide"));
    EXPECT_THAT(reason(line, a), HasSubstr("one line"));
  }
  EXPECT_THAT(reason({line[3]}, se3), HasSubstr("coincide"));
  for (const auto& pairs : {point, vertical})
    EXPECT_THAT(reason(pairs, yaw_position), HasSubstr("have no horizontal spread"));
  EXPECT_NEAR(ate(line, yaw_position), 0, 1e-12);  // a line is enough for a turn about z
  EXPECT_NEAR(ate({line[3]}, origin), 0, 1e-12);
}

// Other spans are checked against tests/tools/score_oracle.py.
TEST(Relative, AStationaryTrajectoryHasNoSpansOfItsPath) {
  std::vector<PosePair> standing(50);
  for (std::size_t i = 0; i < standing.size(); ++i) standing[i].t = std::chrono::milliseconds(100 * i);
  for (const bool all : {false, true}) EXPECT_TRUE(spans(standing, {Spans::Unit::meters, 0.25, all}).empty());
  EXPECT_EQ(spans(standing, {Spans::Unit::seconds, 1}).size(), 4u);
  EXPECT_TRUE(spans({}, {}).empty());
}

// All numbers are exact in binary: a span may have exactly the requested length, or differ by exactly the
// tolerance.
TEST(Relative, SpansIncludeTheirLengthAndTheirTolerance) {
  using enum Spans::Unit;
  using Ends = std::vector<std::pair<std::size_t, std::size_t>>;
  const auto ends = [](const std::vector<double>& places, const Spans& which) {
    std::vector<PosePair> pairs;
    for (const double place : places) {
      pairs.emplace_back().t = std::chrono::nanoseconds(std::llround(1e9 * place));
      pairs.back().X_true.translation().x() = pairs.back().X_estimate.translation().x() = place;
    }
    Ends found;
    for (const Span& span : spans(pairs, which)) found.emplace_back(span.from, span.to);
    return found;
  };
  const std::vector<double> whole{0, 1, 2, 3, 4};
  for (const Spans::Unit unit : {frames, seconds, meters}) {
    EXPECT_EQ(ends(whole, {unit, 2, true, 0}), (Ends{{0, 2}, {1, 3}, {2, 4}}));
    EXPECT_EQ(ends(whole, {unit, 2}), (unit == meters ? Ends{{2, 4}} : Ends{{0, 2}, {2, 4}}));
  }
  EXPECT_EQ(ends({0, 1.75}, {meters, 2, true, 0.125}), (Ends{{0, 1}}));
  EXPECT_EQ(ends({0, 2.25}, {meters, 2, true, 0.125}), (Ends{{0, 1}}));
  EXPECT_EQ(ends({0, 1.5}, {meters, 2, true, 0.125}), Ends{});
  EXPECT_EQ(ends({0, 1.75, 2.25}, {meters, 2, true, 0.125}), (Ends{{0, 1}})) << "the earlier of two";
}

TEST(Statistics, AQuantileIsLinearBetweenOrderStatisticsFromTheSmallestToTheLargest) {
  EXPECT_EQ(quantile({5, 1, 4, 2, 3}, 0.25), 2);
  EXPECT_EQ(quantile({5, 1, 4, 2, 3}, 0.375), 2.5);
  EXPECT_EQ(quantile({5, 1, 4, 2, 3}, 0), 1);
  EXPECT_EQ(quantile({5, 1, 4, 2, 3}, 1), 5);
  EXPECT_EQ(quantile({20, 10}, 0.75), 17.5);
  EXPECT_EQ(quantile({7}, 0.9), 7);
}

TEST(Statistics, TheLossOfAMetricWithAnExpectedValueIsTheSameAboveAndBelow) {
  const Direction three = Direction::away_from(3);
  EXPECT_EQ(loss(3, three), 0);
  for (const double off : {9.0, 1.0}) EXPECT_NEAR(loss(off, three), std::log(3), 1e-15);
  for (const double none : {0.0, -1.0, 5e-324}) {
    EXPECT_TRUE(std::isfinite(loss(none, three)));
    EXPECT_GT(loss(none, three), loss(1e-300, three));
  }
}

TEST(Significance, WilcoxonMatchesPublishedSamplesAndAllSignPatterns) {
  // Darwin's maize, cross- minus self-fertilized heights; statistic 24, exact p = 1352 / 2^15.
  const Numbers maize{6, 8, 14, 16, 23, 24, 28, 29, 41, -48, 49, 56, 60, -67, 75};
  EXPECT_EQ(wilcoxon_signed_rank(maize), 0.041259765625);
  EXPECT_EQ(wilcoxon_signed_rank({-1, -2, -3, -4, -5, -6, -7, -8}), 2 / 256.0);
  EXPECT_EQ(wilcoxon_signed_rank({0.1, 0.1, 0.1, 0.1, 0.1}), 2 / 32.0);  // here ties do not matter
  for (const Numbers& none : {Numbers{}, {0, 0, 0}, {1, -1, 2, -2}}) EXPECT_EQ(wilcoxon_signed_rank(none), 1);
  // Ties and zeros, counted over all patterns of signs by another program.
  EXPECT_DOUBLE_EQ(wilcoxon_signed_rank({1, 1, -1, 2, 3, 3, -3, 0, 5}), 2 * 28 / 256.0);
  EXPECT_DOUBLE_EQ(wilcoxon_signed_rank({0.5, -0.5, -0.5, 2, 2, 2}), 2 * 7 / 64.0);
  EXPECT_DOUBLE_EQ(wilcoxon_signed_rank({1, 2, 2, 2, -9, 9, 9, 4, 4, -4}), 2 * 118 / 1024.0);
  EXPECT_DOUBLE_EQ(wilcoxon_signed_rank({-7, 1}), 1);
}

TEST(Significance, ExactAndApproximateWilcoxonAgree) {
  const auto p = [](int n) {
    Numbers values;
    for (int i = 1; i <= n; ++i) values.push_back(i % 3 == 0 ? -i : i);
    return wilcoxon_signed_rank(values);
  };
  // Computed by hand: of 60, ranks to 1200 are positive, 915 expected with variance 60·61·121/24; of 50: 867,
  // 637.5, 10731.25. The tail of 50 ranks is nearly normal.
  EXPECT_NEAR(p(60), std::erfc(284.5 / std::sqrt(2 * 18452.5)), 1e-15);
  const double by_approximation = std::erfc(229 / std::sqrt(2 * 10731.25));
  EXPECT_NEAR(p(50) / by_approximation, 1, 0.05);
  EXPECT_NE(p(50), by_approximation);
}

TEST(Significance, HodgesAndLehmannsIntervalEndsWhereTheSignedRankTestRejects) {
  // Darwin's maize (Hollander & Wolfe 1999): the median of 120 Walsh averages; 1 - 2 P(W <= 25) = 95.2 %.
  const Shift maize = hodges_lehmann({6, 8, 14, 16, 23, 24, 28, 29, 41, -48, 49, 56, 60, -67, 75});
  EXPECT_DOUBLE_EQ(maize.estimate, 25);
  EXPECT_NEAR(maize.coverage, 1 - 2 * 785 / 32768.0, 1e-15);
  EXPECT_FALSE(hodges_lehmann({1, 2, 3, 4, 5}).interval);  // 2/32 > 5 %
  EXPECT_EQ(hodges_lehmann({6, 5, 4, 3, 2, 1}).interval, std::pair(1.0, 6.0));
  for (const int n : {6, 8, 12, 16}) {
    Numbers values;
    for (int i = 0; i < n; ++i) values.push_back(std::sin(7.0 * i));  // no two averages are equal
    const Shift shift = hodges_lehmann(values);
    for (const auto& [end, inside] :
         {std::pair(shift.interval->first, 1e-9), {shift.interval->second, -1e-9}})
      for (const double off : {inside, -inside}) {
        Numbers shifted = values;
        for (double& value : shifted) value -= end + off;
        EXPECT_EQ(wilcoxon_signed_rank(shifted) > 1 - shift.coverage + 1e-12, off == inside) << n;
      }
  }
}

TEST(Significance, HolmAdjustsInOrderOfSizeAndNeverDecreases) {
  EXPECT_THAT(holm({0.01, 0.04, 0.03, 0.005}),
              ElementsAre(DoubleEq(0.03), DoubleEq(0.06), DoubleEq(0.06), DoubleEq(0.02)));
  EXPECT_THAT(holm({0.9, 0.8}), ElementsAre(1, 1));
  EXPECT_TRUE(holm({}).empty());
}

TEST(Significance, TheMediansIntervalConsistsOfOrderStatistics) {
  EXPECT_FALSE(median_interval({1, 2, 3, 4, 5}));  // 2/32 > 5 %
  EXPECT_EQ(median_interval({6, 5, 4, 3, 2, 1}), std::pair(1.0, 6.0));
  // Tables of the sign test: n = 10 leaves out one on each side (97.9 %), n = 20 five (95.9 %).
  Numbers values;
  for (int i = 1; i <= 10; ++i) values.push_back(i);
  EXPECT_EQ(median_interval(values), std::pair(2.0, 9.0));
  for (int i = 11; i <= 20; ++i) values.push_back(i);
  EXPECT_EQ(median_interval(values), std::pair(6.0, 15.0));
}

TEST(Consistency, ChiSquareQuantilesMatchTheTables) {
  EXPECT_NEAR(chi_square_quantile(0.95, 1), 3.841458820694124, 1e-11);
  EXPECT_NEAR(chi_square_quantile(0.975, 30), 46.979242243671145, 1e-10);
  const Band ten = mean_band(3, 10), many = mean_band(3, 1000);
  EXPECT_NEAR(ten.low, 1.68, 0.005);
  EXPECT_NEAR(ten.high, 4.70, 0.005);
  EXPECT_GT(many.low, 2.8);
  EXPECT_LT(many.high, 3.2);
}

// The bands of ten and of two runs: [1.679, 4.698] (from the table) and [0.619, 7.225].
TEST(Consistency, TheFractionInTheBandCountsInstantsByTheMeanOverRuns) {
  const std::vector<double> low(10, 1.6), inside(10, 1.7), high(10, 4.7);
  const auto fraction = band_fractions({low, inside, inside, high, {}, {0.6, 0.6}, {1, 13}}, 3);
  ASSERT_TRUE(fraction);
  EXPECT_DOUBLE_EQ(fraction->inside, 3.0 / 6);  // 1.7 twice, and 7 as the mean of two
  EXPECT_DOUBLE_EQ(fraction->below, 2.0 / 6);   // 1.6, and 0.6 as the mean of two
  EXPECT_NEAR(fraction->mean, (1.6 + 2 * 1.7 + 4.7 + 0.6 + 7) / 6, 1e-12);
  EXPECT_FALSE(band_fractions({{}, {}}, 3));
}

}  // namespace
}  // namespace sim::score
