/* The interface of an estimator that GaitSLAM runs: as a program (messages over standard input and output) or
 * as a shared library (functions with the same structures). C99, no other file of GaitSLAM is needed.
 *
 * An estimator is told the calibration, the start and its options once, then one observation after another,
 * and answers each before the next is sent. It is never told a true pose.
 *
 * All numbers are little-endian; every structure below is laid out without hidden gaps, so that its bytes in
 * memory are its bytes in a message. Lengths are in m, angles in rad, times in ns since the start of the run.
 * Frames: W world (z up, under the start), P the world of the walking plan (equals W at the start, drifts
 * from it), C camera (x right, y down, z forward), G inertial sensor in the chest. X_WC maps points of C to
 * W.
 *
 * A library defines the four functions below, under "Functions of a library":
 *     cc -shared -fPIC -o libmine.so mine.c
 * A program is the same source with a main() from this file:
 *     cc -DGAITSLAM_ESTIMATOR_MAIN -o mine mine.c
 * A program in another language reads and writes the messages itself, see "Messages". */
#ifndef GAITSLAM_ESTIMATOR_H
#define GAITSLAM_ESTIMATOR_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The version of this interface. A library or program of another version is refused. */
#define GAITSLAM_ESTIMATOR_VERSION 2u

/* ---- Structures */

/* A pose X_AB: a point p of B is rotation p + translation_m in A. */
typedef struct gaitslam_pose {
  double rotation[9]; /* row by row */
  double translation_m[3];
} gaitslam_pose; /* 96 bytes */

/* Lenses of the camera. parameters: what lens_parameters holds; (x, y, z) is the point in C. */
enum {
  /* u = u0 + uc / sqrt(1 + 2 k |uc|^2), uc = (fu x/z, fv y/z); parameter: k (1/px^2), 0: ideal pinhole */
  GAITSLAM_LENS_ONE_PARAMETER_RADIAL = 0,
  GAITSLAM_LENS_RADIAL_TANGENTIAL = 1, /* OpenCV's first four; parameters: k1 k2 p1 p2 */
  GAITSLAM_LENS_EQUIDISTANT = 2        /* OpenCV's fisheye; parameters: k1 k2 k3 k4 */
};

/* What is known before the first observation. */
typedef struct gaitslam_start {
  uint32_t version;             /* GAITSLAM_ESTIMATOR_VERSION */
  uint32_t lens;                /* one of GAITSLAM_LENS_... */
  uint32_t width_px, height_px; /* of the images; the centre of the first pixel is (0, 0) */
  double focal_px[2];           /* fu fv */
  double centre_px[2];          /* u0 v0 */
  double lens_parameters[4];
  gaitslam_pose X_CG;     /* inertial sensor in the camera's frame */
  gaitslam_pose X_WC;     /* camera at t = 0, as planned */
  uint64_t seed;          /* of the run; for random numbers that are to be the same on the same seed */
  uint64_t options_bytes; /* in a message: length of the options that follow; in a library: of `options` */
} gaitslam_start;         /* 288 bytes */

/* The mean over (begin_ns, end_ns] in axes of G: angular velocity in rad/s, or specific force in m/s^2 (+g
 * upwards at rest). */
typedef struct gaitslam_reading {
  int64_t begin_ns, end_ns;
  double value[3];
} gaitslam_reading; /* 40 bytes */

enum { GAITSLAM_SUPPORT_BOTH = 0, GAITSLAM_SUPPORT_LEFT = 1, GAITSLAM_SUPPORT_RIGHT = 2 };

/* The planned motion of the camera at the stamp of the image, and what the legs made of it. */
typedef struct gaitslam_plan {
  gaitslam_pose X_PC;
  double v_PC_C[3];  /* linear velocity of C in P, axes C, m/s */
  double w_PC_C[3];  /* angular velocity of C in P, axes C, rad/s */
  double p_CF[3];    /* planned sole of the support foot, or the middle of both soles, in C */
  uint32_t support;  /* one of GAITSLAM_SUPPORT_... */
  uint32_t has_legs; /* 1, or 0: what follows is all zero */
  gaitslam_pose X_OC; /* camera by leg odometry: encoders and ankle forces, from the sole that carries the
                         robot. O equals W at the start and drifts from it as soles slip and tilt */
  double p_CS[3];     /* the sole that carries the robot, in C */
} gaitslam_plan;      /* 296 bytes */

