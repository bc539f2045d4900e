#include "sim/model_file/element.h"

#include <fmt/format.h>
#include <tinyxml2.h>

#include <algorithm>
#include <sstream>

namespace sim::model_file {
namespace {

constexpr std::uintmax_t kMostOfModel = 16 << 20;  // bytes; public models are below 1 MiB

Element copied(const tinyxml2::XMLElement& from, const std::shared_ptr<const fs::path>& file) {
  Element element{.name = from.Name(), .file = file, .line = from.GetLineNum()};
  for (auto* each = from.FirstAttribute(); each; each = each->Next())
    element.attributes.emplace_back(each->Name(), each->Value());
  for (auto* each = from.FirstChildElement(); each; each = each->NextSiblingElement())
    element.children.push_back(copied(*each, file));
  return element;
}

void print(const Element& element, std::string& text, int depth) {
  text.append(std::size_t(2 * depth), ' ').append("<").append(element.name);
  for (const auto& [name, value] : element.attributes) {
    text.append(" ").append(name).append("=\"");
    for (const char c : value) {
      const char* const escaped = c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '"' ? "&quot;" : nullptr;
      escaped ? text.append(escaped) : text.append(1, c);
    }
    text.append("\"");
  }
  text.append(element.children.empty() ? "/>\n" : ">\n");
  if (element.children.empty()) return;
  for (const Element& child : element.children) print(child, text, depth + 1);
  text.append(std::size_t(2 * depth), ' ').append("</").append(element.name).append(">\n");
}

auto place_of(auto& attributes, std::string_view name) {
  return std::ranges::find_if(attributes, [&](const auto& a) { return a.first == name; });
}

}  // namespace

const std::string* Element::find(std::string_view attribute) const {
  const auto found = place_of(attributes, attribute);
  return found == attributes.end() ? nullptr : &found->second;
}

std::string Element::get(std::string_view attribute) const {
  const std::string* const value = find(attribute);
  return value ? *value : "";
}

void Element::set(std::string_view attribute, std::string value) {
  const auto found = place_of(attributes, attribute);
  if (found == attributes.end())
    attributes.emplace_back(attribute, std::move(value));
  else
    found->second = std::move(value);
}

void Element::erase(std::string_view attribute) {
  std::erase_if(attributes, [&](const auto& each) { return each.first == attribute; });
}

const Element* Element::child(std::string_view wanted) const {
  const auto found = std::ranges::find(children, wanted, &Element::name);
  return found == children.end() ? nullptr : &*found;
}

Element& Element::add(std::string_view child,
                      std::vector<std::pair<std::string, std::string>> its_attributes) {
  children.push_back({std::string(child), std::move(its_attributes), {}, file, line});
  return children.back();
}

std::vector<double> numbers(const Element& element, std::string_view attribute, std::size_t least,
                            std::size_t most) {
  const std::string* const text = element.find(attribute);
  std::vector<double> values;
  if (!text) return values;
  std::istringstream words(*text);
  for (std::string word; words >> word;) {
    const std::string_view digits = std::string_view(word).substr(word[0] == '+' ? 1 : 0);
    const auto value = files::parse_finite(digits);
    if (!value) reject(element, attribute, "has '{}', expected a number", word);
    values.push_back(*value);
  }
  if (values.size() < least || values.size() > most)
    reject(element, attribute, "has {}, expected {}", files::counted(values.size(), "number"),
           least == most ? fmt::format("{}", least) : fmt::format("{} to {}", least, most));
  return values;
}

Element read_xml(const fs::path& file) {
  const std::string text = files::read_text(file, kMostOfModel);
  tinyxml2::XMLDocument document;
  if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS)
    throw files::FileError(file, std::size_t(std::max(1, document.ErrorLineNum())),
                           "is not well-formed XML: expected closed elements and quoted attributes");
  if (!document.RootElement()) throw files::FileError(file, "has no element, expected a model");
  return copied(*document.RootElement(), std::make_shared<const fs::path>(file));
}

std::string to_xml(const Element& element) {
  std::string text;
  print(element, text, 0);
  return text;
}

}  // namespace sim::model_file
