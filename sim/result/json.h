// Helpers for writing the JSON files of a result; files::Json reads them.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

namespace sim::result {

/// null for an absent value.
template <typename T>
nlohmann::ordered_json or_null(const std::optional<T>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

/// Writes an indented JSON file. Throws FileError.
void write_json(const std::filesystem::path& file, const nlohmann::ordered_json& json);

}  // namespace sim::result