/* An image and what was measured since the one before. What is missing has size or count 0. */
typedef struct gaitslam_observation {
  int64_t t_ns;                 /* stamps may be lost, doubled or out of order where the scenario says so */
  uint32_t width_px, height_px; /* 0 0: the image is lost */
  uint32_t gyro_count, accelerometer_count;
  uint32_t has_plan; /* 1, or 0: `plan` is all zero */
  uint32_t reserved; /* 0 */
  gaitslam_plan plan;
} gaitslam_observation; /* 328 bytes */

enum {
  GAITSLAM_OK = 0,      /* it tracks */
  GAITSLAM_LOST = 1,    /* it does not, and may find its way again */
  GAITSLAM_DIVERGED = 2 /* it has given up and will be sent no more observations */
};

/* The estimate after an observation. */
typedef struct gaitslam_answer {
  int64_t t_ns;    /* stamp of the pose: the observation's, or the last one's if there is no new pose */
  uint32_t status; /* GAITSLAM_OK, _LOST or _DIVERGED */
  uint32_t has_covariance; /* 1, or 0: the estimator states none */
  gaitslam_pose X_WC;
  double covariance[36];   /* of (Log(R_estimate^T R_true) in axes C, rad; p_true - p_estimate in axes W, m),
                              row by row */
  uint32_t landmark_count; /* landmarks that follow: the whole map; 0 where it is not sent this time */
  uint32_t cause_bytes; /* in a message: length of the text after the landmarks, why the status is not ok */
} gaitslam_answer;      /* 408 bytes */

/* A landmark of the map. */
typedef struct gaitslam_landmark {
  uint32_t id;
  uint32_t has_covariance; /* 1, or 0: `covariance` is all zero */
  double p_W_m[3];
  double covariance[9]; /* m^2, axes W, row by row */
} gaitslam_landmark;    /* 104 bytes */

/* What an answer may hold at most. */
#define GAITSLAM_MOST_LANDMARKS 100000u
#define GAITSLAM_MOST_TEXT_BYTES 4096u

/* ---- Messages */

/* A message is this header and `bytes` bytes after it:
 *
 *   START        gaitslam_start, options
 *     READY      gaitslam_ready, text
 *   OBSERVATION  gaitslam_observation, gyro_count readings, accelerometer_count readings, the image row by
 * row (one byte a pixel) ANSWER     gaitslam_answer, landmark_count landmarks, cause END          nothing;
 * the program ends
 *
 * GaitSLAM sends START, OBSERVATION and END, the program answers the first two with READY and ANSWER.
 *
 * Options are text, a line "key=value" for each. A program writes nothing else to its standard output; what
 * it writes to its standard error is kept in the result. */
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
  uint32_t error_bytes; /* length of the text that follows, why it cannot be started; 0 if it can */
} gaitslam_ready;       /* 8 bytes */

/* ---- Functions of a library */

/* GAITSLAM_ESTIMATOR_VERSION. */
uint32_t gaitslam_estimator_version(void);

/* Makes an estimator. options: text, a line "key=value" for each, ending in a zero byte. Returns NULL where
 * it cannot be made, with the reason, ending in a zero byte, in error[0 .. error_bytes - 1]. */
void* gaitslam_estimator_create(const gaitslam_start* start, const char* options, char* error,
                                size_t error_bytes);

/* Takes an observation and fills in *answer, which comes with t_ns set, the identity for X_WC and all else
 * zero. image: width_px * height_px bytes, row by row, NULL where it is lost. *landmarks:
 * answer->landmark_count of them, *cause: text ending in a zero byte; both belong to the estimator, are NULL
 * before the call, and must live until the next one. Returns 0, or another number where the estimator has
 * failed, with the reason in *cause. */
