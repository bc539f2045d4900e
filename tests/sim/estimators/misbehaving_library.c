/* A library that answers the start pose, until it misbehaves at its third observation as its only option,
 * "behaviour=...", says. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "sim/estimators/gaitslam_estimator.h"

typedef struct estimator {
  gaitslam_pose X_WC;
  char behaviour[64];
  int observed;
} estimator;

uint32_t gaitslam_estimator_version(void) { return GAITSLAM_ESTIMATOR_VERSION; }

void* gaitslam_estimator_create(const gaitslam_start* start, const char* options, char* error,
                                size_t error_bytes) {
  estimator* self = (estimator*)calloc(1, sizeof(estimator));
  (void)error, (void)error_bytes;
  if (!self) return NULL;
  self->X_WC = start->X_WC;
  sscanf(options, "behaviour=%63s", self->behaviour);
  if (strcmp(self->behaviour, "crash_at_start") == 0) abort();
  return self;
}

int gaitslam_estimator_observe(void* of, const gaitslam_observation* observation,
                               const gaitslam_reading* gyro, const gaitslam_reading* accelerometer,
                               const uint8_t* image, gaitslam_answer* answer,
                               const gaitslam_landmark** landmarks, const char** cause) {
  estimator* self = (estimator*)of;
  const char* behaviour = ++self->observed == 3 ? self->behaviour : "";
  (void)observation, (void)gyro, (void)accelerometer, (void)image, (void)landmarks;
  answer->X_WC = self->X_WC;
  if (strcmp(behaviour, "crash") == 0) {
    signal(SIGSEGV, SIG_DFL);  // not the handler of a sanitizer
    raise(SIGSEGV);
  }
  if (strcmp(behaviour, "exit") == 0) exit(0);
  if (strcmp(behaviour, "hang") == 0) pause();
  if (strcmp(behaviour, "print") == 0) printf("what a library prints\n");
  if (strcmp(behaviour, "huge") == 0) answer->landmark_count = 3000000000u;
  if (strcmp(behaviour, "nowhere") == 0) answer->landmark_count = 3;
  *cause = "the map is broken";
  return strcmp(behaviour, "say_why") == 0;
}

void gaitslam_estimator_destroy(void* self) { free(self); }
