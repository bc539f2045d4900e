// The fixed list of files that the server has.
#pragma once

#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "sim/view/server.h"
#include "sim/view/shown_run.h"

namespace sim::view {

/// Paths are compared literally: no path from a client reaches the disk.
class Site {
 public:
  /// The page, its script and its style; /about: what it shows; /model/<i> and /pictures/<i> of each run.
  /// about: further keys of /about.
  Site(const std::vector<ShownRun>& runs, nlohmann::ordered_json about);

  void add(const std::string& path, Resource resource);
  /// A resource made in its own thread at the first request. Until then it is empty, and the page asks again.
  void add(const std::string& path, std::function<Resource()> make);
  /// <folder>/<number>: an element of a list, or nullopt beyond its end.
  void add_list(const std::string& folder, std::function<std::optional<Resource>(std::size_t)> element);

  std::optional<Resource> at(std::string_view path, std::string_view token);

 private:
  std::map<std::string, std::function<Resource()>, std::less<>> files_;
  std::map<std::string, std::function<std::optional<Resource>(std::size_t)>, std::less<>> lists_;
};

/// A message of text that must not be lost.
Message json_message(const nlohmann::ordered_json& content);

Resource json_resource(std::string text);
Resource bytes_resource(std::string bytes);

}  // namespace sim::view
