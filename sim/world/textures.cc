#include "sim/world/textures.h"

#include <GL/gl.h>

#include <opencv2/imgproc.hpp>

#include "sim/world/office_paint.h"

namespace sim::world {
namespace {

// Area-averaged mipmaps: each level from the one above, down to one texel.
void load(unsigned int texture, cv::Mat picture) {
  glBindTexture(GL_TEXTURE_2D, texture);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  for (int level = 0;; ++level) {
    glTexImage2D(GL_TEXTURE_2D, level, GL_RGB, picture.cols, picture.rows, 0, GL_RGB, GL_UNSIGNED_BYTE,
                 picture.data);
    if (picture.cols == 1 && picture.rows == 1) break;
    cv::Mat half;
    cv::resize(picture, half, {std::max(1, picture.cols / 2), std::max(1, picture.rows / 2)}, 0, 0,
               cv::INTER_AREA);
    picture = half;
  }
}

}  // namespace

void upload_textures(const mjModel& model, const mjrContext& context, std::uint64_t seed) {
  for (int id = 0; id < model.ntex; ++id) {
    if (model.tex_type[id] != mjTEXTURE_2D) continue;
    const cv::Mat picture = paint_texture(mj_id2name(&model, mjOBJ_TEXTURE, id), seed);
    if (!picture.empty()) load(context.texture[id], picture);
  }
}

}  // namespace sim::world
