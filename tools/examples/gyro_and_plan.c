/* An estimator without images: integrates the gyro to an orientation, and the planned velocity along it.
 *
 *     cc -O2 -DGAITSLAM_ESTIMATOR_MAIN -I sim/estimators -o gyro_and_plan tools/examples/gyro_and_plan.c -lm
 *     tools/gaitslam replay RESULT 'estimator={program: ./gyro_and_plan}' */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "gaitslam_estimator.h"

typedef struct estimator {
  gaitslam_pose X_CG, X_WC;
  double v_W[3]; /* planned velocity at the previous observation, rotated by the estimated orientation */
  int64_t t_ns;
  int has_plan; /* an observation had a plan */
} estimator;

/* to = R v */
static void rotate(const double R[9], const double v[3], double to[3]) {
  int i;
  for (i = 0; i < 3; ++i) to[i] = R[3 * i] * v[0] + R[3 * i + 1] * v[1] + R[3 * i + 2] * v[2];
}

/* R = R Exp(turn), by Rodrigues' formula */
static void turn_by(double R[9], const double turn[3]) {
  const double angle = sqrt(turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2]);
  const double a = angle > 1e-9 ? sin(angle) / angle : 1,
               b = angle > 1e-9 ? (1 - cos(angle)) / (angle * angle) : 0.5;
  const double x = turn[0], y = turn[1], z = turn[2];
  const double E[9] = {1 - b * (y * y + z * z), b * x * y - a * z,       b * x * z + a * y,
                       b * x * y + a * z,       1 - b * (x * x + z * z), b * y * z - a * x,
                       b * x * z - a * y,       b * y * z + a * x,       1 - b * (x * x + y * y)};
  double product[9];
  int i, j;
  for (i = 0; i < 3; ++i)
    for (j = 0; j < 3; ++j)
      product[3 * i + j] = R[3 * i] * E[j] + R[3 * i + 1] * E[3 + j] + R[3 * i + 2] * E[6 + j];
  memcpy(R, product, sizeof product);
}

static void add_reading(estimator* self, const gaitslam_reading* reading) {
  const double dt = 1e-9 * (double)(reading->end_ns - reading->begin_ns);
  double turn_G[3], turn_C[3];
  int i;
  for (i = 0; i < 3; ++i) turn_G[i] = reading->value[i] * dt;
  rotate(self->X_CG.rotation, turn_G, turn_C);
  turn_by(self->X_WC.rotation, turn_C);
}

static void add_plan(estimator* self, const gaitslam_plan* plan, double dt) {
  double v_W[3];
  int i;
  rotate(self->X_WC.rotation, plan->v_PC_C, v_W);
  for (i = 0; i < 3; ++i) {
    self->X_WC.translation_m[i] += (self->v_W[i] + v_W[i]) / 2 * dt;
    self->v_W[i] = v_W[i];
  }
}

void* gaitslam_estimator_create(const gaitslam_start* start, const gaitslam_sensors* sensors,
                                const char* options, char* error, size_t error_bytes) {
  estimator* self = (estimator*)calloc(1, sizeof(estimator));
  (void)sensors;
  if (self && !options[0]) {
    self->X_CG = start->X_CG;
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
  estimator* self = (estimator*)of;
  uint32_t i;
  (void)accelerometer, (void)image, (void)rig, (void)landmarks, (void)cause;
  if (observation->t_ns >= self->t_ns) { /* ignores late observations */
    for (i = 0; i < observation->gyro_count; ++i) add_reading(self, &gyro[i]);
    if (observation->has_plan)
      add_plan(self, &observation->plan, 1e-9 * (double)(observation->t_ns - self->t_ns));
    self->t_ns = observation->t_ns;
    self->has_plan |= observation->has_plan;
  }
  answer->status = self->has_plan ? GAITSLAM_OK : GAITSLAM_NOT_READY;
  answer->t_ns = self->t_ns;
  answer->X_WC = self->X_WC;
  return 0;
}

void gaitslam_estimator_destroy(void* self) { free(self); }
