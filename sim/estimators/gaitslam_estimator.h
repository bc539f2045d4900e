/* Interface of an external estimator: a program that exchanges messages with GaitSLAM over its standard input
 * and output. C99; no other file of GaitSLAM is needed.
 *
 * An estimator receives the calibration, the start, the list of all sensors and its options once, then one
 * observation after another. It answers each before the next is sent. It never receives ground truth.
 *
 * All numbers are little-endian. The structures have no padding, so their bytes in memory are their bytes in
 * a message. Lengths are in m, angles in rad, times in ns since the start of the run. Frames: W world (z up,
 * under the start), P world of the walking plan (starts at W and drifts from it), C the head's gray camera
 * (x right, y down, z forward), G inertial sensor in the chest, K any other sensor: a camera has the axes of
 * C, a lidar or IMU has x forward, y left, z up. X_WC maps points of C to W.
 *
 * In C or C++, define the three functions under "Functions"; this file supplies main():
 *     cc -DGAITSLAM_ESTIMATOR_MAIN -o mine mine.c -lm
 * In another language, read and write the messages under "Messages". */
#ifndef GAITSLAM_ESTIMATOR_H
#define GAITSLAM_ESTIMATOR_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define GAITSLAM_ESTIMATOR_VERSION 4u /* version of this interface */

/* ---- Structures */

/* A pose X_AB: a point p of B is rotation p + translation_m in A. */
typedef struct gaitslam_pose {
  double rotation[9]; /* row by row */
  double translation_m[3];
} gaitslam_pose; /* 96 bytes */

/* Lens models and their parameters; (x, y, z) is a point in the camera's frame. */
enum {
  /* u = u0 + uc / sqrt(1 + 2 k |uc|^2), uc = (fu x/z, fv y/z); parameter: k (1/px^2), 0: ideal pinhole */
  GAITSLAM_LENS_ONE_PARAMETER_RADIAL = 0,
  GAITSLAM_LENS_RADIAL_TANGENTIAL = 1, /* OpenCV's first four; parameters: k1 k2 p1 p2 */
  GAITSLAM_LENS_EQUIDISTANT = 2        /* OpenCV's fisheye; parameters: k1 k2 k3 k4 */
};

/* Known before the first observation. Lens and size are the head's gray camera's, as in gaitslam_lens. */
typedef struct gaitslam_start {
  uint32_t version; /* GAITSLAM_ESTIMATOR_VERSION */
  uint32_t lens;    /* one of GAITSLAM_LENS_... */
  uint32_t width_px, height_px;
  double focal_px[2], center_px[2], lens_parameters[4];
  gaitslam_pose X_CG;     /* inertial sensor in the camera's frame */
  gaitslam_pose X_WC;     /* camera at t = 0, as planned */
  uint64_t seed;          /* the run's seed, for reproducible random numbers */
  uint64_t options_bytes; /* length of the options */
} gaitslam_start;         /* 288 bytes */

/* A lens: one of GAITSLAM_LENS_... */
typedef struct gaitslam_lens {
  uint32_t model;
  uint32_t reserved;   /* 0 */
  double focal_px[2];  /* fu fv */
  double center_px[2]; /* u0 v0; the center of the first pixel is (0, 0) */
  double parameters[4];
} gaitslam_lens; /* 72 bytes */

enum {
  GAITSLAM_CAMERA_GRAY = 0,  /* images of GAITSLAM_PIXELS_GRAY8 */
  GAITSLAM_CAMERA_COLOR = 1, /* GAITSLAM_PIXELS_RGB8 */
  GAITSLAM_CAMERA_DEPTH = 2  /* GAITSLAM_PIXELS_DEPTH16 */
};

#define GAITSLAM_NAME_BYTES 48u /* size of a sensor's name: zero-terminated and padded with 0 */

