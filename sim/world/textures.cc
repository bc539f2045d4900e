#include "sim/world/textures.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>

#include "sim/world/gl.h"
#include "sim/world/model.h"
#include "sim/world/office_paint.h"
#include "sim/world/shadows.h"

namespace sim::world {
namespace {

// Area-averaged mipmaps: each level from the one above, down to one texel. The nearest level alone is
// sampled: blending two costs 6 % of a frame and finds corners no better.
void load(unsigned texture, cv::Mat picture) {
  const bool grey = picture.channels() == 1;
  gl().glBindTexture(GL_TEXTURE_2D, texture);
  gl().glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
  gl().glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  for (int level = 0;; ++level) {
    gl().glTexImage2D(GL_TEXTURE_2D, level, grey ? GL_R8 : GL_RGB8, picture.cols, picture.rows, 0,
                      grey ? GL_RED : GL_RGB, GL_UNSIGNED_BYTE, picture.data);
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

int texture_of(const mjModel& model, int geom) {
  const int material = model.geom_matid[geom];
  return material < 0 ? -1 : model.mat_texid[material];
}

}  // namespace

cv::Mat3b texture_picture(const mjModel& model, const mjData& data, int texture, std::uint64_t seed) {
  const char* const name = mj_id2name(&model, mjOBJ_TEXTURE, texture);
  const cv::Mat3b painted = name ? paint_texture(name, seed) : cv::Mat3b();
  if (painted.empty())
    return cv::Mat(model.tex_height[texture], model.tex_width[texture], CV_8UC3,
                   model.tex_rgb + model.tex_adr[texture])
        .clone();
  for (int geom = 0; geom < model.ngeom; ++geom)
    if (takes_shadows(model, geom) && texture_of(model, geom) == texture)
      bake_shadows(painted, model, data, geom);
  return painted;
}

Textures::Textures(const mjModel& model, std::uint64_t seed, Channels channels)
    : names_(std::size_t(model.ntex)) {
  const Data data(mj_makeData(&model));
  mj_kinematics(&model, data.get());
  gl().glGenTextures(model.ntex, names_.data());
  for (int texture = 0; texture < model.ntex; ++texture) {
    if (model.tex_type[texture] != mjTEXTURE_2D) continue;
    cv::Mat picture = texture_picture(model, *data, texture, seed);
    if (channels == Channels::grey) cv::cvtColor(picture, picture, cv::COLOR_RGB2GRAY);
    load(names_[std::size_t(texture)], picture);
  }
}

Textures::~Textures() { gl().glDeleteTextures(int(names_.size()), names_.data()); }

unsigned Textures::on(const mjModel& model, int geom) const {
  const int texture = texture_of(model, geom);
  if (texture < 0) return 0;
  if (model.tex_type[texture] != mjTEXTURE_2D)
    throw std::invalid_argument("only 2d textures can be drawn on a geom");
  return names_[std::size_t(texture)];
}

}  // namespace sim::world
