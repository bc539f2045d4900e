#include "walking/preview_control.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <vector>

#include "walking/timeline.h"

namespace walking {
namespace {

constexpr int kHorizon = 320;
constexpr double kGainTolerance = 1e-7;  // relative: the tables come from 60-digit arithmetic, ours is double

void expect_gain(double expected, double actual) {
  EXPECT_NEAR(actual / expected, 1, kGainTolerance) << "expected " << expected;
}

void expect_gains(const PreviewGains& gains, double integral, const std::array<double, 3>& state,
                  const std::map<int, double>& preview) {
  expect_gain(integral, gains.integral);
  for (int i = 0; i < 3; ++i) expect_gain(state[i], gains.state(i));
  for (const auto& [j, gain] : preview) expect_gain(gain, gains.preview(j - 1));
}

TEST(PreviewGains, EqualThePublishedOnes) {
  const PreviewGains gains = preview_gains(CartTable(0.814), kHorizon);
  expect_gains(gains, 618.7016237839, {72719.43894273, 21549.59769818, 177.0126567286},
               {{1, -618.7016237839},
                {2, -777.5073305104},
                {3, -952.2612920583},
                {4, -1082.276766762},
                {5, -1155.280351617},
                {6, -1181.389369841},
                {7, -1176.950982394},
                {8, -1156.510380857},
                {9, -1130.098317282},
                {10, -1103.335177657},
                {11, -1078.624109661},
                {12, -1056.464148017},
                {16, -983.5108596205},
                {32, -745.5674954037},
                {64, -427.8159061026},
                {100, -229.0197332170},
                {160, -80.82880341891},
                {240, -20.15999313400},
                {320, -5.028222646254}});
  expect_gain(-72432.26696154, gains.preview.sum());
}

TEST(PreviewGains, EqualTheReferenceForOtherGravity) {
  expect_gains(preview_gains(CartTable(0.814, kPeriod, 9.80665), kHorizon), 618.6529933447,
               {72725.67854945, 21554.96027898, 177.0380718019},
               {{2, -777.4879795515}, {3, -952.2540476652}, {320, -5.032525790271}});
  expect_gains(preview_gains(CartTable(0.814, kPeriod, 9.8), kHorizon), 618.5563919223,
               {72738.06965262, 21565.61408301, 177.0885579197},
               {{2, -777.4495311093}, {3, -952.2396158629}, {320, -5.041080549300}});
}

TEST(PreviewGains, EqualTheReferenceForOtherHeights) {
  expect_gains(preview_gains(CartTable(0.8078), kHorizon), 619.7887522921,
               {72579.64543216, 21429.83782496, 176.4445598795},
               {{2, -777.9391363337}, {3, -952.4196134829}, {320, -4.932626371083}});
  expect_gains(preview_gains(CartTable(0.8083), kHorizon), 619.7008795556,
               {72590.96683925, 21439.50947942, 176.4904753123},
               {{2, -777.9042888827}, {3, -952.4070739543}, {320, -4.940310786556}});
}

TEST(PreviewGains, FirstPreviewGainCancelsTheIntegralOne) {
  for (const double height : {0.6, 0.814, 1.1}) {
    const PreviewGains gains = preview_gains(CartTable(height), 10);
    EXPECT_EQ(gains.preview(0), -gains.integral);
  }
}

/// The reference far ahead and the present state have the same weight: standing still anywhere needs no
/// jerk.
TEST(PreviewGains, LongPreviewSumsToThePositionGain) {
  for (const double height : {0.6, 0.814, 1.1}) {
    const PreviewGains gains = preview_gains(CartTable(height), 3000);
    EXPECT_NEAR(gains.preview.sum() / -gains.state(0), 1, 1e-9);  // the Riccati iteration's own accuracy
  }
}

/// A reference of both axes, before its first and after its last value constant; tick by tick through preview
/// control.
struct Walked {
  std::vector<PreviewControl::State> states;
  std::vector<Eigen::Vector2d> zmp;
  double largest_error_x = 0, largest_error_y = 0;
};

Walked walk(const std::vector<Eigen::Vector2d>& reference, int horizon = kHorizon) {
  const CartTable cart(0.814);
  PreviewControl control(cart, preview_gains(cart, horizon), reference.front());
  Walked walked;
  const auto at = [&](std::size_t k) { return reference[std::min(k, reference.size() - 1)]; };
  PreviewWindow window(horizon);
  for (std::size_t k = 0; k < reference.size(); ++k) {
    for (std::size_t ahead = k == 0 ? 0 : horizon; !window.full(); ++ahead) window.push(at(k + ahead));
    walked.states.push_back(control.state());
    walked.zmp.push_back(control.zmp());
    const Eigen::Vector2d error = (control.zmp() - reference[k]).cwiseAbs();
    walked.largest_error_x = std::max(walked.largest_error_x, error.x());
    walked.largest_error_y = std::max(walked.largest_error_y, error.y());
    control.advance(window);
    window.pop();
  }
  return walked;
}

std::vector<Eigen::Vector2d> step_reference() {
  std::vector<Eigen::Vector2d> reference(801, Eigen::Vector2d(0.3, 0));
  std::fill_n(reference.begin(), 400, Eigen::Vector2d::Zero());
  return reference;
}

TEST(PreviewControl, StepResponseIsTheReferenceOne) {
  const Walked walked = walk(step_reference());
  constexpr double kPrinted = 1e-9;  // ten decimals printed, gains good to 1e-11
  const std::map<int, std::array<double, 4>> expected{
      {80, {0, 0, 0, 0}},
      {200, {0.0043044788, 0.0171560957, 0.0556200813, -0.0003106839}},
      {300, {0.0265524646, 0.0928990999, 0.3206592101, -0.0000547318}},
      {390, {0.1271633763, 0.4416202440, 1.5415064958, -0.0007455216}},
      {399, {0.1486938167, 0.5104148572, 0.4157568955, 0.1141957420}},
      {400, {0.1512476213, 0.5104136795, -0.4162279716, 0.1857847843}},
      {410, {0.1749663945, 0.4339772984, -1.5062267100, 0.2999478972}},
      {500, {0.2737824809, 0.0910133371, -0.3159421171, 0.2999982693}},
      {800, {0.2998564080, 0.0004984757, -0.0017304011, 0.2999999907}}};
  for (const auto& [k, values] : expected) {
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(walked.states[k](i, 0), values[i], kPrinted) << "at " << k;
    EXPECT_NEAR(walked.zmp[k].x(), values[3], kPrinted) << "at " << k;
  }
  EXPECT_NE(walked.states[81](0, 0), 0);
  EXPECT_NEAR(walked.largest_error_x, 0.1142152, 1e-7);
}

double largest_zmp(const Walked& walked) {
  return std::max_element(walked.zmp.begin(), walked.zmp.end(),
                          [](auto& a, auto& b) { return a.x() < b.x(); })
      ->x();
}
double smallest_zmp(const Walked& walked) {
  return std::min_element(walked.zmp.begin(), walked.zmp.end(),
                          [](auto& a, auto& b) { return a.x() < b.x(); })
      ->x();
}

TEST(PreviewControl, HalfThePreviewUndershootsMore) {
  const Walked full = walk(step_reference()), half = walk(step_reference(), 160);
  EXPECT_NEAR(largest_zmp(full), 0.3094852, 1e-7);
  EXPECT_NEAR(smallest_zmp(full), -0.0095048, 1e-7);
  EXPECT_NEAR(largest_zmp(half), 0.307207, 1e-6);
  EXPECT_NEAR(smallest_zmp(half), -0.037704, 1e-6);
}

/// Four steps of 0.15 m: 640 ticks of standing, per step 4 ticks of ramp and 156 of single support, then 960
/// of standing.
std::vector<Eigen::Vector2d> short_walk() {
  std::vector<Eigen::Vector2d> p(640, Eigen::Vector2d::Zero());
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& to : {Eigen::Vector2d(0, .095), Eigen::Vector2d(.15, -.095),
                                    Eigen::Vector2d(.30, .095), Eigen::Vector2d(.30, -.095)}) {
    for (int k = 0; k < 4; ++k) p.push_back(from + k / 4.0 * (to - from));
    p.insert(p.end(), 156, to);
    from = to;
  }
  const Eigen::Vector2d end(.30, 0);
  for (int k = 0; k < 2; ++k) p.push_back(from + (k + 1) / 2.0 * (end - from));
  p.insert(p.end(), 960, end);
  return p;
}

std::vector<Eigen::Vector2d> causally_smoothed(const std::vector<Eigen::Vector2d>& p) {
  const auto w = smoothing_weights();
  std::vector<Eigen::Vector2d> y;
  for (int i = 0; i < static_cast<int>(p.size()); ++i) {
    y.emplace_back(0, 0);
    for (int j = 0; j <= kSmoothingTicks; ++j) {
      y.back() += w[j] * p[std::max(i - j, 0)];
    }
  }
  return y;
}

struct ShortWalkRow {
  int k;
  double y, y_rate, zmp_y, x;
};

void expect_rows(const Walked& walked, const std::vector<ShortWalkRow>& rows) {
  constexpr double kPrinted = 1.5e-9;  // nine decimals
  for (const ShortWalkRow& row : rows) {
    EXPECT_NEAR(walked.states[row.k](0, 1), row.y, kPrinted) << "at " << row.k;
    EXPECT_NEAR(walked.states[row.k](1, 1), row.y_rate, kPrinted) << "at " << row.k;
    EXPECT_NEAR(walked.zmp[row.k].y(), row.zmp_y, kPrinted) << "at " << row.k;
    EXPECT_NEAR(walked.states[row.k](0, 0), row.x, kPrinted) << "at " << row.k;
  }
}

TEST(PreviewControl, ShortWalkIsTheReferenceOne) {
  const Walked walked = walk(short_walk());
  expect_rows(walked, {{640, .040342117, .138859878, .014913159, .004377587},
                       {720, .060947820, -.031502770, .094613215, .018854751},
                       {800, .005710064, -.287307041, .065276122, .076830841},
                       {960, -.002839727, .277342750, -.065275933, .217620477},
                       {1200, -.060073290, -.039008318, -.095010819, .298719580}});
  EXPECT_NEAR(walked.largest_error_y, 0.0302, 5e-5);
  EXPECT_NEAR(walked.largest_error_x, 0.0235, 5e-5);
}

TEST(PreviewControl, SmoothedShortWalkIsTheReferenceOneAndTracksBetter) {
  const Walked walked = walk(causally_smoothed(short_walk()));
  expect_rows(walked, {{640, .037022530, .127759855, -.001186307, .003996973},
                       {720, .061593336, -.021481945, .094577943, .017253093},
                       {800, .012552206, -.262517958, .097484399, .070447546},
                       {960, -.009420093, .251644920, -.097484192, .211177044},
                       {1200, -.058947464, -.049719740, -.095011808, .298602805}});
  EXPECT_NEAR(walked.largest_error_y, 0.00865, 5e-6);
  EXPECT_NEAR(walked.largest_error_x, 0.00647, 5e-6);
}

}  // namespace
}  // namespace walking
