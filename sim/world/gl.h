// OpenGL as OSMesa offers it, loaded when something is drawn first: it brings a compiler along (LLVM), which
// would cost each process 20 ms at its start, also those that draw nothing.
#pragma once

#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glext.h>
#include <GL/osmesa.h>

namespace sim::world {

/// The functions in use, by their own names: gl().glClear(...).
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

/// Throws std::runtime_error when there is no OSMesa.
const Gl& gl();

}  // namespace sim::world
