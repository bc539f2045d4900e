#include "sim/recording/manifest.h"

#include <fmt/format.h>

#include "sim/files/csv.h"

namespace sim::recording {
namespace {

constexpr const char* kHeader = "#xxh3_128,bytes,path";
constexpr const char* kName = "manifest.csv";
constexpr const char* kUnfinished = "manifest.unfinished";

std::string wrong_size(std::uint64_t expected, std::uint64_t found) {
  return fmt::format("{}: {} bytes were recorded, {} found", found < expected ? "truncated" : "edited",
                     expected, found);
}

}  // namespace

ManifestWriter::ManifestWriter(const fs::path& folder) : folder_(folder), out_(folder / kUnfinished) {
  out_.write(fmt::format("{}\n", kHeader));
}

void ManifestWriter::add(const std::string& path, const files::Hash& hash) {
  out_.write(fmt::format("{},{},{}\n", hash.hex(), hash.bytes(), path));
}

void ManifestWriter::finish() {
  out_.close();
  fs::rename(folder_ / kUnfinished, folder_ / kName);
}

Manifest::Manifest(const fs::path& folder) : folder_(folder) {
  if (!fs::is_directory(folder)) throw files::FileError(folder, "no such folder");
  const fs::path file = folder / kName;
  if (!fs::exists(file)) throw files::FileError(file, "is missing: not a recording, or an unfinished one");
  files::CsvReader rows(file, {kHeader});
  while (rows.next()) {
    if (rows.text(0).size() != 32) rows.fail(0, "expected a hash of 32 hexadecimal digits");
    if (rows.integer(1) < 0) rows.fail(1, "a negative size");
    files::require_below(folder, rows.text(2));
    const Entry entry{std::uint64_t(rows.integer(1)), std::string(rows.text(0))};
    if (!entries_.emplace(rows.text(2), entry).second) rows.fail(2, "this file is listed twice");
  }
  files::Hash own;
  own.add(files::read_text(file, files::kMostOfRows));
  hash_ = own.hex();
}

void Manifest::check_sizes() const {
  for (const auto& [path, entry] : entries_) {
    std::error_code error, none;
    const std::uint64_t bytes = fs::file_size(folder_ / path, error);
    if (error)
      throw files::FileError(folder_ / path,
                             fs::exists(folder_ / path, none) ? files::kNotRegular : "is missing");
    if (bytes != entry.bytes) throw files::FileError(folder_ / path, wrong_size(entry.bytes, bytes));
  }
}

void Manifest::read_pieces(const std::string& path, std::uintmax_t most,
                           const std::function<void(std::string_view)>& take) const {
  const auto listed = entries_.find(path);
  if (listed == entries_.end()) throw files::FileError(folder_ / kName, "does not list " + path);
  const fs::path file = files::contained_path(folder_, path);
  if (!fs::exists(file)) throw files::FileError(file, "is missing");
  files::Hash found;
  files::InputFile input(file, most);
  for (std::string_view piece; !(piece = input.next()).empty(); take(piece)) found.add(piece);
  const auto& [bytes, hash] = listed->second;
  if (found.bytes() != bytes) throw files::FileError(folder_ / path, wrong_size(bytes, found.bytes()));
  if (found.hex() != hash)
    throw files::FileError(folder_ / path, "edited: its content differs from the recorded one");
}

void Manifest::check_all() const {
  for (const auto& [path, entry] : entries_) check(path);
}

fs::path Manifest::check(const std::string& path) const {
  read_pieces(path, files::kMostOfRows, [](std::string_view) {});
  return folder_ / path;
}

std::string Manifest::read(const std::string& path, std::uintmax_t most) const {
  std::string content;
  read_pieces(path, most, [&](std::string_view piece) { content += piece; });
  return content;
}

}  // namespace sim::recording