/* A camera. Number 0 is the head's gray camera, whose frame is C. */
typedef struct gaitslam_camera {
  char name[GAITSLAM_NAME_BYTES];
  uint32_t kind;         /* one of GAITSLAM_CAMERA_... */
  uint32_t aligned_with; /* for depth: the camera with the same pixels and stamps; otherwise its own number */
  uint32_t width_px, height_px;
  gaitslam_lens lens;
  gaitslam_lens equidistant; /* the closest equidistant lens, for programs without its lens model */
  double equidistant_rms_px, equidistant_largest_px; /* difference of the two in px over the whole image */
  gaitslam_pose X_CK;
  double rate_hz;
  double readout_s;     /* from the middle of the first row's exposure to the last row's; 0: global shutter */
  double time_offset_s; /* how far its stamps are ahead of camera 0's */
  double nearest_m, furthest_m; /* for depth; otherwise 0 */
} gaitslam_camera;              /* 360 bytes */

/* An inertial sensor. Number 0 is in the chest, with separate gyro and accelerometer readings. */
typedef struct gaitslam_imu {
  char name[GAITSLAM_NAME_BYTES];
  gaitslam_pose X_CK;
  double rate_hz;
  double gyro_density, accelerometer_density; /* white noise, rad/s/sqrt(Hz) and m/s^2/sqrt(Hz) */
  double gyro_walk, accelerometer_walk;       /* bias, rad/s^2/sqrt(Hz) and m/s^3/sqrt(Hz); 0: constant */
  double gravity_m_s2;
  double time_offset_s; /* how far its stamps are ahead of camera 0's */
} gaitslam_imu;         /* 200 bytes */

/* A lidar. */
typedef struct gaitslam_lidar {
  char name[GAITSLAM_NAME_BYTES];
  gaitslam_pose X_CK;
  double rate_hz;       /* sweeps per second */
  double time_offset_s; /* how far its stamps are ahead of camera 0's */
  double nearest_m, furthest_m;
  double lowest_rad, highest_rad; /* elevation of its rays */
} gaitslam_lidar;                 /* 192 bytes */

enum {
  GAITSLAM_ENCODER = 0,     /* one value: the angle of its joint, rad; its zero may be off */
  GAITSLAM_FORCE_SENSOR = 1 /* six: force (N) and torque (N m) of the ground on its foot, axes of the sole (x
                               forward, y left, z up), about the point of the sole below the ankle */
};

/* An encoder or a force sensor. All are read at the same time. */
typedef struct gaitslam_body_sensor {
  char name[GAITSLAM_NAME_BYTES]; /* name of the joint, or of the foot: left, right */
  uint32_t kind;                  /* GAITSLAM_ENCODER or _FORCE_SENSOR */
  uint32_t value_count;           /* 1 or 6 */
  double rate_hz;
} gaitslam_body_sensor; /* 64 bytes */

/* Lengths of the lists of sensors in START. */
typedef struct gaitslam_sensor_counts {
  uint32_t cameras, imus, lidars; /* at least 1, 1, 0 */
  uint32_t body_sensors;          /* encoders, then force sensors; 0 for recordings without them */
} gaitslam_sensor_counts;         /* 16 bytes */

/* The mean over (begin_ns, end_ns] in the axes of G: angular velocity in rad/s, or specific force in m/s^2
 * (+g upward at rest). */
typedef struct gaitslam_reading {
  int64_t begin_ns, end_ns;
  double value[3];
} gaitslam_reading; /* 40 bytes */

enum { GAITSLAM_SUPPORT_BOTH = 0, GAITSLAM_SUPPORT_LEFT = 1, GAITSLAM_SUPPORT_RIGHT = 2 };

/* Planned motion of the camera at the stamp of the image. */
typedef struct gaitslam_plan {
  gaitslam_pose X_PC;
  double v_PC_C[3];  /* linear velocity of C in P, axes of C, m/s */
  double w_PC_C[3];  /* angular velocity of C in P, axes of C, rad/s */
  double p_CF[3];    /* planned sole of the support foot, or the middle of both soles, in C */
  uint32_t support;  /* one of GAITSLAM_SUPPORT_... */
  uint32_t reserved; /* 0 */
} gaitslam_plan;     /* 176 bytes */

