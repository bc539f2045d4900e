#include "sim/result/json.h"

#include "sim/files/text.h"

namespace sim::result {

nlohmann::ordered_json read_json(const std::filesystem::path& file) {
  auto json = nlohmann::ordered_json::parse(files::read_text(file), nullptr, false);
  if (!json.is_object()) throw files::FileError(file, "expected a JSON object");
  return json;
}

void write_json(const std::filesystem::path& file, const nlohmann::ordered_json& json) {
  files::write_text(file, json.dump(2) + "\n");
}

}  // namespace sim::result
