#include "sim/world/textures.h"

#include <GL/gl.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "sim/world/model.h"
#include "sim/world/office_paint.h"
#include "sim/world/shadows.h"

namespace sim::world {
namespace {

// Area-averaged mipmaps: each level from the one above, down to one texel. The nearest level alone is
// sampled: blending two costs 6 % of a frame and finds corners no better.
void load(unsigned int texture, cv::Mat picture) {
  glBindTexture(GL_TEXTURE_2D, texture);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
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

// The large planes of the room: floor and walls. A picture that is repeated over its plane takes none.
bool takes_shadows(const mjModel& model, int geom) {
  const mjtNum* size = model.geom_size + 3 * geom;
  const int material = model.geom_matid[geom];
  return model.geom_type[geom] == mjGEOM_PLANE && std::max(size[0], size[1]) > 3 && material >= 0 &&
         model.mat_texrepeat[2 * material] == 1;
}

int texture_of(const mjModel& model, int geom) { return model.mat_texid[model.geom_matid[geom]]; }

}  // namespace

void upload_textures(const mjModel& model, const mjrContext& context, std::uint64_t seed) {
  const Data data(mj_makeData(&model));
  mj_kinematics(&model, data.get());
  for (int id = 0; id < model.ntex; ++id) {
    const char* const name = mj_id2name(&model, mjOBJ_TEXTURE, id);
    if (model.tex_type[id] != mjTEXTURE_2D || !name) continue;
    const cv::Mat3b picture = paint_texture(name, seed);
    if (picture.empty()) continue;
    for (int geom = 0; geom < model.ngeom; ++geom)
      if (takes_shadows(model, geom) && texture_of(model, geom) == id)
        bake_shadows(picture, model, *data, geom);
    load(context.texture[id], picture);
  }
}

}  // namespace sim::world
