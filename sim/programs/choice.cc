#include "sim/programs/choice.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <sstream>

#include "sim/files/hash.h"
#include "sim/programs/child_program.h"

namespace sim::programs {
namespace {

std::optional<std::string> hash_of(const fs::path& file) {
  std::error_code fault;
  std::ifstream in(file, std::ios::binary);
  if (!in || !fs::is_regular_file(file, fault)) return std::nullopt;
  files::Hash hash;
  for (std::array<char, 1 << 16> piece; in.read(piece.data(), piece.size()), in.gcount() > 0;)
    hash.add({piece.data(), std::size_t(in.gcount())});
  return hash.hex();
}

}  // namespace

std::string program_name(const std::vector<std::string>& words) {
  constexpr std::array kRunners{"python",  "pypy", "sh",      "bash",   "dash", "zsh",
                                "perl",    "ruby", "node",    "julia",  "java", "lua",
                                "Rscript", "env",  "timeout", "stdbuf", "nice", "taskset"};
  std::string name;
  for (const std::string& word : words) {
    const bool is_argument = word.empty() || word[0] == '-' || word.find('=') != word.npos ||
                             word.find_first_not_of("0123456789.") == word.npos;
    if (word == "-c") break;  // code follows instead of a file
    if (is_argument && !name.empty()) continue;
    name = fs::path(word).stem().string();
    const std::string program = name.substr(0, name.find_last_not_of("0123456789.") + 1);
    if (std::ranges::find(kRunners, program) == kRunners.end()) break;
  }
  return name;
}

void require_program(const Choice& choice, const std::string& role) {
  const fs::path file = program_file(choice.words.at(0));
  const int why = ::access(file.c_str(), X_OK) != 0 ? errno : fs::is_directory(file) ? EISDIR : 0;
  if (why != 0 || !missing_interpreter(file).empty())
    throw std::invalid_argument(start_fault(role, file, why));
}

std::string files_identity(const Choice& choice) {
  std::string text;
  const auto add = [&](const auto& place, const fs::path& file) {
    if (const auto hash = hash_of(file)) text += fmt::format(" {} {}", place, *hash);
  };
  for (std::size_t i = 0; const std::string& word : command_words(choice)) {
    add(i, i == 0 ? program_file(word) : fs::path(word));
    ++i;
  }
  for (const auto& [name, value] : choice.options) add(name, value);
  return text;
}

std::vector<std::string> command_words(const Choice& choice) {
  if (choice.source != Source::command) return choice.words;
  std::istringstream words(choice.words.front());
  return {std::istream_iterator<std::string>(words), {}};
}

std::string options_text(const Choice& choice) {
  std::string text;
  for (const auto& [key, value] : choice.options) text += fmt::format("{}={}\n", key, value);
  return text;
}

}  // namespace sim::programs
