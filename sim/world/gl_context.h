// The off-screen OpenGL context (OSMesa, software).
#pragma once

#include <memory>
#include <vector>

#include "sim/world/gl.h"

namespace sim::world {

/// An OSMesa context, current on the thread that made it. One core draws (LP_NUM_THREADS=0), so frames and
/// their cost do not depend on the machine's load. Throws std::runtime_error when there is no usable OpenGL.
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

}  // namespace sim::world
