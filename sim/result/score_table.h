// The short table of a run on the terminal, and the style of all tables.
#pragma once

#include <filesystem>
#include <string>

namespace sim::result {

/// colors: escape sequences of a terminal. all_metrics: not only headline metrics and those with limits.
struct TableStyle {
  bool colors = false;
  bool all_metrics = false;
};

/// good: passed. bad: missed or failed.
enum class Paint { none, good, bad };

/// Returns the text in green or red, if colors are wanted.
inline std::string painted(const std::string& text, Paint paint, bool colors) {
  if (!colors || paint == Paint::none) return text;
  return (paint == Paint::bad ? "\033[31m" : "\033[32m") + text + "\033[0m";
}

/// A table of the headline metrics and those with limits, or all, from a result folder's score.json,
/// timing.json and, if it exists, about.json. A reason that several metrics share is printed once, below
/// them. The table has the cause of an ending other than completed, unless `failed`: then the caller prints
/// it. Throws FileError.
std::string score_table(const std::filesystem::path& result_folder, const TableStyle& style = {},
                        bool failed = false);

}  // namespace sim::result
