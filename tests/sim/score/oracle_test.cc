// Every alignment and every kind of span against numbers computed by another program (oracle.py) by other
// means.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "sim/score/alignment.h"
#include "sim/score/errors.h"
#include "sim/score/relative.h"
#include "sim/score/statistics.h"

namespace sim::score {
namespace {

const std::map<std::string, double> kOracle{
#include "tests/sim/score/oracle.inc"
};

// Agreement asked for: rounding of a few hundred operations on numbers of size 1, and Horn's iteration to
// 1e-15.
constexpr double kTolerance = 1e-9;

Eigen::Isometry3d pose(const Eigen::Vector3d& turn, const Eigen::Vector3d& p) {
  Eigen::Isometry3d X(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
  X.translation() = p;
  return X;
}

// The trajectories of oracle.py, by its formulas.
std::vector<PosePair> pairs() {
  std::vector<PosePair> all;
  const Eigen::Matrix3d G = pose({0.3, -0.2, 0.5}, Eigen::Vector3d::Zero()).linear();
  for (int i = 0; i < 60; ++i) {
    const double s = 0.1 * i;
    PosePair pair;
    pair.t = Stamp(33'333'334ll * i);
    pair.X_true = pose({0.1 * std::sin(s), 0.2 * std::cos(2 * s), s + 0.05},
                       {std::cos(s), std::sin(s), 0.3 * std::sin(2 * s)});
    const Eigen::Vector3d turn =
        0.02 * Eigen::Vector3d(std::sin(1.3 * i + 1), std::cos(0.7 * i), std::sin(2.1 * i + 3));
    const Eigen::Vector3d shift =
        0.05 * Eigen::Vector3d(std::sin(1.7 * i), std::cos(2.3 * i), std::sin(0.9 * i + 2));
    pair.X_estimate.linear() = G * pair.X_true.linear() * pose(turn, Eigen::Vector3d::Zero()).linear();
    pair.X_estimate.translation() = 1.1 * G * (pair.X_true.translation() + shift) + Eigen::Vector3d(1, 2, 3);
    all.push_back(pair);
  }
  return all;
}

void expect(const std::string& name, double value) {
  EXPECT_NEAR(value, kOracle.at(name), kTolerance) << name;
}

TEST(Oracle, AgreesOnAbsoluteErrorsUnderEveryAlignment) {
  const std::map<std::string, Alignment> alignments{
      {"none", Alignment::none}, {"origin", Alignment::origin}, {"yaw_position", Alignment::yaw_position},
      {"se3", Alignment::se3},   {"sim3", Alignment::sim3},     {"scale", Alignment::scale}};
  for (const auto& [name, alignment] : alignments) {
    const auto S = std::get<Similarity>(align(pairs(), alignment));
    const std::vector<PosePair> aligned = transformed(S, pairs());
    const ErrorStatistics statistics = describe(position_errors(aligned));
    expect(name + ".rmse", statistics.rmse);
    expect(name + ".mean", statistics.mean);
    expect(name + ".median", statistics.median);
    expect(name + ".std", statistics.std);
    expect(name + ".min", statistics.min);
    expect(name + ".max", statistics.max);
    expect(name + ".rotation_rmse", root_mean_square(orientation_errors(aligned)));
    expect(name + ".scale", S.scale);
  }
}

TEST(Oracle, AgreesOnRelativeErrorsOverEveryKindOfSpan) {
  using Unit = Spans::Unit;
  const std::map<std::string, Spans> kinds{{"frames_5", {Unit::frames, 5}},
                                           {"frames_7_all", {Unit::frames, 7, true}},
                                           {"metres_0.5", {Unit::metres, 0.5}},
                                           {"metres_0.5_all", {Unit::metres, 0.5, true}},
                                           {"seconds_0.2", {Unit::seconds, 0.2}}};
  for (const auto& [name, which] : kinds) {
    std::vector<double> translations, rotations;
    for (const RelativeError& error : relative_errors(pairs(), spans(pairs(), which))) {
      translations.push_back(error.translation);
      rotations.push_back(error.rotation);
    }
    expect(name + ".n", static_cast<double>(translations.size()));
    expect(name + ".translation_rmse", root_mean_square(translations));
    expect(name + ".rotation_rmse", root_mean_square(rotations));
  }
}

TEST(Oracle, AgreesOnThePathLength) {
  Trajectory estimate;
  for (const PosePair& pair : pairs()) estimate.push_back({pair.t, pair.X_estimate});
  expect("path_length", path_length(estimate));
}

}  // namespace
}  // namespace sim::score
