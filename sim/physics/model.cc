#include "sim/physics/model.h"

#include <fmt/format.h>
#include <mujoco/mujoco.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstring>
#include <stdexcept>

namespace sim::physics {
namespace {

std::array<char, 1000> last_warning{};

// A main file that only exists in memory, "in" the models folder so that relative paths start there.
std::unique_ptr<mjVFS, void (*)(mjVFS*)> main_file(const std::string& name, const std::string& text) {
  std::unique_ptr<mjVFS, void (*)(mjVFS*)> files(new mjVFS, [](mjVFS* vfs) {
    mj_deleteVFS(vfs);
    delete vfs;
  });
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), name.c_str(), static_cast<int>(text.size()));
  std::memcpy(files->filedata[0], text.data(), text.size());
  return files;
}

}  // namespace

void Free::operator()(mjModel_* model) const { mj_deleteModel(model); }
void Free::operator()(mjData_* data) const { mj_deleteData(data); }

Model load_model(const std::string& robot, const std::string& room, const std::filesystem::path& models,
                 Shapes shapes) {
  // MuJoCo's own handler waits for a key, and throwing through its C frames is not safe: the process ends.
  mju_user_error = [](const char* message) {
    std::fprintf(stderr, "gaitslam: MuJoCo: %s\n", message);
    std::fflush(nullptr);
    _exit(3);
  };
  mju_user_warning = [](const char* message) {
    std::snprintf(last_warning.data(), last_warning.size(), "%s", message);
  };
  for (const std::string& part : {robot, room}) {
    const std::filesystem::path file = models / (part + ".xml");
    if (!std::filesystem::is_regular_file(file)) throw std::runtime_error("no model " + file.string());
  }
  const std::string name = (models / (robot + "_in_" + room + ".xml")).string();
  const std::string discard = shapes == Shapes::colliding ? "<compiler discardvisual=\"true\"/>" : "";
  const std::string text = "<mujoco model=\"" + robot + " in " + room + "\">" + discard + "<include file=\"" +
                           robot + ".xml\"/><include file=\"" + room + ".xml\"/></mujoco>";
  const auto files = main_file(name, text);
  std::array<char, 1000> message{};
  Model model(mj_loadXML(name.c_str(), files.get(), message.data(), static_cast<int>(message.size())));
  if (!model)
    throw std::runtime_error("models " + robot + ".xml and " + room + ".xml do not load: " + message.data());
  return model;
}

Model copy_of(const Model& model) { return Model(mj_copyModel(nullptr, model.get())); }

Models::Models(const std::string& robot, const std::string& room, const std::filesystem::path& folder)
    : on_floor(load_model(robot, kPhysicalRoom, folder, Shapes::colliding)),
      in_room(load_model(robot, room, folder)) {}

std::string take_warning() {
  std::string warning = last_warning.data();
  last_warning[0] = '\0';
  return warning;
}

std::vector<std::string> joint_names() {
  std::vector<std::string> names;
  const std::array<std::pair<const char*, int>, 6> groups{
      {{"RLEG", 6}, {"LLEG", 6}, {"CHEST", 2}, {"HEAD", 2}, {"RARM", 7}, {"LARM", 7}}};
  for (const auto& [group, count] : groups)
    for (int i = 0; i < count; ++i) names.push_back(fmt::format("{}_JOINT{}", group, i));
  return names;
}

}  // namespace sim::physics
