/* A walking controller that holds the start posture until it misbehaves at its third sensor
 * message, or later with the option "after"; the option "fault" selects the fault. */
#include <math.h>

#define GAITSLAM_WALKER_MAIN
#include "sim/controllers/gaitslam_walker.h"

static char fault[64];
static int count = 0, after = 0;
static gaitslam_commanded_joint joints[2];
static gaitslam_joint first;

static int is(const char* name) { return strcmp(fault, name) == 0; }

/* A plan of a robot that stands at the origin. */
static gaitslam_walk_plan standing(void) {
  const gaitslam_pose origin = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
  gaitslam_walk_plan plan;
  memset(&plan, 0, sizeof plan);
  plan.X_PB = plan.X_PB_next = plan.X_PL = plan.X_PR = origin;
  return plan;
}

void* gaitslam_walker_create(const gaitslam_walk_start* start, const gaitslam_robot* robot,
                             gaitslam_walk_ready* ready, const gaitslam_commanded_joint** commanded,
                             char* error, size_t error_bytes) {
  int i;
  (void)start;
  sscanf(robot->options, "fault=%63s after=%d", fault, &after);
  first = robot->joints[0];
  for (i = 0; i < 2; ++i) {
    memcpy(joints[i].name, robot->joints[i].name, sizeof joints[i].name);
    joints[i].start_rad = robot->joints[i].start_rad;
  }
  ready->rate_hz = is("unfit_rate") ? 60 : is("no_rate") ? NAN : 100;
  ready->settle_s = is("long_settling") ? 1e9 : 0.1;
  ready->largest_vx_m_s = ready->largest_wz_rad_s = is("no_speeds") ? 0 : 0.5;
  ready->largest_vy_m_s = is("nan_speed") ? NAN : 0;
  ready->stands = is("wrong_flag") ? 2 : 1;
  ready->wants_path = 1;
  ready->has_plan = is("stays");
  ready->plan = standing();
  ready->joint_count = is("no_joints") ? 0 : 2;
  if (is("misspelt")) strcpy(joints[1].name, "left_kne");
  if (is("tab")) strcpy(joints[1].name, "left\tknee\x01");
  if (is("doubled")) memcpy(joints[1].name, joints[0].name, sizeof joints[1].name);
  if (is("start_beyond")) joints[0].start_rad = 9;
  if (is("other_version")) ready->version = 99;
  if (is("dies_at_start")) abort();
  *commanded = joints;
  if (!is("cannot_start")) return joints;
  strncpy(error, "no weights", error_bytes);
  return NULL;
}

int gaitslam_walker_step(void* walker, const gaitslam_walk_sensors* sensors, const double* q,
                         const double* dq, const double* torque, const void* rig, size_t rig_bytes,
                         gaitslam_walk_answer* answer, gaitslam_joint_command* commands, const char** cause) {
  int i;
  (void)walker, (void)q, (void)dq, (void)torque, (void)rig;
  for (i = 0; i < 2; ++i) {
    commands[i].q_rad = joints[i].start_rad;
    commands[i].kp_nm_rad = 100, commands[i].kd_nms_rad = 2;
  }
  answer->has_plan = is("stays");
  answer->plan = standing();
  if (sensors->vx_m_s > 0 && is("clips")) commands[0].q_rad = first.highest_rad + 1;
  if (is("echoes") && sensors->has_place) commands[0].torque_nm = sensors->place.x_m;
  if (is("echoes")) commands[1].torque_nm = (double)rig_bytes;
  if (++count < 3 + after) return 0;
  if (is("exit")) fprintf(stderr, "loading\nthe policy is broken\n"), exit(5);
  if (is("wrong_stamp")) answer->t_ns += 1;
  if (is("nan")) commands[1].torque_nm = NAN;
  if (is("hard")) commands[1].kp_nm_rad = 1e6;
  if (is("negative")) commands[0].kd_nms_rad = -1;
  if (is("wrong_status")) answer->status = 7;
  if (is("finishes")) answer->status = GAITSLAM_WALKER_FINISHED;
  if (is("not_ready")) answer->status = GAITSLAM_WALKER_NOT_READY;
  if (is("too_few")) answer->joint_count = 1;
  if (is("plan_comes")) answer->has_plan = 1;
  if (is("gives_up")) answer->status = GAITSLAM_WALKER_GAVE_UP, *cause = "the floor is lava";
  if (is("fails")) *cause = "no memory";
  return is("fails");
}

void gaitslam_walker_destroy(void* walker) {
  (void)walker;
  if (is("late")) exit(7);
}