/* The camera's pose at the stamp of the image, from leg odometry. */
typedef struct gaitslam_legs {
  gaitslam_pose X_OC; /* from encoders and loads; O equals W at the start and drifts from it as soles slip and
                         tilt */
  double p_CS[3];     /* the point of the soles that carries the robot, in C */
} gaitslam_legs;      /* 120 bytes */

/* The commanded velocity of the base, in its own heading. */
typedef struct gaitslam_command {
  int64_t t_ns; /* time of the command */
  double ahead_m_s, left_m_s, turn_rad_s;
} gaitslam_command; /* 32 bytes */

/* An image of camera 0 and the readings of IMU 0 since the previous one. Missing data has size or count 0. */
typedef struct gaitslam_observation {
  int64_t t_ns;                 /* the scenario may drop, duplicate or reorder stamps */
  uint32_t width_px, height_px; /* 0 0: the image is lost */
  uint32_t gyro_count, accelerometer_count;
  uint32_t has_plan, has_legs; /* each 1, or 0: `plan` or `legs` is all zero */
  gaitslam_plan plan;
  gaitslam_legs legs;
  uint32_t has_command; /* 1, or 0: `command` is all zero */
  uint32_t reserved;    /* 0 */
  gaitslam_command command;
} gaitslam_observation; /* 368 bytes */

enum {
  GAITSLAM_PIXELS_GRAY8 = 0,  /* one byte */
  GAITSLAM_PIXELS_RGB8 = 1,   /* three bytes: red, green, blue */
  GAITSLAM_PIXELS_DEPTH16 = 2 /* uint16_t: depth along the optical axis, mm; 0: none */
};

/* An image. Its rows are contiguous. */
typedef struct gaitslam_image {
  uint32_t camera;
  uint32_t pixels; /* one of GAITSLAM_PIXELS_... */
  uint32_t width_px, height_px;
  uint64_t row_bytes;
  int64_t t_ns;     /* middle of the exposure of its middle row */
  uint64_t at_byte; /* offset of the first pixel in the data; a multiple of 8 */
} gaitslam_image;   /* 40 bytes */

/* A sweep of a lidar. */
typedef struct gaitslam_sweep {
  uint32_t lidar;
  uint32_t point_count;
  int64_t t_ns;     /* start of the sweep */
  uint64_t at_byte; /* offset of the first gaitslam_point in the data; a multiple of 8 */
} gaitslam_sweep;   /* 24 bytes */

/* A point of a sweep in the lidar's frame at the time of the point. */
typedef struct gaitslam_point {
  float p_m[3];
  float intensity;   /* 0 to 1 */
  int32_t offset_ns; /* time since t_ns of the sweep */
} gaitslam_point;    /* 20 bytes */

/* A reading of an IMU other than number 0: means over (begin_ns, end_ns], in its axes. */
typedef struct gaitslam_imu_reading {
  uint32_t imu;
  uint32_t reserved; /* 0 */
  int64_t begin_ns, end_ns;
  double gyro[3];          /* rad/s */
  double accelerometer[3]; /* specific force, m/s^2 */
} gaitslam_imu_reading;    /* 72 bytes */

/* Numbers of all other sensor data since the previous observation, with the image of camera 0 again. The
 * data of each sensor are in chronological order. */
typedef struct gaitslam_rig_counts {
  uint32_t images, sweeps, imu_readings;
  uint32_t body_readings; /* of all encoders and force sensors, taken before the image of camera 0 */
} gaitslam_rig_counts;    /* 16 bytes */

enum {
  GAITSLAM_OK = 0,       /* tracking */
  GAITSLAM_LOST = 1,     /* lost, may recover */
  GAITSLAM_DIVERGED = 2, /* gave up; receives no more observations */
  GAITSLAM_NOT_READY = 3 /* not initialized yet */
};

/* The estimate after an observation. _LOST and _NOT_READY have no pose: t_ns, X_WC and covariance are
 * ignored. A pose older than the last one, such as the pose of a late observation, is not recorded. */
