#include "sim/files/json.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "sim/files/csv.h"

namespace sim::files {
namespace {

using nlohmann::ordered_json;

constexpr int kDeepest = 64;  // levels: deeper nesting would exhaust the stack when written

std::string key_below(const std::string& key, std::string_view name) {
  return fmt::format("{}{}{}", key, key.empty() ? "" : ".", name);
}

}  // namespace

struct Json::Document {
  fs::path file;
  ordered_json root;
};

Json::Json(const fs::path& file, std::string_view text) {
  bool too_deep = false;
  const auto limit_depth = [&](int depth, ordered_json::parse_event_t, ordered_json&) {
    too_deep = too_deep || depth > kDeepest;
    return !too_deep;
  };
  auto document = std::make_shared<Document>();
  document->file = file;
  try {
    document->root = ordered_json::parse(text, limit_depth);
  } catch (const ordered_json::parse_error& error) {
    const std::string_view before = text.substr(0, std::max<std::size_t>(error.byte, 1) - 1);
    throw FileError(file, 1 + std::size_t(std::ranges::count(before, '\n')),
                    before.size() - (before.rfind('\n') + 1) + 1, "is not JSON or is cut off here");
  } catch (const ordered_json::out_of_range&) {
    throw FileError(file, "has a number beyond 1e308");
  }
  if (too_deep) throw FileError(file, "is nested deeper than {} levels", kDeepest);
  if (!document->root.is_object()) throw FileError(file, "expected a JSON object");
  value_ = &document->root;
  document_ = std::move(document);
}

Json::Json(std::shared_ptr<const Document> document, const ordered_json& value, std::string key)
    : document_(std::move(document)), value_(&value), key_(std::move(key)) {}

void Json::fail(const std::string& why) const {
  throw FileError(document_->file, key_.empty() ? why : key_ + ": " + why);
}

void Json::require(bool holds, const char* expected) const {
  if (!holds) fail(fmt::format("expected {}, found {}", expected, value_->type_name()));
}

Json Json::at(std::string_view key) const {
  require(value_->is_object(), "an object");
  const auto found = value_->find(std::string(key));
  if (found == value_->end()) throw FileError(document_->file, key_below(key_, key) + ": is missing");
  return {document_, *found, key_below(key_, key)};
}

std::optional<Json> Json::find(std::string_view key) const {
  require(value_->is_object(), "an object");
  const auto found = value_->find(std::string(key));
  return found == value_->end() || found->is_null() ? std::nullopt : std::optional(at(key));
}

std::string Json::text() const {
  require(value_->is_string(), "text");
  return sanitize(value_->get<std::string>());
}

double Json::number() const {
  require(value_->is_number(), "a number");
  return value_->get<double>();
}

std::uint64_t Json::whole() const {
  require(value_->is_number_unsigned(), "a whole number from 0");
  return value_->get<std::uint64_t>();
}

bool Json::flag() const {
  require(value_->is_boolean(), "true or false");
  return value_->get<bool>();
}

std::optional<double> Json::number_or_null() const {
  return value_->is_null() ? std::nullopt : std::optional(number());
}

std::vector<Json> Json::items() const {
  require(value_->is_array(), "a list");
  std::vector<Json> all;
  for (const ordered_json& item : *value_)
    all.push_back({document_, item, fmt::format("{}[{}]", key_, all.size())});
  return all;
}

std::vector<std::pair<std::string, Json>> Json::entries() const {
  require(value_->is_object(), "an object");
  std::vector<std::pair<std::string, Json>> all;
  for (const auto& [name, value] : value_->items())
    all.emplace_back(name, Json(document_, value, key_below(key_, name)));
  return all;
}

Json read_json(const fs::path& file) {
  const std::string text = read_text(file, kMostOfJson);
  require_utf8(file, text);
  return {file, text};
}

std::string json_text(const ordered_json& json, int indent) {
  return json.dump(indent, ' ', false, ordered_json::error_handler_t::replace);
}

}  // namespace sim::files
