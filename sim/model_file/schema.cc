#include <sstream>

#include "sim/model_file/model_file.h"

namespace sim::model_file {

// An element's line is indented by three more than its parent's, "name (type)" and attributes, which the
// following lines continue.
Schema::Schema(std::string_view printed) {
  std::vector<Known*> open{&root_};
  for (const std::string& line : files::lines_of(printed)) {
    const std::size_t indent = line.find_first_not_of(' ');
    if (indent == line.npos) continue;
    std::istringstream words(line);
    std::string word;
    if (const std::size_t type = line.find(" (", indent); type != line.npos && indent % 3 == 0) {
      const std::size_t depth = indent / 3;
      std::string name = line.substr(indent, type - indent);
      if (name == "(world)body") name = "body";
      if (depth + 1 > open.size()) throw std::invalid_argument("the schema skips a level");
      open.resize(depth + 1);
      Known& known = open.back()->children[name];
      known.recursive = line.substr(type + 2, 1) == "R";
      open.push_back(&known);
      words.seekg(std::streamoff(type + 4));
    }
    while (words >> word) open.back()->attributes.insert(word);
  }
  if (!root_.children.contains("mujoco")) throw std::invalid_argument("the schema has no mujoco");
  Known& file = root_.children["mujoco"];
  file.children["worldbody"] = file.children["body"];
  file.children["worldbody"].recursive = false;
  file.children["worldbody"].children["body"] = file.children["body"];
}

}  // namespace sim::model_file
