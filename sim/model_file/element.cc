#include "sim/model_file/element.h"

#include <fmt/format.h>
#include <tinyxml2.h>

#include <algorithm>
#include <numbers>
#include <sstream>

namespace sim::model_file {
namespace {

constexpr std::uintmax_t kMostOfModel = 16 << 20;  // bytes; public models are below 1 MiB

Element copied(const tinyxml2::XMLElement& from, const std::shared_ptr<const std::filesystem::path>& file) {
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
  return std::find_if(attributes.begin(), attributes.end(), [&](const auto& a) { return a.first == name; });
}

Eigen::Vector3d vector(const std::vector<double>& values, std::size_t from = 0) {
  return {values[from], values[from + 1], values[from + 2]};
}

Eigen::Vector3d direction(const Element& element, std::string_view attribute, const Eigen::Vector3d& v) {
  if (v.norm() < 1e-9) reject(element, attribute, "has a direction of length 0");
  return v.normalized();
}

Eigen::Quaterniond turn_of(const Element& element, const Angles& angles) {
  using Turn = Eigen::AngleAxisd;
  const double unit = angles.degrees ? std::numbers::pi / 180 : 1;
  if (const auto q = numbers(element, "quat", 4, 4); !q.empty()) {
    const Eigen::Quaterniond turn(q[0], q[1], q[2], q[3]);
    if (turn.norm() < 1e-9) reject(element, "quat", "has length 0");
    return turn.normalized();
  }
  if (const auto a = numbers(element, "axisangle", 4, 4); !a.empty())
    return Eigen::Quaterniond(Turn(unit * a[3], direction(element, "axisangle", vector(a))));
  if (const auto e = numbers(element, "euler", 3, 3); !e.empty()) {
    Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
    for (std::size_t i = 0; i < 3; ++i) {
      const int axis = (angles.sequence[i] | 0x20) - 'x';
      const Eigen::Quaterniond turn(Turn(unit * e[i], Eigen::Vector3d::Unit(axis)));
      q = angles.sequence[i] < 'a' ? turn * q : q * turn;
    }
    return q;
  }
  if (const auto xy = numbers(element, "xyaxes", 6, 6); !xy.empty()) {
    Eigen::Matrix3d R;
    R.col(0) = direction(element, "xyaxes", vector(xy));
    R.col(1) = direction(element, "xyaxes", vector(xy, 3) - vector(xy, 3).dot(R.col(0)) * R.col(0));
    R.col(2) = R.col(0).cross(R.col(1));
    return Eigen::Quaterniond(R);
  }
  if (const auto z = numbers(element, "zaxis", 3, 3); !z.empty())
    return Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(),
                                              direction(element, "zaxis", vector(z)));
  return Eigen::Quaterniond::Identity();
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

void reject(const Element& element, std::string_view attribute, std::string_view message) {
  throw files::FileError(
      *element.file, std::size_t(element.line),
      fmt::format("{}{}{}: {}", element.name, attribute.empty() ? "" : " ", attribute, message));
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
    if (!value) reject(element, attribute, fmt::format("has '{}', expected a number", word));
    values.push_back(*value);
  }
  if (values.size() < least || values.size() > most)
    reject(element, attribute,
           fmt::format("has {}, expected {}", files::counted(values.size(), "number"),
                       least == most ? fmt::format("{}", least) : fmt::format("{} to {}", least, most)));
  return values;
}

Element read_xml(const std::filesystem::path& file) {
  const std::string text = files::read_text(file, kMostOfModel);
  tinyxml2::XMLDocument document;
  if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS)
    throw files::FileError(file, std::size_t(std::max(1, document.ErrorLineNum())),
                           fmt::format("is not XML ({})", document.ErrorName()));
  if (!document.RootElement()) throw files::FileError(file, "has no element, expected a model");
  return copied(*document.RootElement(), std::make_shared<const std::filesystem::path>(file));
}

std::string to_xml(const Element& element) {
  std::string text;
  print(element, text, 0);
  return text;
}

Eigen::Isometry3d place_of(const Element& element, const Angles& angles) {
  const auto p = numbers(element, "pos", 3, 3);
  return Eigen::Translation3d(p.empty() ? Eigen::Vector3d::Zero() : vector(p)) * turn_of(element, angles);
}

void set_place(Element& element, const Eigen::Isometry3d& X) {
  for (const char* attribute : {"pos", "quat", "axisangle", "euler", "xyaxes", "zaxis"})
    element.erase(attribute);
  element.set("pos", text_of(X.translation()));
  const Eigen::Quaterniond q(X.linear());
  element.set("quat", text_of(std::array{q.w(), q.x(), q.y(), q.z()}));
}

}  // namespace sim::model_file
