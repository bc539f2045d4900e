// Strict reading of JSON: errors about missing values and wrong types name the file and the key.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "sim/files/text.h"

namespace sim::files {

/// A value in a JSON document, kept alive, and its key there ("metrics.rmse_m.value", "limits[0].passed").
/// All members throw FileError "file: key: expected ..., found ...".
class Json {
 public:
  /// The object in this text. file: its name in errors.
  Json(const fs::path& file, std::string_view text);

  /// Returns the value of a key of this object.
  Json at(std::string_view key) const;
  /// Returns the value of a key, or nothing if the key is missing or its value is null.
  std::optional<Json> find(std::string_view key) const;

  std::string text() const;  ///< without terminal control characters (sanitize)
  double number() const;
  std::uint64_t whole() const;  ///< a number without fraction and sign
  bool flag() const;            ///< true or false
  std::optional<double> number_or_null() const;

  std::vector<Json> items() const;                            ///< items of a list
  std::vector<std::pair<std::string, Json>> entries() const;  ///< entries of an object, in the file's order

  const nlohmann::ordered_json& value() const { return *value_; }
  [[noreturn]] void fail(const std::string& why) const;

 private:
  struct Document;
  Json(std::shared_ptr<const Document> document, const nlohmann::ordered_json& value, std::string key);
  void require(bool holds, const char* expected) const;

  std::shared_ptr<const Document> document_;
  const nlohmann::ordered_json* value_;
  std::string key_;
};

/// Returns the JSON object in a file. Throws FileError.
Json read_json(const fs::path& file);

/// Returns the JSON as text. Bytes that are not UTF-8 become replacement characters.
std::string json_text(const nlohmann::ordered_json& json, int indent = -1);

}  // namespace sim::files
