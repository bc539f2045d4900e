#include "sim/camera/gl.h"

#include <dlfcn.h>

#include <cstdlib>
#include <stdexcept>
#include <string>

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
/// Mesa itself leaks a few hundred bytes for each destroyed context. Silent commands stay silent.
extern "C" const char* __lsan_default_suppressions() { return "leak:libOSMesa"; }
extern "C" const char* __lsan_default_options() { return "print_suppressions=0"; }
/// LLVM 14's sanitizer expects the size of a library's thread-local memory in front of that memory. glibc
/// 2.36 does not put it there, so the leak check would read from random addresses.
extern "C" const char* __asan_default_options() { return "intercept_tls_get_addr=0"; }
#endif
#endif

namespace sim::camera {
namespace {

constexpr int kWindowPx = 8;
std::mutex used;  // locked while a thread uses OpenGL

void require(bool works, const std::string& fault) {
  if (!works) throw std::runtime_error("off-screen OpenGL: " + fault);
}

// Draws on one core. Mip levels are approximate: that is faster, and corners are found just as well.
void* open_library() {
  setenv("LP_NUM_THREADS", "0", 1);
  setenv("GALLIVM_PERF", "rho_approx", 1);
  void* const library = dlopen("libOSMesa.so.8", RTLD_NOW | RTLD_LOCAL);
  if (!library) require(false, dlerror());
  return library;
}

enum Attribute : GLuint { kPoint, kLight, kTexturePoint };

constexpr char kVertexShader[] = R"(
uniform mat4 clip_from_points;
attribute vec3 point;
attribute LIGHT light;
varying LIGHT surface_light;
#ifdef TEXTURED
attribute vec2 texture_point;
varying vec2 surface_texture_point;
#endif
void main() {
  gl_Position = clip_from_points * vec4(point, 1.0);
  surface_light = light;
#ifdef TEXTURED
  surface_texture_point = texture_point;
#endif
}
)";

constexpr char kFragmentShader[] = R"(
varying LIGHT surface_light;
#ifdef TEXTURED
uniform sampler2D picture;
varying vec2 surface_texture_point;
#endif
void main() {
#ifdef TEXTURED
  gl_FragColor = vec4(vec3(surface_light * texture2D(picture, surface_texture_point).CHANNELS), 1.0);
#else
  gl_FragColor = vec4(vec3(surface_light), 1.0);
#endif
}
)";

// The shader is deleted with its program.
void add_shader(GLuint program, GLenum kind, const std::string& source) {
  const GLuint shader = GL(glCreateShader)(kind);
  const char* const text = source.c_str();
  GL(glShaderSource)(shader, 1, &text, nullptr);
  GL(glCompileShader)(shader);
  GL(glAttachShader)(program, shader);
  GL(glDeleteShader)(shader);
}

GLuint program(Channels channels, bool textured) {
  const std::string head = std::string("#version 120\n") +
                           (channels == Channels::gray ? "#define LIGHT float\n#define CHANNELS r\n"
                                                       : "#define LIGHT vec3\n#define CHANNELS rgb\n") +
                           (textured ? "#define TEXTURED\n" : "");
  const GLuint made = GL(glCreateProgram)();
  add_shader(made, GL_VERTEX_SHADER, head + kVertexShader);
  add_shader(made, GL_FRAGMENT_SHADER, head + kFragmentShader);
  GL(glBindAttribLocation)(made, kPoint, "point");
  GL(glBindAttribLocation)(made, kLight, "light");
  if (textured) GL(glBindAttribLocation)(made, kTexturePoint, "texture_point");
  GL(glLinkProgram)(made);
  GLint links = 0;
  GL(glGetProgramiv)(made, GL_LINK_STATUS, &links);
  require(links, "a shader program does not compile or link");
  return made;
}

}  // namespace

void* gl_function(const char* name) {
  static void* const library = open_library();
  void* const found = dlsym(library, name);
  if (!found) require(false, dlerror());
  return found;
}

Renderer::Renderer(const cv::Size& size_px, Channels channels, const Renderer* shares)
    : window_(4 * kWindowPx * kWindowPx), size_(size_px), channels_(channels) {
  const std::lock_guard lock(used);
  context_ = GL(OSMesaCreateContextExt)(OSMESA_RGBA, 24, 8, 0, shares ? shares->context_ : nullptr);
  require(context_, "OSMesa cannot create a context");
  make_current();
  make_frame();
  plain_ = program(channels, false), textured_ = program(channels, true);
  GL(glEnable)(GL_DEPTH_TEST);
  GL(glDepthFunc)(GL_LESS);
  GL(glEnable)(GL_CULL_FACE);
  GL(glFrontFace)(GL_CW);  // OpenGL counts rows upward
}

Renderer::~Renderer() {
  const std::lock_guard lock(used);
  if (GL(OSMesaGetCurrentContext)() == context_)
    GL(OSMesaMakeCurrent)(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0);
  GL(OSMesaDestroyContext)(context_);
}

std::unique_lock<std::mutex> Renderer::use() {
  std::unique_lock lock(used);
  make_current();
  return lock;
}

void Renderer::make_current() {
  require(GL(OSMesaGetCurrentContext)() == context_ ||
              GL(OSMesaMakeCurrent)(context_, window_.data(), GL_UNSIGNED_BYTE, kWindowPx, kWindowPx),
          "OSMesa's context cannot be made current");
}

