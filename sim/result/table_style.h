// The style of tables on the terminal.
#pragma once

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

}  // namespace sim::result
