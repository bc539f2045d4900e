#include "sim/camera/gl.h"

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <stdexcept>
#include <string>

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

namespace sim::camera {
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

FrameBuffer::FrameBuffer(int width_px, int height_px, int samples, Channels channels)
    : width_px_(width_px), height_px_(height_px), channels_(channels) {
  GLint most = 0;
  gl().glGetIntegerv(GL_MAX_SAMPLES, &most);
  drawn_ = make(samples > 1 ? std::min(samples, most) : 0);
  if (samples > 1) resolved_ = make(0);
}

FrameBuffer::~FrameBuffer() { free(drawn_), free(resolved_); }

FrameBuffer::Buffers FrameBuffer::make(int samples) const {
  Buffers made;
  gl().glGenFramebuffers(1, &made.frame);
  gl().glBindFramebuffer(GL_FRAMEBUFFER, made.frame);
  const auto attach = [&](unsigned& buffer, GLenum format, GLenum place) {
    gl().glGenRenderbuffers(1, &buffer);
    gl().glBindRenderbuffer(GL_RENDERBUFFER, buffer);
    gl().glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, width_px_, height_px_);
    gl().glFramebufferRenderbuffer(GL_FRAMEBUFFER, place, GL_RENDERBUFFER, buffer);
  };
  attach(made.color, channels_ == Channels::grey ? GL_R8 : GL_RGBA8, GL_COLOR_ATTACHMENT0);
  attach(made.depth, GL_DEPTH_COMPONENT24, GL_DEPTH_ATTACHMENT);
  if (gl().glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw std::runtime_error("off-screen OpenGL: the off-screen buffer is incomplete");
  return made;
}

void FrameBuffer::free(Buffers& buffers) {
  gl().glDeleteFramebuffers(1, &buffers.frame);
  gl().glDeleteRenderbuffers(1, &buffers.color);
  gl().glDeleteRenderbuffers(1, &buffers.depth);
}

void FrameBuffer::clear() {
  gl().glBindFramebuffer(GL_FRAMEBUFFER, drawn_.frame);
  gl().glDisable(GL_SCISSOR_TEST);
  gl().glClearColor(0, 0, 0, 0);
  gl().glClearDepth(1);
  gl().glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

cv::Mat FrameBuffer::read() const {
  gl().glBindFramebuffer(GL_READ_FRAMEBUFFER, drawn_.frame);
  if (resolved_.frame) {
    gl().glBindFramebuffer(GL_DRAW_FRAMEBUFFER, resolved_.frame);
    gl().glDisable(GL_SCISSOR_TEST);
    gl().glBlitFramebuffer(0, 0, width_px_, height_px_, 0, 0, width_px_, height_px_, GL_COLOR_BUFFER_BIT,
                           GL_NEAREST);
    gl().glBindFramebuffer(GL_READ_FRAMEBUFFER, resolved_.frame);
  }
  const bool grey = channels_ == Channels::grey;
  cv::Mat picture(height_px_, width_px_, grey ? CV_8UC1 : CV_8UC3);
  gl().glPixelStorei(GL_PACK_ALIGNMENT, 1);
  gl().glReadPixels(0, 0, width_px_, height_px_, grey ? GL_RED : GL_RGB, GL_UNSIGNED_BYTE, picture.data);
  return picture;
}

}  // namespace sim::camera