void Renderer::make_frame() {
  unsigned frame = 0;
  GL(glGenFramebuffers)(1, &frame);
  GL(glBindFramebuffer)(GL_FRAMEBUFFER, frame);
  const auto attach = [&](GLenum format, GLenum place) {
    unsigned buffer = 0;
    GL(glGenRenderbuffers)(1, &buffer);
    GL(glBindRenderbuffer)(GL_RENDERBUFFER, buffer);
    GL(glRenderbufferStorage)(GL_RENDERBUFFER, format, size_.width, size_.height);
    GL(glFramebufferRenderbuffer)(GL_FRAMEBUFFER, place, GL_RENDERBUFFER, buffer);
  };
  attach(channels_ == Channels::gray ? GL_R8 : GL_RGBA8, GL_COLOR_ATTACHMENT0);
  attach(GL_DEPTH_COMPONENT24, GL_DEPTH_ATTACHMENT);
  require(GL(glCheckFramebufferStatus)(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE,
          "the off-screen buffer is incomplete");
}

void Renderer::reserve(std::size_t vertices) {
  unsigned buffer = 0;
  GL(glGenBuffers)(1, &buffer);
  GL(glBindBuffer)(GL_ARRAY_BUFFER, buffer);
  GL(glBufferData)(GL_ARRAY_BUFFER, GLsizeiptr(vertices * sizeof(Vertex)), nullptr, GL_DYNAMIC_DRAW);
  const auto attribute = [](Attribute which, int numbers, std::size_t offset) {
    const void* const at = reinterpret_cast<const void*>(offset);
    GL(glEnableVertexAttribArray)(which);
    GL(glVertexAttribPointer)(which, numbers, GL_FLOAT, GL_FALSE, sizeof(Vertex), at);
  };
  attribute(kPoint, 3, offsetof(Vertex, p));
  attribute(kLight, int(channels_), offsetof(Vertex, light));
  attribute(kTexturePoint, 2, offsetof(Vertex, uv));
}

void Renderer::set_vertices(std::size_t first, std::span<const Vertex> vertices) {
  const auto offset = GLintptr(first * sizeof(Vertex)), bytes = GLsizeiptr(vertices.size_bytes());
  GL(glBufferSubData)(GL_ARRAY_BUFFER, offset, bytes, vertices.data());
}

void Renderer::clear() {
  GL(glDisable)(GL_SCISSOR_TEST);
  GL(glClearColor)(0, 0, 0, 0);
  GL(glClearDepth)(1);
  GL(glClear)(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

void Renderer::set_view(const cv::Rect& viewport, const Eigen::Matrix4f& clip_from_points) {
  GL(glViewport)(viewport.x, viewport.y, viewport.width, viewport.height);
  GL(glScissor)(viewport.x, viewport.y, viewport.width, viewport.height);
  GL(glEnable)(GL_SCISSOR_TEST);
  for (const unsigned each : {plain_, textured_}) {
    GL(glUseProgram)(each);
    const int place = GL(glGetUniformLocation)(each, "clip_from_points");
    GL(glUniformMatrix4fv)(place, 1, GL_FALSE, clip_from_points.data());
  }
}

void Renderer::draw(std::span<const std::uint32_t> indices, unsigned texture, float alpha) {
  if (indices.empty()) return;
  if (alpha < 1) {
    GL(glEnable)(GL_BLEND);
    GL(glBlendColor)(0, 0, 0, alpha);
    GL(glBlendFunc)(GL_CONSTANT_ALPHA, GL_ONE_MINUS_CONSTANT_ALPHA);
    GL(glDepthMask)(GL_FALSE);
  }
  GL(glUseProgram)(texture ? textured_ : plain_);
  if (texture) GL(glBindTexture)(GL_TEXTURE_2D, texture);
  GL(glDrawElements)(GL_TRIANGLES, GLsizei(indices.size()), GL_UNSIGNED_INT, indices.data());
  if (alpha < 1) {
    GL(glDisable)(GL_BLEND);
    GL(glDepthMask)(GL_TRUE);
  }
}

cv::Mat Renderer::read() const {
  const bool gray = channels_ == Channels::gray;
  const GLenum format = gray ? GL_RED : GL_RGB;
  cv::Mat picture(size_, gray ? CV_8UC1 : CV_8UC3);
  GL(glPixelStorei)(GL_PACK_ALIGNMENT, 1);
  GL(glReadPixels)(0, 0, size_.width, size_.height, format, GL_UNSIGNED_BYTE, picture.data);
  return picture;
}

cv::Mat1f Renderer::read_depth() const {
  cv::Mat1f depth(size_);
  GL(glReadPixels)(0, 0, size_.width, size_.height, GL_DEPTH_COMPONENT, GL_FLOAT, depth.data);
  return depth;
}

// Rounding may differ between shader programs, so marks are drawn slightly in front of the surface.
void Renderer::begin_marks() {
  GL(glDisableVertexAttribArray)(kLight);
  GL(glVertexAttrib3f)(kLight, 1, 1, 1);
  GL(glDisable)(GL_SCISSOR_TEST);
  GL(glClear)(GL_COLOR_BUFFER_BIT);
  GL(glDepthMask)(GL_FALSE);
  GL(glEnable)(GL_POLYGON_OFFSET_FILL);
  GL(glPolygonOffset)(-1, -4);
}

void Renderer::end_marks() {
  GL(glEnableVertexAttribArray)(kLight);
  GL(glDisable)(GL_POLYGON_OFFSET_FILL);
  GL(glDepthMask)(GL_TRUE);
}

}  // namespace sim::camera
