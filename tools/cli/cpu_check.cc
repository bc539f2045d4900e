// Runs first, compiled for any x86-64: the rest of the program needs x86-64-v3 and would end with an illegal
// instruction.
#include <unistd.h>

#include <cstring>

#if defined(__x86_64__)
namespace {

bool has_x86_64_v3() {
#if defined(__clang__)  // clang 14 does not know the level by its name
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
         __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("popcnt");
#else
  return __builtin_cpu_supports("x86-64-v3");
#endif
}

__attribute__((constructor(101))) void refuse_older_processors() {
  __builtin_cpu_init();
  if (has_x86_64_v3()) return;
  const char* const message =
      "gaitslam: this processor lacks AVX2, FMA or BMI2; a processor of the level x86-64-v3 (2013 or later) "
      "is needed\n";
  const auto written = write(STDERR_FILENO, message, std::strlen(message));
  _exit(written < 0 ? 3 : 2);
}

}  // namespace
#endif
