/* Interface of an external walking controller: a program that exchanges messages with GaitSLAM over its
 * standard input and output. C99; it needs gaitslam_estimator.h next to it, for the framing of messages, and
 * no other file of GaitSLAM.
 *
 * A controller receives the robot, the start and its options once. Then it receives the robot's sensors at
 * its own rate and answers each message with the servo commands that apply until the next answer. It never
 * receives a true pose or velocity.
 *
 * All numbers are little-endian. The structures have no padding. Lengths are in m, angles in rad, torques in
 * N m, times in ns. Frames: B the base (x forward, y left, z up), G its inertial sensor (the same axes at the
 * start posture unless X_BG differs), P the world of the controller's own plan: under the base at the start,
 * x forward, z up.
 *
 * In C or C++, define the three functions under "Functions"; this file supplies main():
 *     cc -DGAITSLAM_WALKER_MAIN -o mine mine.c -lm
 * In another language, read and write the messages under "Messages". */
#ifndef GAITSLAM_WALKER_H
#define GAITSLAM_WALKER_H

#include "gaitslam_estimator.h"

#ifdef __cplusplus
extern "C" {
#endif

#define GAITSLAM_WALKER_VERSION 2u /* version of this interface */

/* ---- Structures */

/* First structure of START. */
typedef struct gaitslam_walk_start {
  uint32_t version; /* GAITSLAM_WALKER_VERSION */
  uint32_t joint_count;
  int64_t tick_ns; /* shortest period of SENSORS: 5 ms */
  double gravity_m_s2;
  uint64_t seed;          /* the run's seed, for reproducible random numbers */
  uint64_t options_bytes; /* lengths of the texts */
  uint64_t walk_bytes;
  uint64_t model_bytes;
} gaitslam_walk_start; /* 56 bytes */

/* A joint with a motor. Unknown limits are infinite. */
typedef struct gaitslam_joint {
  char name[GAITSLAM_NAME_BYTES];
  double axis[3]; /* in the axes of its link */
  double lowest_rad, highest_rad;
  double effort_nm, speed_rad_s;
  double armature_kg_m2, damping_nms_rad; /* damping: passive */
  double start_rad;                       /* angle in the robot's start posture */
  double kp_nm_rad, kd_nms_rad;           /* gains of the robot's own servo */
} gaitslam_joint;                         /* 144 bytes */

/* The inertial sensor, or a foot: the sole's point below the ankle. */
typedef struct gaitslam_part {
  char name[GAITSLAM_NAME_BYTES]; /* imu, left, right */
  gaitslam_pose X_BK;             /* in the base, in the start posture */
  uint32_t measures_wrench;       /* for a foot: 1; 0: its wrench is computed from the leg's torques */
  uint32_t reserved;              /* 0 */
} gaitslam_part;                  /* 152 bytes */

/* The controller's own plan, which the estimator receives as the plan of the walk. */
typedef struct gaitslam_walk_plan {
  gaitslam_pose X_PB, X_PB_next; /* base at the stamp, and when the next SENSORS are due */
  gaitslam_pose X_PL, X_PR;      /* left and right sole */
  double v_PB_P[3];              /* velocity of the base's origin in P, m/s */
  double yaw_rate_rad_s;
  uint32_t support;   /* one of GAITSLAM_SUPPORT_... */
  uint32_t reserved;  /* 0 */
} gaitslam_walk_plan; /* 424 bytes */

/* Requirements and capabilities of the controller. */
typedef struct gaitslam_walk_ready {
  uint32_t version;     /* GAITSLAM_WALKER_VERSION of the program */
  uint32_t error_bytes; /* length of the text that ends the message: why it cannot start; 0 if it can */
  double rate_hz;       /* rate of SENSORS: its period must be a multiple of tick_ns */
  double settle_s; /* time before the walk: the base is held and lowered to the floor during its first half.
                      0: the robot stands from the start and settles until it is at rest */
  double largest_vx_m_s, largest_vy_m_s, largest_wz_rad_s; /* top speeds in both directions */
  double duration_s;                                       /* with plans: duration of the walk; 0: unknown */
  uint32_t stands;      /* 1: it stands still on command. 0: it marches in place */
  uint32_t plans;       /* 1: it carries out the commands of the walk text by itself and finishes */
  uint32_t wants_path;  /* 1: SENSORS contain the path ahead */
  uint32_t has_plan;    /* 1: `plan` is the plan at the start, with the base's start pose */
  uint32_t joint_count; /* number of gaitslam_commanded_joint that follow */
  uint32_t slopes;      /* 1: it adapts to slopes, so the floor of its plan is not known to be level */
  uint32_t wants_rig;   /* 1: SENSORS contain the observations of the head's camera and the rig */
  uint32_t reserved;    /* 0 */
  gaitslam_walk_plan plan;
} gaitslam_walk_ready; /* 512 bytes */

/* A joint that the controller commands. The robot's own servos keep the others in the start posture. */
typedef struct gaitslam_commanded_joint {
  char name[GAITSLAM_NAME_BYTES];
  double start_rad;         /* its angle at the start */
} gaitslam_commanded_joint; /* 56 bytes */

enum {
  GAITSLAM_WALK_SETTLE = 0, /* before the walk: stand or march in place. t_ns restarts when the walk starts */
  GAITSLAM_WALK_STAND = 1,
  GAITSLAM_WALK_GO = 2,  /* at the commanded velocity */
  GAITSLAM_WALK_STOP = 3 /* the commands have ended */
};

#define GAITSLAM_PATH_POINTS 4u /* 0.25, 0.5, 1 and 2 s ahead */

/* Force and torque of the ground on a foot, in the sole's axes, about its point below the ankle. */
typedef struct gaitslam_wrench {
  double force_n[3], torque_nm[3];
} gaitslam_wrench; /* 48 bytes */

/* The newest estimate of the base's place, in W (under the base at the start). */
typedef struct gaitslam_walk_place {
  int64_t t_ns; /* time of the image from which it was estimated */
  double x_m, y_m, yaw_rad;
  double covariance[9]; /* of x, y (axes of W) and yaw, by rows; 0: unknown */
} gaitslam_walk_place;  /* 104 bytes */

/* Readings of the robot's own sensors: means over the last tick, with the robot's noise. */
typedef struct gaitslam_walk_sensors {
  int64_t t_ns;
  uint32_t command; /* one of GAITSLAM_WALK_... */
  uint32_t joint_count;
  double vx_m_s, vy_m_s, wz_rad_s; /* commanded, in the heading of the base. With STAND and STOP: 0, or what
                                      keeps a steered robot that marches in place */
  double path[GAITSLAM_PATH_POINTS][3]; /* x, y, yaw in the heading of the base, as far as known */
  double gyro_rad_s[3];                 /* axes G */
  double accelerometer_m_s2[3];         /* specific force, axes G */
  double up_B[3];                       /* estimated vertical in the base's axes: tilt without heading */
  gaitslam_wrench left, right;
  double velocity_m_s[3]; /* of the base, axes B: by the legs, mean since the last SENSORS */
  double velocity_sigma_m_s[3];
  uint32_t has_place; /* 1, if the walk is steered by estimates and there is one; otherwise 0 */
  uint32_t reserved;  /* 0 */
  gaitslam_walk_place place;
} gaitslam_walk_sensors; /* 464 bytes */

enum {
  GAITSLAM_WALKER_OK = 0,
  GAITSLAM_WALKER_NOT_READY = 1, /* only while settling: the robot holds the start posture */
  GAITSLAM_WALKER_GAVE_UP = 2,   /* with a cause; the run ends */
  GAITSLAM_WALKER_FINISHED = 3   /* only with plans: the walk ends a tick after this answer */
};

/* Answer to SENSORS. */
typedef struct gaitslam_walk_answer {
  int64_t t_ns;         /* t_ns of SENSORS */
  uint32_t status;      /* one of GAITSLAM_WALKER_... */
  uint32_t has_plan;    /* 1, or 0: `plan` is unused */
  uint32_t joint_count; /* as in READY; 0 with NOT_READY and GAVE_UP */
  uint32_t cause_bytes; /* length of the text after the joints */
  gaitslam_walk_plan plan;
} gaitslam_walk_answer; /* 448 bytes */

/* Command of a servo until the next answer: torque_nm + kp (q_rad - q) + kd (dq_rad_s - dq), at each step
 * of the physics and within the joint's effort limit. Angles beyond the joint's range are clipped. If the
 * walking controller answers every 5 ms, the target moves at dq_rad_s, and q_rad is its mean over the tick.
 */
typedef struct gaitslam_joint_command {
  double q_rad, dq_rad_s, kp_nm_rad, kd_nms_rad, torque_nm;
} gaitslam_joint_command; /* 40 bytes */

/* Limits of an answer: gains are finite, not negative and at most these. */
#define GAITSLAM_MOST_KP 1e5
#define GAITSLAM_MOST_KD 1e4

/* ---- Messages
 *
 * Headers and types as in gaitslam_estimator.h; SENSORS has the type of OBSERVATION:
 *
 *     START    gaitslam_walk_start, the joints, 3 gaitslam_part (imu, left, right foot), and three texts with
 *              a zero byte after each: options (lines "key=value"), walk (YAML), model (the robot as MJCF)
 *     READY    gaitslam_walk_ready, the commanded joints, text. If there is a text, the rest may be left out
 *     SENSORS  gaitslam_walk_sensors, then q, dq and torque of all joints (double), then, with wants_rig,
 *              whole messages as an estimator gets them (gaitslam_estimator.h): START first, with the list of
 *              the sensors, then each OBSERVATION once its image is complete, without sensor errors
 *     ANSWER   gaitslam_walk_answer, the commands of the joints in the order of READY, cause
 *     END      nothing; the program exits
 *
 * The walk text is a scenario with the robot, the commands, and the built-in controller's keys in walk and
 * stabilizer. All other keys have their defaults. */
enum { GAITSLAM_MESSAGE_SENSORS = GAITSLAM_MESSAGE_OBSERVATION };

/* ---- Functions */

/* The lists and texts of START. */
typedef struct gaitslam_robot {
  const gaitslam_joint* joints;
  const gaitslam_part *imu, *left, *right;
  const char *options, *walk, *model; /* zero-terminated */
} gaitslam_robot;

/* Creates a controller. Pointers are valid during the call. Fills in *ready, which starts with the version
 * set, zeros and zero poses, and *commanded: ready->joint_count joints, which must live as long as the
 * controller. Returns NULL on failure, with the reason in error[0 .. error_bytes - 1]. */
void* gaitslam_walker_create(const gaitslam_walk_start* start, const gaitslam_robot* robot,
                             gaitslam_walk_ready* ready, const gaitslam_commanded_joint** commanded,
                             char* error, size_t error_bytes);

/* Answers the sensors; q, dq, torque: of all joints in START; rig: rig_bytes of messages. *answer starts with
 * t_ns and joint_count set and zeros elsewhere, commands[0 .. joint_count - 1] with zeros. *cause:
 * zero-terminated text, owned by the controller. Returns 0 on success; otherwise the reason is in *cause. */
int gaitslam_walker_step(void* walker, const gaitslam_walk_sensors* sensors, const double* q,
                         const double* dq, const double* torque, const void* rig, size_t rig_bytes,
                         gaitslam_walk_answer* answer, gaitslam_joint_command* commands, const char** cause);

/* Frees the controller at the end of the run. */
void gaitslam_walker_destroy(void* walker);

#ifdef __cplusplus
}
#endif

