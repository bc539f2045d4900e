#include "sim/world/frame_buffer.h"

#include <algorithm>
#include <stdexcept>

#include "sim/world/gl.h"

namespace sim::world {

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
  attach(made.colour, channels_ == Channels::grey ? GL_R8 : GL_RGBA8, GL_COLOR_ATTACHMENT0);
  attach(made.depth, GL_DEPTH_COMPONENT24, GL_DEPTH_ATTACHMENT);
  if (gl().glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw std::runtime_error("off-screen OpenGL: there is no off-screen buffer");
  return made;
}

void FrameBuffer::free(Buffers& buffers) {
  gl().glDeleteFramebuffers(1, &buffers.frame);
  gl().glDeleteRenderbuffers(1, &buffers.colour);
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

}  // namespace sim::world