int gaitslam_estimator_observe(void* estimator, const gaitslam_observation* observation,
                               const gaitslam_reading* gyro, const gaitslam_reading* accelerometer,
                               const uint8_t* image, gaitslam_answer* answer,
                               const gaitslam_landmark** landmarks, const char** cause);

/* The run is over. */
void gaitslam_estimator_destroy(void* estimator);

#ifdef __cplusplus
}
#endif

#endif /* GAITSLAM_ESTIMATOR_H */

/* ---- A program made of these functions */

#if (defined(GAITSLAM_ESTIMATOR_MAIN) || defined(GAITSLAM_ESTIMATOR_SERVE)) && \
    !defined(GAITSLAM_ESTIMATOR_SERVED)
#define GAITSLAM_ESTIMATOR_SERVED

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The functions of an estimator, as above. */
typedef struct gaitslam_functions {
  void* (*create)(const gaitslam_start*, const char*, char*, size_t);
  int (*observe)(void*, const gaitslam_observation*, const gaitslam_reading*, const gaitslam_reading*,
                 const uint8_t*, gaitslam_answer*, const gaitslam_landmark**, const char**);
  void (*destroy)(void*);
} gaitslam_functions;

/* Returns 1, or 0 at the end of the input. */
static int gaitslam_read(FILE* in, void* to, size_t bytes) {
  return bytes == 0 || fread(to, bytes, 1, in) == 1;
}

/* Writes a message at once. Returns 0 where nobody reads it. */
static int gaitslam_write(int out, uint32_t type, const void* part, size_t bytes, const void* list,
                          size_t list_bytes, const char* text, size_t text_bytes) {
  gaitslam_header header = {{'G', 'S', 'L', 'M'}, 0, 0};
  const size_t whole = sizeof header + bytes + list_bytes + text_bytes;
  char* const message = (char*)malloc(whole);
  size_t at = 0;
  header.type = type;
  header.bytes = bytes + list_bytes + text_bytes;
  if (!message) return 0;
  memcpy(message, &header, sizeof header);
  memcpy(message + sizeof header, part, bytes);
  if (list_bytes) memcpy(message + sizeof header + bytes, list, list_bytes);
  if (text_bytes) memcpy(message + sizeof header + bytes + list_bytes, text, text_bytes);
  while (at < whole) {
    const ssize_t written = write(out, message + at, whole - at);
    if (written < 0 && errno != EINTR) break;
    if (written > 0) at += (size_t)written;
  }
  free(message);
  return at == whole;
}

/* Answers the observation in `payload`. Returns 0 where the estimator failed or the message is none. */
static int gaitslam_answer_observation(const gaitslam_functions* functions, void* estimator,
                                       const char* payload, uint64_t bytes, int out) {
  gaitslam_observation observation;
  gaitslam_answer answer;
  const gaitslam_landmark* landmarks = NULL;
  const char* cause = NULL;
  const char *gyro, *accelerometer, *image;
  if (bytes < sizeof observation) return 0;
  memcpy(&observation, payload, sizeof observation);
  gyro = payload + sizeof observation;
  accelerometer = gyro + observation.gyro_count * sizeof(gaitslam_reading);
  image = accelerometer + observation.accelerometer_count * sizeof(gaitslam_reading);
  if ((uint64_t)(image - payload) + (uint64_t)observation.width_px * observation.height_px != bytes) return 0;
  memset(&answer, 0, sizeof answer);
  answer.t_ns = observation.t_ns;
  answer.X_WC.rotation[0] = answer.X_WC.rotation[4] = answer.X_WC.rotation[8] = 1;
  if (functions->observe(estimator, &observation, (const gaitslam_reading*)gyro,
                         (const gaitslam_reading*)accelerometer,
                         observation.width_px ? (const uint8_t*)image : NULL, &answer, &landmarks, &cause)) {
    fprintf(stderr, "%s\n", cause ? cause : "the estimator failed");
    return 0;
  }
  if (answer.landmark_count > GAITSLAM_MOST_LANDMARKS || (answer.landmark_count > 0 && !landmarks)) {
    fprintf(stderr, "it announces %lu landmarks, expected at most %lu, and where they are\n",
            (unsigned long)answer.landmark_count, (unsigned long)GAITSLAM_MOST_LANDMARKS);
    return 0;
  }
  answer.cause_bytes = 0;
  if (!cause) cause = "";
  while (cause[answer.cause_bytes] && answer.cause_bytes < GAITSLAM_MOST_TEXT_BYTES) ++answer.cause_bytes;
  return gaitslam_write(out, GAITSLAM_MESSAGE_ANSWER, &answer, sizeof answer, landmarks,
                        answer.landmark_count * sizeof(gaitslam_landmark), cause, answer.cause_bytes);
}