#endif /* GAITSLAM_WALKER_H */

/* ---- The program around these functions */

#if defined(GAITSLAM_WALKER_MAIN) && !defined(GAITSLAM_WALKER_HAS_MAIN)
#define GAITSLAM_WALKER_HAS_MAIN

#include "gaitslam_estimator.h" /* the framing, if it was included without it */

static uint32_t gaitslam_commanded_count;

/* Answers SENSORS. Returns 0 if the controller failed or the message is invalid. */
static int gaitslam_answer_sensors(void* walker, gaitslam_reader* from, int out) {
  gaitslam_walk_sensors sensors;
  gaitslam_walk_answer answer;
  gaitslam_joint_command* commands;
  const double *q, *dq, *torque;
  const char* cause = NULL;
  size_t bytes;
  int fine;
  gaitslam_copy(from, &sensors, sizeof sensors);
  q = GAITSLAM_TAKE(double, sensors.joint_count);
  dq = GAITSLAM_TAKE(double, sensors.joint_count);
  torque = GAITSLAM_TAKE(double, sensors.joint_count);
  if (!from->fine) return 0;
  memset(&answer, 0, sizeof answer);
  answer.t_ns = sensors.t_ns;
  answer.joint_count = gaitslam_commanded_count;
  commands = (gaitslam_joint_command*)calloc(gaitslam_commanded_count + 1, sizeof *commands);
  fine = commands && !gaitslam_walker_step(walker, &sensors, q, dq, torque, from->payload + from->at,
                                           (size_t)(from->bytes - from->at), &answer, commands, &cause);
  if (!cause) cause = "";
  if (!fine) fprintf(stderr, "%s\n", *cause ? cause : "the controller failed");
  if (answer.status == GAITSLAM_WALKER_NOT_READY || answer.status == GAITSLAM_WALKER_GAVE_UP)
    answer.joint_count = 0;
  answer.cause_bytes = 0;
  while (cause[answer.cause_bytes] && answer.cause_bytes < GAITSLAM_MOST_TEXT_BYTES) ++answer.cause_bytes;
  bytes = answer.joint_count * sizeof *commands;
  fine = fine && answer.joint_count <= gaitslam_commanded_count &&
         gaitslam_begin(out, GAITSLAM_MESSAGE_ANSWER, &answer, sizeof answer, bytes + answer.cause_bytes) &&
         gaitslam_write(out, commands, bytes) && gaitslam_write(out, cause, answer.cause_bytes);
  free(commands);
  return fine;
}

