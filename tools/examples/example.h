// Makes an estimator of a C++ class for gaitslam_estimator.h. Exceptions of the class become failures.
#pragma once

#include <cstdio>
#include <exception>
#include <string>

#include "gaitslam_estimator.h"

class Example {
 public:
  std::string failure;  ///< of the last observation
  virtual ~Example() = default;
  /// image: of camera 0, NULL if it is lost.
  virtual void process(const gaitslam_observation& observation, const gaitslam_reading* gyro,
                       const uint8_t* image, const gaitslam_rig& rig) = 0;
  virtual void write(gaitslam_answer& answer, const gaitslam_landmark** landmarks, const char** cause) = 0;
};

/// Each example has its own. Throws if it cannot start.
Example* new_example(const gaitslam_start& start, const gaitslam_sensors& sensors,
                     const std::string& options);

void* gaitslam_estimator_create(const gaitslam_start* start, const gaitslam_sensors* sensors,
                                const char* options, char* error, size_t error_bytes) {
  try {
    return new_example(*start, *sensors, options);
  } catch (const std::exception& e) {
    std::snprintf(error, error_bytes, "%s", e.what());
    return nullptr;
  }
}

int gaitslam_estimator_observe(void* estimator, const gaitslam_observation* observation,
                               const gaitslam_reading* gyro, const gaitslam_reading*, const uint8_t* image,
                               const gaitslam_rig* rig, gaitslam_answer* answer,
                               const gaitslam_landmark** landmarks, const char** cause) {
  Example& example = *static_cast<Example*>(estimator);
  try {
    example.process(*observation, gyro, image, *rig);
    example.write(*answer, landmarks, cause);
    return 0;
  } catch (const std::exception& e) {
    example.failure = e.what();
    *cause = example.failure.c_str();
    return 1;
  }
}

void gaitslam_estimator_destroy(void* estimator) { delete static_cast<Example*>(estimator); }
