#include "sim/estimators/estimator_choice.h"

#include <fmt/format.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>

#include "sim/files/hashed_file.h"

namespace sim::estimators {
namespace {

namespace fs = std::filesystem;

std::optional<std::string> hash_of(const fs::path& file) {
  std::error_code fault;
  std::ifstream in;
  if (fs::is_regular_file(file, fault)) in.open(file, std::ios::binary);
  if (!in.is_open()) return std::nullopt;
  files::Hash hash;
  for (std::array<char, 1 << 16> piece; in.read(piece.data(), piece.size()), in.gcount() > 0;)
    hash.add({piece.data(), static_cast<std::size_t>(in.gcount())});
  return hash.hex();
}

/// Searches a program without a slash in its name in PATH.
std::optional<std::string> hash_of_program(const std::string& word) {
  const char* const path = std::getenv("PATH");
  if (word.find('/') != word.npos || !path) return hash_of(word);
  std::istringstream folders(path);
  for (std::string folder; std::getline(folders, folder, ':');)
    if (const auto hash = hash_of(fs::path(folder.empty() ? "." : folder) / word)) return hash;
  return std::nullopt;
}

}  // namespace

std::string estimator_files_identity(const EstimatorChoice& choice) {
  std::string text;
  for (std::size_t i = 0; i < choice.words.size(); ++i) {
    const std::string& word = choice.words[i];
    const bool is_program = choice.source == Source::program && i == 0;
    if (const auto hash = is_program ? hash_of_program(word) : hash_of(word))
      text += fmt::format(" {} {}", i, *hash);
  }
  return text;
}

}  // namespace sim::estimators
