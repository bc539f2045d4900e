/* The smallest estimator: its pose is the planned one. It can be the start of your own.
 *
 *     cc -O2 -DGAITSLAM_ESTIMATOR_MAIN -I sim/estimators -o plan_alone tools/examples/plan_alone.c
 *     tools/gaitslam replay RESULT 'estimator={program: ./plan_alone}' */
#include <stdlib.h>
#include <string.h>

#include "gaitslam_estimator.h"

void* gaitslam_estimator_create(const gaitslam_start* start, const gaitslam_sensors* sensors,
                                const char* options, char* error, size_t error_bytes) {
  gaitslam_answer* self = (gaitslam_answer*)calloc(1, sizeof *self); /* the last answer */
  (void)sensors;
  if (self && !options[0]) {
    self->status = GAITSLAM_NOT_READY;
    self->X_WC = start->X_WC;
    return self;
  }
  strncpy(error, self ? "unknown option, expected none" : "no memory", error_bytes - 1);
  free(self);
  return NULL;
}

int gaitslam_estimator_observe(void* of, const gaitslam_observation* observation,
                               const gaitslam_reading* gyro, const gaitslam_reading* accelerometer,
                               const uint8_t* image, const gaitslam_rig* rig, gaitslam_answer* answer,
                               const gaitslam_landmark** landmarks, const char** cause) {
  gaitslam_answer* self = (gaitslam_answer*)of;
  (void)gyro, (void)accelerometer, (void)image, (void)rig, (void)landmarks, (void)cause;
  if (observation->t_ns >= self->t_ns) { /* ignores late observations */
    self->t_ns = observation->t_ns;
    if (observation->has_plan) {
      self->status = GAITSLAM_OK;
      self->X_WC = observation->plan.X_PC;
    }
  }
  *answer = *self;
  return 0;
}

void gaitslam_estimator_destroy(void* self) { free(self); }
