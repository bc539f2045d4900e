#include "sim/world/gl.h"

#include <dlfcn.h>

#include <cstdlib>
#include <stdexcept>
#include <string>

namespace sim::world {
namespace {

constexpr char kLibrary[] = "libOSMesa.so.8";

[[noreturn]] void fail() {
  const char* const why = dlerror();
  throw std::runtime_error(std::string("off-screen OpenGL: ") + (why ? why : kLibrary));
}

// One core draws. Mip levels are chosen approximately: faster, and corners are found as well.
void* opened() {
  setenv("LP_NUM_THREADS", "0", 1);
  setenv("GALLIVM_PERF", "rho_approx", 1);
  void* const library = dlopen(kLibrary, RTLD_NOW | RTLD_LOCAL);
  if (!library) fail();
  return library;
}

}  // namespace

void* Gl::function(const char* name) {
  static void* const library = opened();
  void* const found = dlsym(library, name);
  if (!found) fail();
  return found;
}

const Gl& gl() {
  static const Gl functions;
  return functions;
}

}  // namespace sim::world
