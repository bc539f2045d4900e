// Terms of objectives against values computed by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/trials/trial.h"

namespace sim::trials {
namespace {

const double kLn2Pi = std::log(2 * std::numbers::pi);

TEST(PoseNll, OfNoErrorIsTheLogarithmOfThePeakOfTheDensity) {
  score::Matrix6d P = score::Matrix6d::Identity();
  P.diagonal() << 1e-4, 1e-4, 1e-4, 4e-4, 4e-4, 4e-4;  // σ: 0.01 rad, 0.02 m
  const auto X = Eigen::Isometry3d::Identity();
  const double expected = 3 * std::log(0.01) + 3 * std::log(0.02) + 3 * kLn2Pi;
  EXPECT_NEAR(pose_nll(X, X, P).value(), expected, 1e-12);  // of doubles
}

TEST(PoseNll, GrowsByHalfTheSquareOfTheErrorInSigmas) {
  score::Matrix6d P = score::Matrix6d::Identity() * 1e-4;
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity(), estimate = truth;
  truth.translation().x() = 0.03;                                               // 3 σ
  truth.linear() = Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitY()).matrix();  // 2 σ
  EXPECT_NEAR(pose_nll(truth, estimate, P).value() - pose_nll(truth, truth, P).value(), (9 + 4) / 2.0, 1e-9);
}

TEST(PoseNll, KnowsThatErrorsGoTogether) {
  score::Matrix6d P = score::Matrix6d::Identity();
  P(0, 3) = P(3, 0) = 0.6;  // |P| = 1 − 0.36
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
  truth.translation().x() = 1;
  const double expected = (1 / 0.64 + std::log(0.64) + 6 * kLn2Pi) / 2;
  EXPECT_NEAR(pose_nll(truth, Eigen::Isometry3d::Identity(), P).value(), expected, 1e-12);
}

TEST(PoseNll, HasNoValueWhereACovarianceIsNotPositiveDefinite) {
  score::Matrix6d P = score::Matrix6d::Identity();
  P(2, 2) = -1;
  EXPECT_FALSE(pose_nll(Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity(), P));
}

TEST(PoseNll, IsSmallestForTheSigmaThatTheErrorsHave) {
  // Errors ±0.02 in every direction: the maximum likelihood estimate of σ is 0.02.
  const auto at = [](double sigma) {
    const score::Matrix6d P = score::Matrix6d::Identity() * sigma * sigma;
    Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
    truth.translation().setConstant(0.02);
    Eigen::Vector3d turn = Eigen::Vector3d::Constant(0.02);
    truth.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).matrix();
    return pose_nll(truth, Eigen::Isometry3d::Identity(), P).value();
  };
  EXPECT_LT(at(0.02), at(0.019));
  EXPECT_LT(at(0.02), at(0.021));
}

TEST(InnovationNll, IsTheSumOverSensorsOfTheirGaussians) {
  slam::FrameReport report;
  report.innovations = {{"gyro", {2.5, 3, std::log(1e-6)}}, {"height", {1.0, 1, std::log(9e-4)}}};
  const double gyro = (2.5 + std::log(1e-6) + 3 * kLn2Pi) / 2, height = (1 + std::log(9e-4) + kLn2Pi) / 2;
  EXPECT_NEAR(innovation_nll(report, 76800), gyro + height, 1e-12);
}

TEST(InnovationNll, ChargesALandmarkNotFoundWithTheWholeImage) {
  slam::FrameReport report;
  report.searched.resize(5);
  report.matched.resize(3);
  EXPECT_NEAR(innovation_nll(report, 76800), 2 * std::log(76800.0), 1e-12);
}

TEST(InnovationNll, JudgesMatchesByTheUpdateNotByTheGate) {
  slam::FrameReport report;
  report.innovations = {{"vision", {50, 2, -10}}};
  report.update = slam::Nis{2, 2, 0};
  EXPECT_NEAR(innovation_nll(report, 76800), (2 + 2 * kLn2Pi) / 2, 1e-12);
}

}  // namespace
}  // namespace sim::trials
