#include "sim/camera/rasterizer.h"

#include <array>
#include <stdexcept>
#include <string>

#include "sim/camera/gl.h"

namespace sim::camera {
namespace {

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

GLuint compiled(GLenum kind, const std::string& source) {
  const GLuint shader = gl().glCreateShader(kind);
  const char* const text = source.c_str();
  gl().glShaderSource(shader, 1, &text, nullptr);
  gl().glCompileShader(shader);
  GLint compiles = 0;
  gl().glGetShaderiv(shader, GL_COMPILE_STATUS, &compiles);
  if (!compiles) throw std::runtime_error("off-screen OpenGL: a shader does not compile");
  return shader;
}

}  // namespace

Rasterizer::Program Rasterizer::program(Channels channels, bool textured) {
  const std::string head = std::string("#version 120\n") +
                           (channels == Channels::grey ? "#define LIGHT float\n#define CHANNELS r\n"
                                                       : "#define LIGHT vec3\n#define CHANNELS rgb\n") +
                           (textured ? "#define TEXTURED\n" : "");
  const GLuint vertex = compiled(GL_VERTEX_SHADER, head + kVertexShader);
  const GLuint fragment = compiled(GL_FRAGMENT_SHADER, head + kFragmentShader);
  const GLuint linked = gl().glCreateProgram();
  gl().glAttachShader(linked, vertex), gl().glAttachShader(linked, fragment);
  gl().glDeleteShader(vertex), gl().glDeleteShader(fragment);  // once the program is
  gl().glBindAttribLocation(linked, kPoint, "point");
  gl().glBindAttribLocation(linked, kLight, "light");
  if (textured) gl().glBindAttribLocation(linked, kTexturePoint, "texture_point");
  gl().glLinkProgram(linked);
  GLint links = 0;
  gl().glGetProgramiv(linked, GL_LINK_STATUS, &links);
  if (!links) throw std::runtime_error("off-screen OpenGL: a shader program does not link");
  return {linked, gl().glGetUniformLocation(linked, "clip_from_points")};
}

Rasterizer::Rasterizer(Channels channels, std::size_t vertices)
    : plain_(program(channels, false)), textured_(program(channels, true)) {
  gl().glGenBuffers(1, &buffer_);
  gl().glBindBuffer(GL_ARRAY_BUFFER, buffer_);
  gl().glBufferData(GL_ARRAY_BUFFER, GLsizeiptr(vertices * sizeof(Vertex)), nullptr, GL_DYNAMIC_DRAW);
  const auto attribute = [](Attribute which, int numbers, std::size_t offset) {
    gl().glEnableVertexAttribArray(which);
    gl().glVertexAttribPointer(which, numbers, GL_FLOAT, GL_FALSE, sizeof(Vertex),
                               reinterpret_cast<const void*>(offset));
  };
  attribute(kPoint, 3, offsetof(Vertex, p));
  attribute(kLight, int(channels), offsetof(Vertex, light));
  attribute(kTexturePoint, 2, offsetof(Vertex, uv));
  gl().glEnable(GL_DEPTH_TEST);
  gl().glDepthFunc(GL_LESS);
  gl().glEnable(GL_CULL_FACE);
  gl().glFrontFace(GL_CW);  // OpenGL's rows count upwards
}

Rasterizer::~Rasterizer() {
  gl().glDeleteBuffers(1, &buffer_);
  gl().glDeleteProgram(plain_.name), gl().glDeleteProgram(textured_.name);
}

void Rasterizer::set_vertices(std::size_t first, std::span<const Vertex> vertices) {
  gl().glBufferSubData(GL_ARRAY_BUFFER, GLintptr(first * sizeof(Vertex)), GLsizeiptr(vertices.size_bytes()),
                       vertices.data());
}

void Rasterizer::set(const Program& program, const Eigen::Matrix4f& clip_from_points) {
  gl().glUseProgram(program.name);
  gl().glUniformMatrix4fv(program.clip_from_points, 1, GL_FALSE, clip_from_points.data());
}

void Rasterizer::set_view(const cv::Rect& viewport, const Eigen::Matrix4f& clip_from_points) {
  gl().glViewport(viewport.x, viewport.y, viewport.width, viewport.height);
  gl().glScissor(viewport.x, viewport.y, viewport.width, viewport.height);
  gl().glEnable(GL_SCISSOR_TEST);
  set(plain_, clip_from_points), set(textured_, clip_from_points);
}

void Rasterizer::draw(std::span<const std::uint32_t> indices, unsigned texture) {
  if (indices.empty()) return;
  gl().glUseProgram(texture ? textured_.name : plain_.name);
  if (texture) gl().glBindTexture(GL_TEXTURE_2D, texture);
  gl().glDrawElements(GL_TRIANGLES, GLsizei(indices.size()), GL_UNSIGNED_INT, indices.data());
}

}  // namespace sim::camera
