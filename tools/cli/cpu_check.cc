// Runs before anything else, built for any x86-64: the rest of the program needs x86-64-v3 and would die of
// an illegal instruction without a word.
#include <unistd.h>

#include <cstring>

#if defined(__x86_64__)
namespace {

__attribute__((constructor(101))) void refuse_older_processors() {
  __builtin_cpu_init();
  if (__builtin_cpu_supports("x86-64-v3")) return;
  const char* const message =
      "gaitslam: this processor lacks AVX2, FMA or BMI2; a processor of the level x86-64-v3 (2013 or later) "
      "is needed\n";
  const auto written = write(STDERR_FILENO, message, std::strlen(message));
  _exit(written < 0 ? 3 : 2);
}

}  // namespace
#endif
