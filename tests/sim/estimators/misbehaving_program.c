/* An estimator that answers with the start pose until it misbehaves: argument 1 names the fault, argument 2
 * is the number of the message (0 for the start, 1 for the first observation). With argument 3, "header", it
 * runs as a program made by gaitslam_estimator.h. */
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define main header_main
#include "sim/estimators/gaitslam_estimator.h"
#undef main

static const char* behavior = "";
static const char* planned_behavior = "";
static int when = 0, message = -1;
static gaitslam_start start;
static uint32_t value_count = 0; /* values in a reading of the body */

static int is(const char* name) { return strcmp(behavior, name) == 0; }
static void next_message(void) { behavior = ++message == when ? planned_behavior : ""; }

static void give(const void* bytes, size_t count) {
  if (count > 0 && fwrite(bytes, count, 1, stdout) != 1) exit(3);
}

static void give_header(uint32_t type, uint64_t bytes) {
  gaitslam_header header = {{'G', 'S', 'L', 'M'}, 0, 0};
  header.type = type;
  header.bytes = bytes;
  if (is("wrong_type")) header.type = 77;
  if (is("huge_length")) header.bytes = UINT64_MAX;
  give(&header, sizeof header);
}

/* Misbehaves before the answer. */
static void misbehave(void) {
  int i;
  if (is("crash")) abort();
  if (is("killed")) raise(SIGKILL);
  if (is("exit")) exit(5);
  if (is("hang")) pause();
  if (is("sleeps")) usleep(50000);
  if (is("grandchild") && fork() >= 0) pause();
  if (is("leaves_child") && fork() > 0) exit(5);
  if (is("leaves_child")) pause();
  if (is("colored")) fprintf(stderr, "\033[1;31merror\033[m: no map\n"), exit(1);
  if (is("no_input")) {
    give("junk junk junk j", 16), fflush(stdout);
    if (read(0, &i, 1) == 0) fprintf(stderr, "no input\n"), exit(1);
  }
  if (is("gives_cause")) fprintf(stderr, "first\nthe map is broken\n"), exit(1);
  if (is("prints")) printf("Loading the vocabulary, please wait ...\n"), fflush(stdout), pause();
  if (is("closes_output")) fclose(stdout), close(1), pause();
  if (is("floods_error"))
    for (i = 0; i < 30000; ++i)
      fprintf(stderr, "%08d: a line of one hundred bytes that the result keeps only in part.... %20d\n", i,
              i);
}

/* Like OpenVINS: not ready at first, identity while lost, a stamp twice, a covariance missing once. */
static void answer_like_openvins(gaitslam_answer* answer) {
  static int64_t last_ns;
  int i;
  answer->has_covariance = message != 6;
  for (i = 0; i < 36 && message != 6; i += 7) answer->covariance[i] = 1e-4;
  if (message <= 2) answer->status = GAITSLAM_NOT_READY, answer->X_WC.translation_m[0] = NAN;
  if (message == 3) last_ns = answer->t_ns;
  if (message == 4) answer->status = GAITSLAM_LOST, memset(answer->X_WC.translation_m, 0, 24);
  if (message == 5) answer->t_ns = last_ns;
}

static void give_answer(gaitslam_answer answer) {
  gaitslam_landmark landmark;
  size_t bytes = sizeof answer;
  memset(&landmark, 0, sizeof landmark);
  if (is("nan")) fprintf(stderr, "the scale is 0\n"), answer.X_WC.translation_m[1] = NAN;
  if (is("no_rotation")) answer.X_WC.rotation[0] = 2;
  if (is("nan_covariance")) answer.has_covariance = 1, answer.covariance[7] = NAN;
  if (is("not_symmetric")) answer.has_covariance = 1, answer.covariance[1] = 1;
  if (is("wrong_flag")) answer.has_covariance = 3;
  if (is("wrong_status")) answer.status = 9;
  if (is("future")) answer.t_ns += 1;
  if (is("past")) answer.t_ns = -1;
  if (strcmp(planned_behavior, "openvins") == 0) answer_like_openvins(&answer);
  if (is("huge_counts")) answer.landmark_count = UINT32_MAX;
  if (is("huge_cause")) answer.cause_bytes = UINT32_MAX;
  if (is("short")) bytes = 100;
  if (is("gives_up")) answer.status = GAITSLAM_DIVERGED, answer.cause_bytes = 7;
  if (is("nan_landmark")) landmark.p_W_m[0] = NAN;
  if (is("maps") || is("nan_landmark")) answer.landmark_count = 1;
  if (is("maps")) landmark.id = 42, landmark.p_W_m[2] = 1.5;
  give_header(GAITSLAM_MESSAGE_ANSWER,
              bytes + (is("gives_up") ? 7 : 0) + (answer.landmark_count == 1 ? sizeof landmark : 0));
  if (is("cut_off")) give(&answer, 100), exit(0);
  if (is("half")) give(&answer, 100), fflush(stdout), pause();
  give(&answer, bytes);
  if (answer.landmark_count == 1) give(&landmark, sizeof landmark);
  if (is("gives_up")) give("no\nluck", 7);
}

