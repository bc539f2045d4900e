#include "sim/result/about_file.h"

#include <string_view>

#include "sim/files/json.h"
#include "sim/result/score_file.h"

namespace sim::result {
namespace {

std::string text_or_empty(const files::Json& json, std::string_view key) {
  const auto value = json.find(key);
  return value ? value->text() : "";
}

About about_of(const files::Json& json) {
  About about;
  about.program = text_or_empty(json, "program");
  about.version = text_or_empty(json, "version");
  about.revision = text_or_empty(json, "revision");
  about.scenario = text_or_empty(json, "scenario");
  about.estimator = text_or_empty(json, "estimator");
  if (const auto seed = json.find("seed")) about.seed = seed->whole();
  about.cause = text_or_empty(json, "cause");
  if (const auto ending = json.find("walk_ending"))
    about.walk = {read_ending(*ending), text_or_empty(json, "walk_cause")};
  about.counterfactual = text_or_empty(json, "counterfactual");
  about.alignment = text_or_empty(json, "alignment");
  about.recording = text_or_empty(json, "recording_xxh3_128");
  about.models = text_or_empty(json, "models_xxh3_128");
  if (const auto set_by = json.find("set_by"))
    for (const auto& [key, origin] : set_by->entries()) about.set_by[key] = origin.text();
  return about;
}

}  // namespace

About read_about(const std::filesystem::path& file) { return about_of(files::read_json(file)); }

About read_about_of_walk(const std::filesystem::path& file) {
  const files::Json json = files::read_json(file);
  json.at("walk_ending").text();
  return about_of(json);
}

}  // namespace sim::result
