// The built-in filter as an external program. Its options are the scenario's keys slam.* without "slam.".
#include <algorithm>
#include <cstring>
#include <exception>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "sim/estimators/gaitslam_estimator.h"
#include "sim/scenario/scenario.h"
#include "slam/filter.h"

namespace {

using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using RowMajor6d = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

Eigen::Isometry3d isometry(const gaitslam_pose& pose) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::Map<const RowMajor3d>(pose.rotation);
  X.translation() = Eigen::Map<const Eigen::Vector3d>(pose.translation_m);
  return X;
}

slam::Lens lens_of(const gaitslam_start& start) {
  const double* const k = start.lens_parameters;
  if (start.lens == GAITSLAM_LENS_RADIAL_TANGENTIAL) return slam::RadialTangential{k[0], k[1], k[2], k[3]};
  if (start.lens == GAITSLAM_LENS_EQUIDISTANT) return slam::Equidistant{k[0], k[1], k[2], k[3]};
  return slam::OneParameterRadial{k[0]};
}

slam::Calibration calibration_of(const gaitslam_start& start) {
  slam::Calibration calibration;
  calibration.camera = {static_cast<int>(start.width_px),
                        static_cast<int>(start.height_px),
                        start.focal_px[0],
                        start.focal_px[1],
                        start.center_px[0],
                        start.center_px[1],
                        lens_of(start)};
  calibration.X_CG = isometry(start.X_CG);
  return calibration;
}

slam::Options options_of(const std::string& text) {
  sim::scenario::Changes changes;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) changes.overrides.push_back("slam." + line);
  constexpr const char* kRest = "walk: {commands: [stand: {duration_s: 1}]}\ncamera: {}\nslam: {}\n";
  return *sim::scenario::read_scenario_text(kRest, "options", changes).scenario.slam;
}

std::vector<slam::InertialSample> samples(const gaitslam_reading* readings, std::uint32_t count) {
  std::vector<slam::InertialSample> all;
  for (const gaitslam_reading& reading : std::span(readings, count))
    all.push_back({slam::Stamp(reading.begin_ns), slam::Stamp(reading.end_ns),
                   Eigen::Map<const Eigen::Vector3d>(reading.value)});
  return all;
}

slam::PlannedMotion planned(const gaitslam_plan& plan) {
  std::optional<slam::LegMotion> legs;
  if (plan.has_legs)
    legs = slam::LegMotion{isometry(plan.X_OC), Eigen::Map<const Eigen::Vector3d>(plan.p_CS)};
  return {isometry(plan.X_PC),
          Eigen::Map<const Eigen::Vector3d>(plan.v_PC_C),
          Eigen::Map<const Eigen::Vector3d>(plan.w_PC_C),
          Eigen::Map<const Eigen::Vector3d>(plan.p_CF),
          static_cast<slam::Support>(plan.support),
          legs};
}

void write_estimate(const slam::Estimate& estimate, gaitslam_answer& answer) {
  answer.t_ns = estimate.t.count();
  answer.has_covariance = 1;
  Eigen::Map<RowMajor3d>(answer.X_WC.rotation) = estimate.X_WC.linear();
  Eigen::Map<Eigen::Vector3d>(answer.X_WC.translation_m) = estimate.X_WC.translation();
  Eigen::Map<RowMajor6d>(answer.covariance) = estimate.covariance;
}

struct FilterEstimator {
  slam::Filter filter;
  std::string cause = {};
};

}  // namespace

void* gaitslam_estimator_create(const gaitslam_start* start, const char* options, char* error,
                                size_t error_bytes) {
  try {
    return new FilterEstimator{
        slam::Filter(options_of(options), calibration_of(*start), isometry(start->X_WC), start->seed)};
  } catch (const std::exception& e) {
    std::strncpy(error, e.what(), error_bytes - 1);
    return nullptr;
  }
}

int gaitslam_estimator_observe(void* estimator, const gaitslam_observation* observation,
                               const gaitslam_reading* gyro, const gaitslam_reading* accelerometer,
                               const uint8_t* image, gaitslam_answer* answer, const gaitslam_landmark**,
                               const char** cause) {
  auto& [filter, text] = *static_cast<FilterEstimator*>(estimator);
  try {
    slam::Observation received;
    received.t = slam::Stamp(observation->t_ns);
    if (image)
      received.image = cv::Mat(static_cast<int>(observation->height_px),
                               static_cast<int>(observation->width_px), CV_8UC1, const_cast<uint8_t*>(image))
                           .clone();
    received.gyro = samples(gyro, observation->gyro_count);
    received.accelerometer = samples(accelerometer, observation->accelerometer_count);
    if (observation->has_plan) received.plan = planned(observation->plan);
    const slam::FrameReport& report = filter.step(received);
    answer->status = static_cast<uint32_t>(report.health);
    text = report.cause;
    write_estimate(filter.estimate(), *answer);
  } catch (const std::exception& e) {
    text = e.what();
    *cause = text.c_str();
    return 1;
  }
  *cause = text.c_str();
  return 0;
}

void gaitslam_estimator_destroy(void* estimator) { delete static_cast<FilterEstimator*>(estimator); }