static void give_ready(void) {
  gaitslam_ready ready = {GAITSLAM_ESTIMATOR_VERSION, 0};
  const char* error = is("cannot_start") ? "no vocabulary" : "";
  if (is("wrong_version")) ready.version = 99;
  ready.error_bytes = (uint32_t)strlen(error);
  give_header(GAITSLAM_MESSAGE_READY, sizeof ready + strlen(error));
  give(&ready, sizeof ready);
  give(error, strlen(error));
}

static void describe(const gaitslam_rig* rig) {
  uint32_t i;
  gaitslam_point last;
  for (i = 0; i < rig->counts.images; ++i) {
    const gaitslam_image* image = &rig->images[i];
    printf("camera %u: %u px of kind %u, %u bytes a row, at %lld ns: %u\n", image->camera, image->width_px,
           image->pixels, (unsigned)image->row_bytes, (long long)image->t_ns, rig->data[image->at_byte]);
  }
  for (i = 0; i < rig->counts.sweeps; ++i) {
    memcpy(&last, rig->data + rig->sweeps[i].at_byte + (rig->sweeps[i].point_count - 1) * sizeof last,
           sizeof last);
    printf("lidar %u: %g, %g, %d ns\n", rig->sweeps[i].lidar, last.p_m[2], last.intensity, last.offset_ns);
  }
  for (i = 0; i < rig->counts.imu_readings; ++i)
    printf("imu %u: %g %g\n", rig->imu_readings[i].imu, rig->imu_readings[i].gyro[1],
           rig->imu_readings[i].accelerometer[2]);
}

/* A line for each reading of the body: its stamp and values. */
static void echo(const gaitslam_rig* rig) {
  uint32_t i, k;
  for (i = 0; i < rig->counts.body_readings; ++i) {
    printf("%lld", (long long)rig->body_t_ns[i]);
    for (k = 0; k < value_count; ++k) printf(",%.17g", rig->body_values[i * value_count + k]);
    printf("\n");
  }
}

void* gaitslam_estimator_create(const gaitslam_start* given, const gaitslam_sensors* sensors,
                                const char* options, char* error, size_t error_bytes) {
  (void)options, (void)error, (void)error_bytes;
  uint32_t i;
  next_message(), misbehave();
  for (i = 0; i < sensors->counts.cameras && strcmp(planned_behavior, "describes") == 0; ++i)
    printf("%s of %s, %u px\n", sensors->cameras[i].name,
           sensors->cameras[sensors->cameras[i].aligned_with].name, sensors->cameras[i].width_px);
  for (i = 0; i < sensors->counts.body_sensors; ++i) {
    value_count += sensors->body_sensors[i].value_count;
    if (strcmp(planned_behavior, "echoes") == 0) printf("%s ", sensors->body_sensors[i].name);
  }
  if (strcmp(planned_behavior, "echoes") == 0) printf("%u\n", value_count);
  start = *given;
  return &start;
}

int gaitslam_estimator_observe(void* estimator, const gaitslam_observation* observation,
                               const gaitslam_reading* gyro, const gaitslam_reading* accelerometer,
                               const uint8_t* image, const gaitslam_rig* rig, gaitslam_answer* answer,
                               const gaitslam_landmark** landmarks, const char** cause) {
  (void)estimator, (void)observation, (void)gyro, (void)accelerometer, (void)image, (void)landmarks;
  next_message();
  if (is("describes")) describe(rig);
  if (strcmp(planned_behavior, "echoes") == 0) echo(rig);
  answer->X_WC = start.X_WC;
  if (is("print") || is("print_and_crash")) printf("printed by the estimator\n");
  if (is("print_and_crash")) abort();
  if (is("huge_counts")) answer->landmark_count = 3000000000u;
  if (is("no_landmarks")) answer->landmark_count = 3;
  *cause = "the map is broken";
  return is("fails");
}

void gaitslam_estimator_destroy(void* estimator) { (void)estimator; }

int main(int argc, char** argv) {
  static char payload[1 << 22];
  gaitslam_header header;
  if (argc > 1) planned_behavior = argv[1];
  if (argc > 2) when = atoi(argv[2]);
  if (argc > 3) return header_main();
  while (fread(&header, sizeof header, 1, stdin) == 1 && header.type != GAITSLAM_MESSAGE_END) {
    gaitslam_answer answer;
    if (header.bytes > sizeof payload || (header.bytes > 0 && fread(payload, header.bytes, 1, stdin) != 1))
      return 4;
    next_message();
    if (message == 0) memcpy(&start, payload, sizeof start);
    misbehave();
    if (message == 0) {
      give_ready();
    } else {
      memset(&answer, 0, sizeof answer);
      memcpy(&answer.t_ns, payload, sizeof answer.t_ns);
      answer.X_WC = start.X_WC;
      give_answer(answer);
      if (is("twice_later")) fflush(stdout), usleep(20000);
      if (is("twice") || is("twice_later")) give_answer(answer);
    }
    if (is("chats")) printf("I have seen it\n");
    fflush(stdout);
  }
  return 0;
}
