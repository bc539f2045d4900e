// A run as the page shows it, besides its frames, and the fixed list of files that the server has.
#pragma once

#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/scenario/scenario.h"
#include "sim/view/server.h"
#include "slam/options.h"

namespace sim::view {

/// Robot and room. pieces: triangles that share a body and a picture: the length of a JSON list
/// (little-endian, four bytes); {body, picture, vertices, indices} of each (body: index of the pose in
/// Frame::bodies, -1: the room; picture: index in the pictures, -1: plain color); blanks up to a multiple of
/// four bytes; then for each piece, in the axes of its body, positions (m), normals and RGB (0 to 1) of its
/// vertices, with a picture their places in it from the upper left (all float32), and the indices of its
/// triangles (uint32).
struct Model {
  std::string pieces;
  /// Paints the pictures when the page asks for them: width, height (uint32) and RGB rows of each. May be
  /// called from another thread, once.
  std::function<std::string()> pictures = [] { return ""; };
};

/// A time to jump to. kind: "closure", "fault", "lost", "suspect" or "end".
struct Moment {
  double t_s = 0;
  std::string kind, text;
};

struct ShownRun {
  std::string label;  ///< "tangent_circle, seed 1"
  std::optional<slam::CameraIntrinsics> camera = std::nullopt;
  double duration_s = 0;  ///< 0: unknown
  std::vector<Moment> moments = {};
  std::vector<std::string> missing = {};  ///< sentences: what is not shown, and why
  std::optional<Model> model = std::nullopt;
};

/// The faults that a scenario injects.
std::vector<Moment> faults_of(const scenario::Scenario& scenario);

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
