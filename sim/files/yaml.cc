#include "sim/files/yaml.h"

#include <fmt/format.h>
#include <yaml-cpp/depthguard.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <sstream>

namespace sim::files {
namespace {

constexpr std::size_t kMostKeys = 1000;  // of one map: each is compared with all before it

/// Builds the tree from the parser's events, which unlike YAML::Node have aliases, tags and all positions.
class TreeBuilder : public YAML::EventHandler {
 public:
  TreeBuilder(const Origin& origin, YamlWriter writer) : origin_(origin), writer_(writer) {}

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    close(open(mark, "", anchor, Yaml::Kind::empty));
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    fail(at(mark), "", "aliases (*name) are not supported: write the value out");
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    Yaml node = open(mark, tag, anchor, Yaml::Kind::scalar);
    node.text = value;
    node.quoted = tag == "!";
    close(std::move(node));
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open_.push_back(open(mark, tag, anchor, Yaml::Kind::list));
  }
  void OnSequenceEnd() override { close_collection(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open_.push_back(open(mark, tag, anchor, Yaml::Kind::map));
  }
  void OnMapEnd() override { close_collection(); }

  Yaml at(const YAML::Mark& mark) const {
    Yaml node;
    node.origin = origin_;
    if (mark.line > 0) node.origin = {origin_.file, origin_.line + mark.line, 1};
    node.origin.column += std::max(mark.column, 0);
    return node;
  }
  Yaml root;

 private:
  Yaml open(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor, Yaml::Kind kind) const {
    Yaml node = at(mark);
    node.kind = kind;
    if (writer_ == YamlWriter::other) return node;
    if (anchor != YAML::NullAnchor) fail(node, "", "anchors (&name) are not supported: write the value out");
    if (!tag.empty() && tag != "?" && tag != "!") fail(node, "", "tags (!name) are not supported");
    return node;
  }
  void close_collection() {
    Yaml node = std::move(open_.back());
    open_.pop_back();
    close(std::move(node));
  }
  void close(Yaml node) {
    if (open_.empty()) {
      root = std::move(node);
    } else if (Yaml& parent = open_.back();
               parent.kind == Yaml::Kind::map && parent.keys.size() == parent.items.size()) {
      parent.keys.push_back(checked_key(parent, std::move(node)));
    } else {
      parent.items.push_back(std::move(node));
    }
  }
  static Yaml checked_key(const Yaml& parent, Yaml key) {
    if (key.kind != Yaml::Kind::scalar || key.text.empty()) fail(key, "", "a key must be plain text");
    if (parent.keys.size() == kMostKeys)
      fail(key, "", fmt::format("more than {} keys, expected fewer", kMostKeys));
    for (const Yaml& other : parent.keys)
      if (other.text == key.text)
        fail(key, key.text, fmt::format("given twice, first in line {}", other.origin.line));
    return key;
  }

  Origin origin_;
  YamlWriter writer_;
  std::vector<Yaml> open_;
};

// OpenCV's reader requires it on the first line; yaml-cpp does not know this version.
constexpr std::string_view kOpenCvDirective = "%YAML:1.0";

}  // namespace

const Yaml* Yaml::find(std::string_view key) const {
  const auto found = std::ranges::find(keys, key, &Yaml::text);
  return found == keys.end() ? nullptr : &items[static_cast<std::size_t>(found - keys.begin())];
}

void fail(const Yaml& node, std::string_view key, std::string_view message) {
  const auto& [file, line, column] = node.origin;
  const std::string subject = key.empty() ? "" : fmt::format("{}: ", key);
  std::string text = fmt::format("{}:{}:{}: {}{}", file, line, column, subject, message);
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return std::iscntrl(c) != 0; }, '?');
  throw ConfigError(text);
}

Yaml parse_yaml(std::string_view text, const Origin& origin, YamlWriter writer) {
  TreeBuilder builder(origin, writer);
  if (writer == YamlWriter::other) {
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);  // byte order mark
    if (text.starts_with(kOpenCvDirective)) text.remove_prefix(std::min(text.find('\n'), text.size()));
  }
  if (text.find('\0') != std::string_view::npos)
    fail(builder.at(YAML::Mark()), "", "has a zero byte, expected text");
  std::istringstream in{std::string(text)};
  try {
    YAML::Parser parser(in);
    if (!parser.HandleNextDocument(builder)) {
      builder.root.origin = origin;
      return builder.root;
    }
    Yaml root = std::move(builder.root);
    if (parser.HandleNextDocument(builder)) fail(builder.root, "", "a second document; expected one");
    return root;
  } catch (const YAML::DeepRecursion& e) {
    fail(builder.at(e.mark), "", fmt::format("has {} levels or more, expected fewer", e.depth()));
  } catch (const YAML::Exception& e) {
    fail(builder.at(e.mark), "", "bad YAML: " + e.msg);
  }
}

std::string quote_if_needed(std::string_view text) {
  const auto plain = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; };
  if (!text.empty() && std::ranges::all_of(text, plain) && text != "null") return std::string(text);
  YAML::Emitter out;
  out << YAML::DoubleQuoted << std::string(text);
  return out.c_str();
}

}  // namespace sim::files
