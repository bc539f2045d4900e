// Off-screen OpenGL (OSMesa, software): its functions, a context and a frame buffer.
#pragma once

#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glext.h>
#include <GL/osmesa.h>

#include <memory>
#include <opencv2/core.hpp>
#include <vector>

namespace sim::camera {
/// The OpenGL functions in use: gl().glClear(...). They are loaded with the first drawing, since OSMesa
/// brings a compiler (LLVM) that would cost every process 20 ms at its start.
struct Gl {
#define GAITSLAM_GL(name) decltype(&::name) name = reinterpret_cast<decltype(&::name)>(function(#name))
  GAITSLAM_GL(OSMesaCreateContextExt);
  GAITSLAM_GL(OSMesaDestroyContext);
  GAITSLAM_GL(OSMesaGetCurrentContext);
  GAITSLAM_GL(OSMesaMakeCurrent);
  GAITSLAM_GL(glAttachShader);
  GAITSLAM_GL(glBindAttribLocation);
  GAITSLAM_GL(glBindBuffer);
  GAITSLAM_GL(glBindFramebuffer);
  GAITSLAM_GL(glBindRenderbuffer);
  GAITSLAM_GL(glBindTexture);
  GAITSLAM_GL(glBlitFramebuffer);
  GAITSLAM_GL(glBufferData);
  GAITSLAM_GL(glBufferSubData);
  GAITSLAM_GL(glCheckFramebufferStatus);
  GAITSLAM_GL(glClear);
  GAITSLAM_GL(glClearColor);
  GAITSLAM_GL(glClearDepth);
  GAITSLAM_GL(glCompileShader);
  GAITSLAM_GL(glCreateProgram);
  GAITSLAM_GL(glCreateShader);
  GAITSLAM_GL(glDeleteBuffers);
  GAITSLAM_GL(glDeleteFramebuffers);
  GAITSLAM_GL(glDeleteProgram);
  GAITSLAM_GL(glDeleteRenderbuffers);
  GAITSLAM_GL(glDeleteShader);
  GAITSLAM_GL(glDeleteTextures);
  GAITSLAM_GL(glDepthFunc);
  GAITSLAM_GL(glDisable);
  GAITSLAM_GL(glDrawElements);
  GAITSLAM_GL(glEnable);
  GAITSLAM_GL(glEnableVertexAttribArray);
  GAITSLAM_GL(glFramebufferRenderbuffer);
  GAITSLAM_GL(glFrontFace);
  GAITSLAM_GL(glGenBuffers);
  GAITSLAM_GL(glGenFramebuffers);
  GAITSLAM_GL(glGenRenderbuffers);
  GAITSLAM_GL(glGenTextures);
  GAITSLAM_GL(glGetIntegerv);
  GAITSLAM_GL(glGetProgramiv);
  GAITSLAM_GL(glGetShaderiv);
  GAITSLAM_GL(glGetUniformLocation);
  GAITSLAM_GL(glLinkProgram);
  GAITSLAM_GL(glPixelStorei);
  GAITSLAM_GL(glReadPixels);
  GAITSLAM_GL(glRenderbufferStorageMultisample);
  GAITSLAM_GL(glScissor);
  GAITSLAM_GL(glShaderSource);
  GAITSLAM_GL(glTexImage2D);
  GAITSLAM_GL(glTexParameteri);
  GAITSLAM_GL(glUniformMatrix4fv);
  GAITSLAM_GL(glUseProgram);
  GAITSLAM_GL(glVertexAttribPointer);
  GAITSLAM_GL(glViewport);
#undef GAITSLAM_GL

 private:
  static void* function(const char* name);
};

/// Throws std::runtime_error if OSMesa is missing.
const Gl& gl();

/// An OSMesa context, current on the thread that made it. One core draws (LP_NUM_THREADS=0), so frames and
/// their cost do not depend on the machine's load. Throws std::runtime_error without a usable OpenGL.
class GlContext {
 public:
  GlContext();
  ~GlContext();
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  void make_current();  ///< on this thread

 private:
  struct Destroy {
    void operator()(OSMesaContext context) const { gl().OSMesaDestroyContext(context); }
  };
  std::vector<unsigned char> window_;  ///< OSMesa needs a window buffer; nothing is ever drawn in it
  std::unique_ptr<osmesa_context, Destroy> context_;
};

/// Channels of a picture: only brightness, as the head camera sees it, which costs less, or colors, for
/// people.
enum class Channels { grey = 1, rgb = 3 };

/// A picture with its depth in the current OpenGL context, cleared and read as a whole. Row 0 is the one that
/// OpenGL calls the lowest.
class FrameBuffer {
 public:
  /// `samples`: multisamples, at most as many as the renderer has (4); 0 or 1: none. Throws
  /// std::runtime_error when the renderer has no such buffer.
  FrameBuffer(int width_px, int height_px, int samples, Channels channels);
  ~FrameBuffer();
  FrameBuffer(const FrameBuffer&) = delete;
  FrameBuffer& operator=(const FrameBuffer&) = delete;

  /// Draws go here from now on; black, and infinitely far.
  void clear();
  /// CV_8UC1 or CV_8UC3 (RGB).
  cv::Mat read() const;

 private:
  struct Buffers {
    unsigned frame = 0, color = 0, depth = 0;
  };
  Buffers make(int samples) const;
  static void free(Buffers& buffers);

  int width_px_, height_px_;
  Channels channels_;
  Buffers drawn_, resolved_;  // resolved_: only with multisampling
};

}  // namespace sim::camera
