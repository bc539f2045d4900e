/* Interface of an external estimator: a program that exchanges messages with GaitSLAM over its standard input
 * and output. C99; no other file of GaitSLAM is needed.
 *
 * An estimator receives the calibration, the start and its options once, then one observation after another.
 * It answers each before the next is sent. It never receives ground truth.
 *
 * All numbers are little-endian. The structures have no padding, so their bytes in memory are their bytes in
 * a message. Lengths are in m, angles in rad, times in ns since the start of the run. Frames: W world (z up,
 * under the start), P world of the walking plan (equals W at the start, drifts from it), C camera (x right,
 * y down, z forward), G inertial sensor in the chest. X_WC maps points of C to W.
 *
 * In C or C++, define the three functions under "Functions"; this file supplies main():
 *     cc -DGAITSLAM_ESTIMATOR_MAIN -o mine mine.c
 * In another language, read and write the messages under "Messages". */
#ifndef GAITSLAM_ESTIMATOR_H
#define GAITSLAM_ESTIMATOR_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Version of this interface. A program with another version is rejected. */
#define GAITSLAM_ESTIMATOR_VERSION 2u

/* ---- Structures */

/* A pose X_AB: a point p of B is rotation p + translation_m in A. */
typedef struct gaitslam_pose {
  double rotation[9]; /* row by row */
  double translation_m[3];
} gaitslam_pose; /* 96 bytes */

/* Lens models and their lens_parameters; (x, y, z) is a point in C. */
enum {
  /* u = u0 + uc / sqrt(1 + 2 k |uc|^2), uc = (fu x/z, fv y/z); parameter: k (1/px^2), 0: ideal pinhole */
  GAITSLAM_LENS_ONE_PARAMETER_RADIAL = 0,
  GAITSLAM_LENS_RADIAL_TANGENTIAL = 1, /* OpenCV's first four; parameters: k1 k2 p1 p2 */
  GAITSLAM_LENS_EQUIDISTANT = 2        /* OpenCV's fisheye; parameters: k1 k2 k3 k4 */
};

/* Known before the first observation. */
typedef struct gaitslam_start {
  uint32_t version;             /* GAITSLAM_ESTIMATOR_VERSION */
  uint32_t lens;                /* one of GAITSLAM_LENS_... */
  uint32_t width_px, height_px; /* of the images; the center of the first pixel is (0, 0) */
  double focal_px[2];           /* fu fv */
  double center_px[2];          /* u0 v0 */
  double lens_parameters[4];
  gaitslam_pose X_CG;     /* inertial sensor in the camera's frame */
  gaitslam_pose X_WC;     /* camera at t = 0, as planned */
  uint64_t seed;          /* of the run, for reproducible random numbers */
  uint64_t options_bytes; /* length of the options */
} gaitslam_start;         /* 288 bytes */

/* The mean over (begin_ns, end_ns] in axes of G: angular velocity in rad/s, or specific force in m/s^2 (+g
 * upwards at rest). */
typedef struct gaitslam_reading {
  int64_t begin_ns, end_ns;
  double value[3];
} gaitslam_reading; /* 40 bytes */

enum { GAITSLAM_SUPPORT_BOTH = 0, GAITSLAM_SUPPORT_LEFT = 1, GAITSLAM_SUPPORT_RIGHT = 2 };

/* Planned motion of the camera at the stamp of the image, and its motion by leg odometry. */
typedef struct gaitslam_plan {
  gaitslam_pose X_PC;
  double v_PC_C[3];   /* linear velocity of C in P, axes C, m/s */
  double w_PC_C[3];   /* angular velocity of C in P, axes C, rad/s */
  double p_CF[3];     /* planned sole of the support foot, or the middle of both soles, in C */
  uint32_t support;   /* one of GAITSLAM_SUPPORT_... */
  uint32_t has_legs;  /* 1, or 0: X_OC and p_CS are zero */
  gaitslam_pose X_OC; /* camera by leg odometry, from encoders and ankle forces. O equals W at the start and
                         drifts from it as soles slip and tilt */
  double p_CS[3];     /* the sole that carries the robot, in C */
} gaitslam_plan;      /* 296 bytes */

/* An image and the readings since the previous one. Missing data has size or count 0. */
typedef struct gaitslam_observation {
  int64_t t_ns;                 /* the scenario may lose, double or reorder stamps */
  uint32_t width_px, height_px; /* 0 0: the image is lost */
  uint32_t gyro_count, accelerometer_count;
  uint32_t has_plan; /* 1, or 0: `plan` is all zero */
  uint32_t reserved; /* 0 */
  gaitslam_plan plan;
} gaitslam_observation; /* 328 bytes */

enum {
  GAITSLAM_OK = 0,       /* it tracks */
  GAITSLAM_LOST = 1,     /* it is lost and may recover; its pose is not recorded */
  GAITSLAM_DIVERGED = 2, /* it has given up and receives no more observations */
  GAITSLAM_NOT_READY = 3 /* it has not initialized yet; its pose is ignored */
};

