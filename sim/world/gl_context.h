// The off-screen OpenGL context (OSMesa, software) with MuJoCo's renderer in it.
#pragma once

#include <GL/osmesa.h>
#include <mujoco/mujoco.h>

#include <memory>
#include <vector>

namespace sim::world {

/// An OSMesa context, current on the thread that made it, whose MuJoCo renderer draws into an off-screen
/// buffer. One core draws (LP_NUM_THREADS=0), so frames and their cost do not depend on the machine's load.
/// Throws std::runtime_error when there is no usable OpenGL.
class GlContext {
 public:
  /// Buffer of width x height px with `samples` multisamples (0, or the most the renderer has: 4).
  GlContext(const mjModel& model, int width, int height, int samples);
  ~GlContext();
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  void make_current();  ///< on this thread, drawing off-screen
  const mjrContext& mjr() const { return mjr_; }

 private:
  struct Destroy {
    void operator()(OSMesaContext context) const { OSMesaDestroyContext(context); }
  };
  std::unique_ptr<osmesa_context, Destroy> context_;
  std::vector<unsigned char> window_;  ///< OSMesa needs a window buffer; nothing is ever drawn in it
  mjrContext mjr_{};
};

}  // namespace sim::world
