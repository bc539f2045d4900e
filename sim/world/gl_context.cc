#include "sim/world/gl_context.h"

#include <stdexcept>

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
/// Mesa itself keeps a few hundred bytes of each context that was destroyed. A silent command stays silent.
extern "C" const char* __lsan_default_suppressions() { return "leak:libOSMesa"; }
extern "C" const char* __lsan_default_options() { return "print_suppressions=0"; }
/// The size of a library's thread-local memory, which the sanitizer of LLVM 14 expects in front of it, is not
/// there with glibc 2.36: the leak check would read at random addresses.
extern "C" const char* __asan_default_options() { return "intercept_tls_get_addr=0"; }
#endif
#endif

namespace sim::world {
namespace {

constexpr int kWindowPx = 8;

}  // namespace

GlContext::GlContext() : window_(4 * kWindowPx * kWindowPx) {
  context_.reset(gl().OSMesaCreateContextExt(OSMESA_RGBA, 24, 8, 0, nullptr));
  if (!context_) throw std::runtime_error("off-screen OpenGL: OSMesa gives no context");
  make_current();
}

GlContext::~GlContext() {
  if (gl().OSMesaGetCurrentContext() == context_.get())
    gl().OSMesaMakeCurrent(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0);
}

void GlContext::make_current() {
  if (gl().OSMesaGetCurrentContext() != context_.get() &&
      !gl().OSMesaMakeCurrent(context_.get(), window_.data(), GL_UNSIGNED_BYTE, kWindowPx, kWindowPx))
    throw std::runtime_error("off-screen OpenGL: OSMesa's context cannot be made current");
}

}  // namespace sim::world
