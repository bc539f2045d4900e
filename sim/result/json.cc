#include "sim/result/json.h"

#include "sim/files/json.h"
#include "sim/files/text.h"

namespace sim::result {

void write_json(const std::filesystem::path& file, const nlohmann::ordered_json& json) {
  files::write_text(file, files::json_text(json, 2) + "\n");
}

}  // namespace sim::result