/* Creates the controller of a START and answers READY. Returns NULL on failure. */
static void* gaitslam_start_walker(gaitslam_reader* from, int out) {
  gaitslam_walk_start start;
  gaitslam_walk_ready ready;
  gaitslam_robot robot;
  const gaitslam_commanded_joint* commanded = NULL;
  char error[512] = "";
  size_t bytes;
  void* walker = NULL;
  memset(&ready, 0, sizeof ready);
  ready.version = GAITSLAM_WALKER_VERSION;
  gaitslam_copy(from, &start, sizeof start);
  robot.joints = GAITSLAM_TAKE(gaitslam_joint, start.joint_count);
  robot.imu = GAITSLAM_TAKE(gaitslam_part, 3);
  robot.left = robot.imu + 1, robot.right = robot.imu + 2;
  robot.options = (const char*)gaitslam_take(from, 1, start.options_bytes + 1);
  robot.walk = (const char*)gaitslam_take(from, 1, start.walk_bytes + 1);
  robot.model = (const char*)gaitslam_take(from, 1, start.model_bytes + 1);
  if (from->fine && start.version == GAITSLAM_WALKER_VERSION)
    walker = gaitslam_walker_create(&start, &robot, &ready, &commanded, error, sizeof error);
  error[sizeof error - 1] = '\0';
  if (!walker && !error[0]) strcpy(error, "the controller could not be created");
  gaitslam_commanded_count = commanded ? ready.joint_count : 0;
  ready.joint_count = gaitslam_commanded_count;
  ready.error_bytes = (uint32_t)strlen(error);
  bytes = gaitslam_commanded_count * sizeof *commanded;
  if (gaitslam_begin(out, GAITSLAM_MESSAGE_READY, &ready, sizeof ready, bytes + ready.error_bytes) &&
      gaitslam_write(out, commanded, bytes))
    gaitslam_write(out, error, ready.error_bytes);
  return walker;
}

int main(void) {
  return gaitslam_serve(gaitslam_start_walker, gaitslam_answer_sensors, gaitslam_walker_destroy);
}

#endif