/* The estimate after an observation. */
typedef struct gaitslam_answer {
  int64_t t_ns;    /* stamp of the pose: the observation's, or the last one's if there is no new pose */
  uint32_t status; /* GAITSLAM_OK, _LOST, _DIVERGED or _NOT_READY */
  uint32_t has_covariance; /* 1, or 0: `covariance` is zero */
  gaitslam_pose X_WC;
  double covariance[36];   /* of (Log(R_estimate^T R_true) in axes C, rad; p_true - p_estimate in axes W, m),
                              row by row */
  uint32_t landmark_count; /* landmarks that follow: the whole map, or 0 to keep the previous one */
  uint32_t cause_bytes;    /* length of the text after the landmarks: why the status is not ok */
} gaitslam_answer;         /* 408 bytes */

/* A landmark of the map. */
typedef struct gaitslam_landmark {
  uint32_t id;
  uint32_t has_covariance; /* 1, or 0: `covariance` is zero */
  double p_W_m[3];
  double covariance[9]; /* m^2, axes W, row by row */
} gaitslam_landmark;    /* 104 bytes */

/* Limits of an answer. */
#define GAITSLAM_MOST_LANDMARKS 100000u
#define GAITSLAM_MOST_TEXT_BYTES 4096u

/* ---- Messages */

/* A message is this header and `bytes` bytes after it:
 *
 *     START        gaitslam_start, options
 *     READY        gaitslam_ready, text
 *     OBSERVATION  gaitslam_observation, gyro_count readings, accelerometer_count readings, image (one byte a
 *                  pixel, row by row)
 *     ANSWER       gaitslam_answer, landmark_count landmarks, cause
 *     END          nothing; the program exits
 *
 * GaitSLAM sends START, OBSERVATION and END; the program answers the first two with READY and ANSWER. Options
 * are text, one line "key=value" each. A program writes only messages to its standard output; the result
 * keeps what it writes to its standard error. */
typedef struct gaitslam_header {
  char magic[4];   /* "GSLM" */
  uint32_t type;   /* one of GAITSLAM_MESSAGE_... */
  uint64_t bytes;  /* of what follows */
} gaitslam_header; /* 16 bytes */

enum {
  GAITSLAM_MESSAGE_START = 1,
  GAITSLAM_MESSAGE_READY = 2,
  GAITSLAM_MESSAGE_OBSERVATION = 3,
  GAITSLAM_MESSAGE_ANSWER = 4,
  GAITSLAM_MESSAGE_END = 5
};

typedef struct gaitslam_ready {
  uint32_t version;     /* GAITSLAM_ESTIMATOR_VERSION of the program */
  uint32_t error_bytes; /* length of the text that follows: why it cannot start; 0 if it can */
} gaitslam_ready;       /* 8 bytes */

/* ---- Functions */

/* Creates an estimator. options: zero-terminated text, one line "key=value" each. Returns NULL if it cannot,
 * with the reason in error[0 .. error_bytes - 1]. */
void* gaitslam_estimator_create(const gaitslam_start* start, const char* options, char* error,
                                size_t error_bytes);

/* Processes an observation and fills in *answer, which starts with t_ns set, X_WC the identity and zeros.
 * image: width_px * height_px bytes, row by row; NULL if it is lost. *landmarks: answer->landmark_count of
 * them; *cause: zero-terminated text. Both start as NULL, belong to the estimator and must live until the
 * next call. Returns 0, or another number if the estimator failed, with the reason in *cause. */
int gaitslam_estimator_observe(void* estimator, const gaitslam_observation* observation,
                               const gaitslam_reading* gyro, const gaitslam_reading* accelerometer,
                               const uint8_t* image, gaitslam_answer* answer,
                               const gaitslam_landmark** landmarks, const char** cause);

/* Frees the estimator at the end of the run. */
void gaitslam_estimator_destroy(void* estimator);

#ifdef __cplusplus
}
#endif

#endif /* GAITSLAM_ESTIMATOR_H */

/* ---- The program around these functions */

#if defined(GAITSLAM_ESTIMATOR_MAIN) && !defined(GAITSLAM_ESTIMATOR_HAS_MAIN)
#define GAITSLAM_ESTIMATOR_HAS_MAIN

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Writes all bytes. Returns 0 if the other end is closed. */
static int gaitslam_write(int out, const void* bytes, size_t count) {
  const char* at = (const char*)bytes;
  while (count > 0) {
    const ssize_t written = write(out, at, count);
    if (written < 0 && errno != EINTR) return 0;
    if (written > 0) at += written, count -= (size_t)written;
  }
  return 1;
}

/* Writes the header of a message and its first structure. */
static int gaitslam_begin(int out, uint32_t type, const void* part, size_t bytes, size_t bytes_after) {
  gaitslam_header header = {{'G', 'S', 'L', 'M'}, 0, 0};
  header.type = type;
  header.bytes = bytes + bytes_after;
  return gaitslam_write(out, &header, sizeof header) && gaitslam_write(out, part, bytes);
}

