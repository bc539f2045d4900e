// An XML file as a tree of elements that know their file and line: MJCF with its includes, or URDF.
#pragma once

#include <array>
#include <charconv>
#include <filesystem>
#include <memory>

#include "sim/files/text.h"

namespace sim::model_file {

struct Element {
  std::string name;
  std::vector<std::pair<std::string, std::string>> attributes = {};
  std::vector<Element> children = {};
  std::shared_ptr<const fs::path> file = {};
  int line = 0;

  /// Returns an attribute's value, or nullptr.
  const std::string* find(std::string_view attribute) const;
  std::string get(std::string_view attribute) const;  ///< "" if absent
  void set(std::string_view attribute, std::string value);
  void erase(std::string_view attribute);
  /// Returns the first child of that name, or nullptr.
  const Element* child(std::string_view name) const;
  /// Calls a function with this element and each element below it.
  void visit(const auto& function) {
    function(*this);
    for (Element& child : children) child.visit(function);
  }
  void visit(const auto& function) const {
    function(*this);
    for (const Element& child : children) child.visit(function);
  }
  /// Adds a child, with this element's line.
  Element& add(std::string_view name, std::vector<std::pair<std::string, std::string>> attributes = {});
};

/// Throws FileError "file:line: element attribute: message"; the attribute may be empty.
template <typename... T>
[[noreturn]] void reject(const Element& element, std::string_view attribute, fmt::format_string<T...> message,
                         T&&... values) {
  throw files::FileError(*element.file, std::size_t(element.line), "{}{}{}: {}", element.name,
                         attribute.empty() ? "" : " ", attribute,
                         fmt::format(message, std::forward<T>(values)...));
}

/// Returns the finite numbers of an attribute, or none if it is absent. Throws FileError, also if there are
/// not `least` to `most` of them.
std::vector<double> numbers(const Element& element, std::string_view attribute, std::size_t least,
                            std::size_t most);
/// Returns the numbers as an attribute value that reads back as the same numbers.
std::string text_of(const auto& numbers) {
  std::string text;
  for (const double number : numbers) {
    std::array<char, 32> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
    text.append(text.empty() ? "" : " ").append(digits.data(), end);
  }
  return text;
}

/// Returns the root of a file. Throws FileError if it cannot be read or is not XML.
Element read_xml(const fs::path& file);

/// Returns the element and everything in it as indented XML.
std::string to_xml(const Element& element);

}  // namespace sim::model_file
