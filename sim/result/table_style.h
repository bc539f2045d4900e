// How tables for the terminal look.
#pragma once

#include <string>

namespace sim::result {

/// colours: escape sequences of a terminal. all_metrics: not only headline metrics and those with limits.
struct TableStyle {
  bool colours = false;
  bool all_metrics = false;
};

/// good: passed. bad: missed or failed.
enum class Paint { none, good, bad };

/// The text in green or red, where colours are wanted.
inline std::string painted(const std::string& text, Paint paint, bool colours) {
  if (!colours || paint == Paint::none) return text;
  return (paint == Paint::bad ? "\033[31m" : "\033[32m") + text + "\033[0m";
}

}  // namespace sim::result