typedef struct gaitslam_answer {
  int64_t t_ns;    /* the pose's stamp: the observation's, or the last pose's if there is no new pose */
  uint32_t status; /* GAITSLAM_OK, _LOST, _DIVERGED or _NOT_READY */
  uint32_t has_covariance; /* 1, or 0: `covariance` is zero */
  gaitslam_pose X_WC;
  double covariance[36];   /* of (Log(R_estimate^T R_true) in axes C, rad; p_true - p_estimate in axes W, m),
                              row by row */
  uint32_t landmark_count; /* landmarks that follow: the whole map; 0: the map is unchanged */
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
 *     START        gaitslam_start, options, 1 to 8 zero bytes up to a multiple of 8, gaitslam_sensor_counts,
 *                  the cameras, IMUs, lidars and body sensors
 *     READY        gaitslam_ready, text
 *     OBSERVATION  gaitslam_observation, gyro_count readings, accelerometer_count readings, image of camera 0
 *                  (one byte per pixel, row by row), 0 to 7 zero bytes up to a multiple of 8,
 *                  gaitslam_rig_counts, the images, sweeps and IMU readings, the stamps of the body readings
 *                  (int64_t, ns), their values (double; of all body sensors for each stamp), pixels and
 *                  points. at_byte counts from the first byte after the header
 *     ANSWER       gaitslam_answer, landmark_count landmarks, cause
 *     END          nothing; the program exits
 *
 * GaitSLAM sends START, OBSERVATION and END; the program answers the first two with READY and ANSWER. Options
 * are text, one line "key=value" each. The result contains the program's output on standard error.
 * A program writes only one READY, and one ANSWER for each OBSERVATION, to its standard output. */
typedef struct gaitslam_header {
  char magic[4];   /* "GSLM" */
  uint32_t type;   /* one of GAITSLAM_MESSAGE_... */
  uint64_t bytes;  /* number of bytes that follow */
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

/* The lists of START. */
typedef struct gaitslam_sensors {
  gaitslam_sensor_counts counts;
  const gaitslam_camera* cameras;
  const gaitslam_imu* imus;
  const gaitslam_lidar* lidars;
  const gaitslam_body_sensor* body_sensors;
} gaitslam_sensors;

/* The lists of OBSERVATION. */
typedef struct gaitslam_rig {
  gaitslam_rig_counts counts;
  const gaitslam_image* images;
  const gaitslam_sweep* sweeps;
  const gaitslam_imu_reading* imu_readings;
  const int64_t* body_t_ns;
  const double* body_values; /* value k of reading i: body_values[i * n + k], n the sum of all value_count */
  const uint8_t* data;       /* at_byte of images and sweeps counts from here */
} gaitslam_rig;

/* Creates an estimator. Pointers are valid during the call. options: zero-terminated text, one line
 * "key=value" each, including those of the session (README.md). Returns NULL on failure, with the reason in
 * error[0 .. error_bytes - 1]. */
void* gaitslam_estimator_create(const gaitslam_start* start, const gaitslam_sensors* sensors,
                                const char* options, char* error, size_t error_bytes);

/* Processes an observation and fills in *answer, which starts with t_ns set, X_WC the identity and zeros
 * elsewhere. image: the image of camera 0, width_px * height_px bytes, row by row; NULL if it is lost.
 * *landmarks: answer->landmark_count of them; *cause: zero-terminated text. Both start as NULL, belong to the
 * estimator and must live until the next call. Returns 0, or another number if the estimator failed, with the
 * reason in *cause. */
int gaitslam_estimator_observe(void* estimator, const gaitslam_observation* observation,
                               const gaitslam_reading* gyro, const gaitslam_reading* accelerometer,
                               const uint8_t* image, const gaitslam_rig* rig, gaitslam_answer* answer,
                               const gaitslam_landmark** landmarks, const char** cause);

/* Frees the estimator at the end of the run. */
void gaitslam_estimator_destroy(void* estimator);

#ifdef __cplusplus
}
#endif

#endif /* GAITSLAM_ESTIMATOR_H */

/* ---- The program around these functions */

/* The framing of messages, for the programs of this file and of gaitslam_walker.h. */
#if (defined(GAITSLAM_ESTIMATOR_MAIN) || defined(GAITSLAM_WALKER_MAIN)) && !defined(GAITSLAM_HAS_FRAMING)
#define GAITSLAM_HAS_FRAMING

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

/* Reads a payload from `at`. `fine` becomes 0 if the payload is too short. */
typedef struct gaitslam_reader {
  const char* payload;
  uint64_t bytes, at;
  int fine;
} gaitslam_reader;

/* Returns `count` items. They are valid only if the reader is still fine. */
static const void* gaitslam_take(gaitslam_reader* from, uint64_t count, uint64_t item_bytes) {
  const char* const items = from->payload + from->at;
  const uint64_t left = from->at < from->bytes ? from->bytes - from->at : 0;
  from->fine =
      from->fine && count * item_bytes <= left; /* does not overflow: both fit in 32 bits, or count is 1 */
  if (from->fine) from->at += count * item_bytes;
  return items;
}
#define GAITSLAM_TAKE(type, count) ((const type*)gaitslam_take(from, count, sizeof(type)))

/* Copies the next bytes, or zeros if they are missing. */
static void gaitslam_copy(gaitslam_reader* from, void* to, size_t bytes) {
  const void* const next = gaitslam_take(from, 1, bytes);
  memset(to, 0, bytes);
  if (from->fine) memcpy(to, next, bytes);
}

/* Answers START and all further messages on standard input. The program's own output goes to standard error.
 * Returns its exit code: 0, 1 after a failure, 2 if the input is not these messages. */
static int gaitslam_serve(void* (*start)(gaitslam_reader*, int), int (*answer)(void*, gaitslam_reader*, int),
                          void (*destroy)(void*)) {
  const int out = dup(STDOUT_FILENO);
  gaitslam_header header;
  char* payload = NULL;
  void* program = NULL;
  int code = 1, fine = out >= 0 && dup2(STDERR_FILENO, STDOUT_FILENO) >= 0;
  setvbuf(stdout, NULL, _IOLBF, BUFSIZ); /* no printed line is lost in a crash */
  while (fine) {
    gaitslam_reader from = {NULL, 0, 0, 1};
    size_t bytes;
    fine = fread(&header, sizeof header, 1, stdin) == 1 && memcmp(header.magic, "GSLM", 4) == 0;
    if (!fine) {
      fprintf(stderr, "the standard input ends without END, or is not the messages of gaitslam\n");
      code = 2;
    }
    if (!fine || header.type == GAITSLAM_MESSAGE_END) break;
    free(payload);
    bytes = (size_t)header.bytes;
    payload = (char*)malloc(bytes ? bytes : 1);
    fine = payload && (bytes == 0 || fread(payload, bytes, 1, stdin) == 1);
    if (!fine) break;
    from.payload = payload, from.bytes = header.bytes;
    if (header.type == GAITSLAM_MESSAGE_START && !program)
      fine = (program = start(&from, out)) != NULL;
    else
      fine = header.type == GAITSLAM_MESSAGE_OBSERVATION && program && answer(program, &from, out);
  }
  free(payload);
  if (program) destroy(program);
  if (out >= 0) close(out);
  return fine ? 0 : code;
}

#endif

#if defined(GAITSLAM_ESTIMATOR_MAIN) && !defined(GAITSLAM_ESTIMATOR_HAS_MAIN)
#define GAITSLAM_ESTIMATOR_HAS_MAIN

static uint32_t gaitslam_body_values; /* values per body reading */

/* Reads the lists after the image of camera 0. */
static void gaitslam_read_rig(gaitslam_reader* from, gaitslam_rig* rig) {
  uint32_t i;
  from->at = (from->at + 7) / 8 * 8;
  gaitslam_copy(from, &rig->counts, sizeof rig->counts);
  rig->data = (const uint8_t*)from->payload;
  rig->images = GAITSLAM_TAKE(gaitslam_image, rig->counts.images);
  rig->sweeps = GAITSLAM_TAKE(gaitslam_sweep, rig->counts.sweeps);
  rig->imu_readings = GAITSLAM_TAKE(gaitslam_imu_reading, rig->counts.imu_readings);
  rig->body_t_ns = GAITSLAM_TAKE(int64_t, rig->counts.body_readings);
  rig->body_values =
      (const double*)gaitslam_take(from, rig->counts.body_readings, gaitslam_body_values * sizeof(double));
  for (i = 0; from->fine && i < rig->counts.images; ++i) {
    from->at = rig->images[i].at_byte;
    from->fine = rig->images[i].row_bytes <= UINT32_MAX;
    gaitslam_take(from, rig->images[i].height_px, rig->images[i].row_bytes);
  }
  for (i = 0; from->fine && i < rig->counts.sweeps; ++i) {
    from->at = rig->sweeps[i].at_byte;
    gaitslam_take(from, rig->sweeps[i].point_count, sizeof(gaitslam_point));
  }
}

/* Answers an observation. Returns 0 if the estimator failed or the message is invalid. */
static int gaitslam_answer_observation(void* estimator, gaitslam_reader* from, int out) {
  gaitslam_observation observation;
  gaitslam_rig rig;
  gaitslam_answer answer;
  const gaitslam_landmark* landmarks = NULL;
  const char* cause = NULL;
  const gaitslam_reading *gyro, *accelerometer;
  const uint8_t* image;
  size_t landmark_bytes;
  gaitslam_copy(from, &observation, sizeof observation);
  gyro = GAITSLAM_TAKE(gaitslam_reading, observation.gyro_count);
  accelerometer = GAITSLAM_TAKE(gaitslam_reading, observation.accelerometer_count);
  image = (const uint8_t*)gaitslam_take(from, observation.height_px, observation.width_px);
  gaitslam_read_rig(from, &rig);
  if (!from->fine) return 0;
  memset(&answer, 0, sizeof answer);
  answer.t_ns = observation.t_ns;
  answer.X_WC.rotation[0] = answer.X_WC.rotation[4] = answer.X_WC.rotation[8] = 1;
  if (gaitslam_estimator_observe(estimator, &observation, gyro, accelerometer,
                                 observation.width_px ? image : NULL, &rig, &answer, &landmarks, &cause)) {
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

/* Creates the estimator of a START and answers READY. Returns NULL on failure. */
static void* gaitslam_answer_start(gaitslam_reader* from, int out) {
  gaitslam_start start;
  gaitslam_sensors sensors;
  gaitslam_ready ready = {GAITSLAM_ESTIMATOR_VERSION, 0};
  char error[512] = "";
  const char* options;
  void* estimator = NULL;
  uint32_t i;
  gaitslam_copy(from, &start, sizeof start);
  options = (const char*)gaitslam_take(from, 1, start.options_bytes);
  from->at = (from->at + 8) / 8 * 8;
  gaitslam_copy(from, &sensors.counts, sizeof sensors.counts);
  sensors.cameras = GAITSLAM_TAKE(gaitslam_camera, sensors.counts.cameras);
  sensors.imus = GAITSLAM_TAKE(gaitslam_imu, sensors.counts.imus);
  sensors.lidars = GAITSLAM_TAKE(gaitslam_lidar, sensors.counts.lidars);
  sensors.body_sensors = GAITSLAM_TAKE(gaitslam_body_sensor, sensors.counts.body_sensors);
  for (i = 0; from->fine && i < sensors.counts.body_sensors; ++i)
    gaitslam_body_values += sensors.body_sensors[i].value_count;
  if (from->fine && start.version == GAITSLAM_ESTIMATOR_VERSION)
    estimator = gaitslam_estimator_create(&start, &sensors, options, error, sizeof error);
  error[sizeof error - 1] = '\0';
  if (!estimator && !error[0]) strcpy(error, "the estimator could not be created");
  ready.error_bytes = (uint32_t)strlen(error);
  if (gaitslam_begin(out, GAITSLAM_MESSAGE_READY, &ready, sizeof ready, ready.error_bytes))
    gaitslam_write(out, error, ready.error_bytes);
  return estimator;
}

int main(void) {
  return gaitslam_serve(gaitslam_answer_start, gaitslam_answer_observation, gaitslam_estimator_destroy);
}

#endif