/* Answers the observation in `payload`. Returns 0 if the estimator failed or the message is invalid. */
static int gaitslam_answer_observation(void* estimator, const char* payload, uint64_t bytes, int out) {
  gaitslam_observation observation;
  gaitslam_answer answer;
  const gaitslam_landmark* landmarks = NULL;
  const char* cause = NULL;
  const char *gyro, *accelerometer, *image;
  size_t landmark_bytes;
  if (bytes < sizeof observation) return 0;
  memcpy(&observation, payload, sizeof observation);
  gyro = payload + sizeof observation;
  accelerometer = gyro + observation.gyro_count * sizeof(gaitslam_reading);
  image = accelerometer + observation.accelerometer_count * sizeof(gaitslam_reading);
  if ((uint64_t)(image - payload) + (uint64_t)observation.width_px * observation.height_px != bytes) return 0;
  memset(&answer, 0, sizeof answer);
  answer.t_ns = observation.t_ns;
  answer.X_WC.rotation[0] = answer.X_WC.rotation[4] = answer.X_WC.rotation[8] = 1;
  if (gaitslam_estimator_observe(
          estimator, &observation, (const gaitslam_reading*)gyro, (const gaitslam_reading*)accelerometer,
          observation.width_px ? (const uint8_t*)image : NULL, &answer, &landmarks, &cause)) {
    fprintf(stderr, "%s\n", cause ? cause : "the estimator failed");
    return 0;
  }
  if (answer.landmark_count > GAITSLAM_MOST_LANDMARKS || (answer.landmark_count > 0 && !landmarks)) {
    fprintf(stderr, "it announces %lu landmarks, expected at most %lu and a pointer to them\n",
            (unsigned long)answer.landmark_count, (unsigned long)GAITSLAM_MOST_LANDMARKS);
    return 0;
  }
  answer.cause_bytes = 0;
  if (!cause) cause = "";
  while (cause[answer.cause_bytes] && answer.cause_bytes < GAITSLAM_MOST_TEXT_BYTES) ++answer.cause_bytes;
  landmark_bytes = answer.landmark_count * sizeof(gaitslam_landmark);
  return gaitslam_begin(out, GAITSLAM_MESSAGE_ANSWER, &answer, sizeof answer,
                        landmark_bytes + answer.cause_bytes) &&
         gaitslam_write(out, landmarks, landmark_bytes) && gaitslam_write(out, cause, answer.cause_bytes);
}

/* Creates the estimator of the START message in `payload` and answers READY. Returns NULL on failure. */
static void* gaitslam_answer_start(const char* payload, uint64_t bytes, int out) {
  gaitslam_start start;
  gaitslam_ready ready = {GAITSLAM_ESTIMATOR_VERSION, 0};
  char error[512] = "";
  void* estimator = NULL;
  uint32_t version = 0;
  if (bytes >= sizeof version) memcpy(&version, payload, sizeof version);
  if (version == GAITSLAM_ESTIMATOR_VERSION && bytes >= sizeof start) {
    memcpy(&start, payload, sizeof start);
    estimator = gaitslam_estimator_create(&start, payload + sizeof start, error, sizeof error);
    error[sizeof error - 1] = '\0';
    if (!estimator && !error[0]) strcpy(error, "the estimator could not be created");
  }
  ready.error_bytes = (uint32_t)strlen(error);
  if (gaitslam_begin(out, GAITSLAM_MESSAGE_READY, &ready, sizeof ready, ready.error_bytes))
    gaitslam_write(out, error, ready.error_bytes);
  return estimator;
}

/* Answers all messages of the standard input. What the estimator prints goes to the standard error. */
int main(void) {
  const int out = dup(STDOUT_FILENO);
  gaitslam_header header;
  char* payload = NULL;
  void* estimator = NULL;
  int fine = out >= 0 && dup2(STDERR_FILENO, STDOUT_FILENO) >= 0;
  setvbuf(stdout, NULL, _IOLBF, BUFSIZ); /* a crash loses no line that it printed */
  while (fine && fread(&header, sizeof header, 1, stdin) == 1 && header.type != GAITSLAM_MESSAGE_END) {
    const size_t bytes = (size_t)header.bytes;
    free(payload);
    payload = (char*)malloc(bytes + 1);
    fine = payload && memcmp(header.magic, "GSLM", 4) == 0 &&
           (bytes == 0 || fread(payload, bytes, 1, stdin) == 1);
    if (!fine) break;
    payload[bytes] = '\0'; /* ends the options */
    if (header.type == GAITSLAM_MESSAGE_START && !estimator)
      fine = (estimator = gaitslam_answer_start(payload, bytes, out)) != NULL;
    else
      fine = header.type == GAITSLAM_MESSAGE_OBSERVATION && estimator &&
             gaitslam_answer_observation(estimator, payload, bytes, out);
  }
  free(payload);
  if (estimator) gaitslam_estimator_destroy(estimator);
  if (out >= 0) close(out);
  return fine ? 0 : 1;
}

#endif
