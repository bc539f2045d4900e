#include "sim/world/gl_context.h"

#include <dlfcn.h>

#include <cstdlib>
#include <stdexcept>

namespace sim::world {
namespace {

constexpr int kWindowPx = 8;

[[noreturn]] void fail(const char* why) {
  throw std::runtime_error(std::string("off-screen OpenGL: ") + why);
}

// MuJoCo looks for EGL first; a process that has it loaded would get functions that do not belong to OSMesa.
void refuse_other_platforms() {
  if (dlsym(RTLD_DEFAULT, "eglGetProcAddress"))
    fail("libEGL is loaded in this process and would shadow OSMesa");
}

// One core draws. Mip levels are chosen approximately: faster, and corners are found as well.
void prepare_renderer() {
  setenv("LP_NUM_THREADS", "0", 1);
  setenv("GALLIVM_PERF", "rho_approx", 1);
}

// A shallow copy with the rendering quality that is needed: flat faces are lit by directional lights, so one
// quad is enough; round shapes of few stacks save a tenth of a frame (cylinders need one, leaves are thin).
mjModel with_buffer(const mjModel& model, int width, int height, int samples) {
  mjModel copy = model;
  copy.vis.global.offwidth = width;
  copy.vis.global.offheight = height;
  copy.vis.quality.offsamples = samples;
  copy.vis.quality.numquads = 1;
  copy.vis.quality.numslices = 20;
  copy.vis.quality.numstacks = 6;
  return copy;
}

}  // namespace

GlContext::GlContext(const mjModel& model, int width, int height, int samples)
    : window_(4 * kWindowPx * kWindowPx) {
  refuse_other_platforms();
  prepare_renderer();
  context_.reset(OSMesaCreateContextExt(OSMESA_RGBA, 24, 8, 0, nullptr));
  if (!context_) fail("OSMesa gives no context");
  if (!OSMesaMakeCurrent(context_.get(), window_.data(), GL_UNSIGNED_BYTE, kWindowPx, kWindowPx))
    fail("OSMesa's context cannot be made current");
  const mjModel copy = with_buffer(model, width, height, samples);
  mjr_defaultContext(&mjr_);
  mjr_makeContext(&copy, &mjr_, mjFONTSCALE_100);
  make_current();
  if (mjr_.offWidth != width || mjr_.offHeight != height) fail("the off-screen buffer has another size");
}

GlContext::~GlContext() {
  OSMesaMakeCurrent(context_.get(), window_.data(), GL_UNSIGNED_BYTE, kWindowPx, kWindowPx);
  mjr_freeContext(&mjr_);
}

void GlContext::make_current() {
  if (OSMesaGetCurrentContext() != context_.get() &&
      !OSMesaMakeCurrent(context_.get(), window_.data(), GL_UNSIGNED_BYTE, kWindowPx, kWindowPx))
    fail("OSMesa's context cannot be made current");
  mjr_setBuffer(mjFB_OFFSCREEN, &mjr_);
  if (mjr_.currentBuffer != mjFB_OFFSCREEN) fail("there is no off-screen buffer");
}

}  // namespace sim::world