/* Makes the estimator of the START message in `payload` and says whether it could. */
static void* gaitslam_answer_start(const gaitslam_functions* functions, const char* payload, uint64_t bytes,
                                   int out) {
  gaitslam_start start;
  gaitslam_ready ready = {GAITSLAM_ESTIMATOR_VERSION, 0};
  char error[512] = "", *options;
  void* estimator = NULL;
  uint32_t version = 0;
  if (bytes >= sizeof version) memcpy(&version, payload, sizeof version);
  if (version == GAITSLAM_ESTIMATOR_VERSION && bytes >= sizeof start) {
    memcpy(&start, payload, sizeof start);
    options = (char*)calloc(1, (size_t)(bytes - sizeof start) + 1);
    if (options) memcpy(options, payload + sizeof start, (size_t)(bytes - sizeof start));
    if (options) estimator = functions->create(&start, options, error, sizeof error);
    free(options);
    error[sizeof error - 1] = '\0';
    if (!estimator && !error[0]) strcpy(error, "the estimator could not be created");
  }
  ready.error_bytes = (uint32_t)strlen(error);
  gaitslam_write(out, GAITSLAM_MESSAGE_READY, &ready, sizeof ready, NULL, 0, error, ready.error_bytes);
  return estimator;
}

/* Answers all messages of the standard input. Returns the exit code of a program that does nothing else. */
static int gaitslam_serve(const gaitslam_functions* functions) {
  /* Messages keep the standard output for themselves: what the estimator prints goes to the standard error.
   */
  const int out = dup(STDOUT_FILENO);
  gaitslam_header header;
  char* payload = NULL;
  void* estimator = NULL;
  int fine = out >= 0 && dup2(STDERR_FILENO, STDOUT_FILENO) >= 0;
  while (fine && gaitslam_read(stdin, &header, sizeof header) && header.type != GAITSLAM_MESSAGE_END) {
    free(payload);
    payload = (char*)malloc((size_t)header.bytes + 1);
    fine = payload && memcmp(header.magic, "GSLM", 4) == 0 &&
           gaitslam_read(stdin, payload, (size_t)header.bytes);
    if (fine && header.type == GAITSLAM_MESSAGE_START && !estimator) {
      estimator = gaitslam_answer_start(functions, payload, header.bytes, out);
      fine = estimator != NULL;
    } else if (fine) {
      fine = header.type == GAITSLAM_MESSAGE_OBSERVATION && estimator != NULL &&
             gaitslam_answer_observation(functions, estimator, payload, header.bytes, out);
    }
  }
  free(payload);
  if (estimator) functions->destroy(estimator);
  if (out >= 0) close(out);
  return fine ? 0 : 1;
}

#ifdef GAITSLAM_ESTIMATOR_MAIN
int main(void) {
  const gaitslam_functions functions = {gaitslam_estimator_create, gaitslam_estimator_observe,
                                        gaitslam_estimator_destroy};
  return gaitslam_serve(&functions);
}
#endif

#endif
