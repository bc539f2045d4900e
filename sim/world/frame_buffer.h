// The off-screen picture that OpenGL draws into.
#pragma once

#include <opencv2/core.hpp>

namespace sim::world {

/// What of a picture's light is drawn: its brightness alone, which is what the head camera sees and costs
/// less, or its colours, for pictures that people look at.
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
    unsigned frame = 0, colour = 0, depth = 0;
  };
  Buffers make(int samples) const;
  static void free(Buffers& buffers);

  int width_px_, height_px_;
  Channels channels_;
  Buffers drawn_, resolved_;  // resolved_ is none without multisampling
};

}  // namespace sim::world
