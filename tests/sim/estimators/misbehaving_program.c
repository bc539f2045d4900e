/* An estimator that answers the start pose to every observation, until it misbehaves as its first argument
 * says at the message whose number is its second argument: 0 for the start, 1 for the first observation. */
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "sim/estimators/gaitslam_estimator.h"

static const char* behaviour = "";

static int is(const char* name) { return strcmp(behaviour, name) == 0; }

static void give(const void* bytes, size_t count) {
  if (count > 0 && fwrite(bytes, count, 1, stdout) != 1) exit(3);
}

static void give_header(uint32_t type, uint64_t bytes) {
  gaitslam_header header = {{'G', 'S', 'L', 'M'}, 0, 0};
  header.type = type;
  header.bytes = bytes;
  if (is("wrong_type")) header.type = 77;
  if (is("huge_length")) header.bytes = UINT64_MAX;
  if (is("wrong_magic")) memcpy(header.magic, "JUNK", 4);
  give(&header, sizeof header);
}

/* What needs no answer to go wrong. */
static void misbehave_before(void) {
  int i;
  if (is("crash")) abort();
  if (is("killed")) raise(SIGKILL);
  if (is("exit")) exit(5);
  if (is("end")) exit(0);
  if (is("hang")) pause();
  if (is("grandchild") && fork() >= 0) pause();
  if (is("says_why")) fprintf(stderr, "first\nthe map is broken\n"), exit(1);
  if (is("prints")) printf("Loading the vocabulary, please wait ...\n"), fflush(stdout), pause();
  if (is("closes_output")) fclose(stdout), close(1), pause();
  if (is("floods_error"))
    for (i = 0; i < 30000; ++i)
      fprintf(
          stderr,
          "%08d: a line of one hundred bytes or so, which nobody needs to read, but which is kept in part\n",
          i);
  if (is("floods_output"))
    for (;;) give(&behaviour, sizeof behaviour);
}

static void give_answer(gaitslam_answer answer) {
  gaitslam_landmark landmark;
  size_t bytes = sizeof answer;
  memset(&landmark, 0, sizeof landmark);
  if (is("nan")) answer.X_WC.translation_m[1] = NAN;
  if (is("no_rotation")) answer.X_WC.rotation[0] = 2;
  if (is("nan_covariance")) answer.has_covariance = 1, answer.covariance[7] = NAN;
  if (is("not_symmetric")) answer.has_covariance = 1, answer.covariance[1] = 1;
  if (is("wrong_flag")) answer.has_covariance = 3;
  if (is("wrong_status")) answer.status = 9;
  if (is("future")) answer.t_ns += 1;
  if (is("past")) answer.t_ns = -1;
  if (is("huge_counts")) answer.landmark_count = UINT32_MAX;
  if (is("huge_cause")) answer.cause_bytes = UINT32_MAX;
  if (is("counts_that_overflow")) answer.landmark_count = 0x80000000u, answer.cause_bytes = 1u << 30;
  if (is("short")) bytes = 100;
  if (is("gives_up")) answer.status = GAITSLAM_DIVERGED, answer.cause_bytes = 7;
  if (is("nan_landmark")) landmark.p_W_m[0] = NAN;
  if (is("maps") || is("nan_landmark")) answer.landmark_count = 1;
  if (is("maps")) landmark.id = 42, landmark.p_W_m[2] = 1.5;
  give_header(GAITSLAM_MESSAGE_ANSWER,
              bytes + (is("gives_up") ? 7 : 0) + (answer.landmark_count == 1 ? sizeof landmark : 0));
  if (is("cut_off")) give(&answer, 100), exit(0);
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

int main(int argc, char** argv) {
  static char payload[1 << 22];
  const int when = argc > 2 ? atoi(argv[2]) : 0;
  gaitslam_header header;
  gaitslam_start start;
  int count = -1;
  memset(&start, 0, sizeof start);
  while (fread(&header, sizeof header, 1, stdin) == 1 && header.type != GAITSLAM_MESSAGE_END) {
    gaitslam_answer answer;
    if (header.bytes > sizeof payload || (header.bytes > 0 && fread(payload, header.bytes, 1, stdin) != 1))
      return 4;
    if (++count == when) behaviour = argc > 1 ? argv[1] : "";
    if (count == 0) memcpy(&start, payload, sizeof start);
    misbehave_before();
    if (count == 0) {
      give_ready();
    } else {
      memset(&answer, 0, sizeof answer);
      memcpy(&answer.t_ns, payload, sizeof answer.t_ns);
      answer.X_WC = start.X_WC;
      give_answer(answer);
    }
    behaviour = "";
    fflush(stdout);
  }
  return 0;
}
