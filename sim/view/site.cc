#include "sim/view/site.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <future>
#include <nlohmann/json.hpp>

#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/pages/figure.h"
#include "walking/hrp2.h"

// Embeds the page and the files that esbuild makes from web/.
#define GAITSLAM_EMBED(name, file)                                                          \
  asm(".section .rodata\n" #name "_begin:\n.incbin \"" file "\"\n" #name "_end:\n.text\n"); \
  extern "C" const char name##_begin[] __attribute__((visibility("hidden")));               \
  extern "C" const char name##_end[] __attribute__((visibility("hidden")));
GAITSLAM_EMBED(gaitslam_view_page, GAITSLAM_VIEW_PAGE)
GAITSLAM_EMBED(gaitslam_view_script, GAITSLAM_VIEW_BUNDLE "/view.js")
GAITSLAM_EMBED(gaitslam_view_style, GAITSLAM_VIEW_BUNDLE "/view.css")

namespace sim::view {
namespace {

using nlohmann::ordered_json;

Resource resource(std::string type, std::string_view bytes) {
  return {std::move(type), std::make_shared<const std::string>(bytes)};
}

// The page names its script and its style with the token; the script reads it from the page's own address.
std::string page_with(std::string_view token) {
  std::string page(gaitslam_view_page_begin, gaitslam_view_page_end);
  constexpr std::string_view kPlace = "TOKEN";
  for (std::size_t at = page.find(kPlace); at != page.npos; at = page.find(kPlace, at + token.size()))
    page.replace(at, kPlace.size(), token);
  return page;
}

constexpr std::string_view kIcon =
    "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 16 16'><circle cx='8' cy='8' r='6' "
    "fill='#0069b0'/></svg>";

ordered_json to_json(const slam::CameraIntrinsics& camera) {
  return {{"width", camera.width_px}, {"height", camera.height_px}, {"fu", camera.fu_px},
          {"fv", camera.fv_px},       {"u0", camera.u0_px},         {"v0", camera.v0_px}};
}

ordered_json to_json(const ShownRun& run) {
  using walking::hrp2::kSoleMax, walking::hrp2::kSoleMin;
  ordered_json moments = ordered_json::array();
  for (const Moment& moment : run.moments)
    moments.push_back({{"t", moment.t_s}, {"kind", moment.kind}, {"text", moment.text}});
  return {{"label", run.label},
          {"duration", run.duration_s},
          {"sole", {kSoleMin.x(), kSoleMin.y(), kSoleMax.x(), kSoleMax.y()}},
          {"missing", run.missing},
          {"has_model", run.model.has_value()},
          {"camera", run.camera ? to_json(*run.camera) : ordered_json(nullptr)},
          {"moments", moments}};
}

}  // namespace

std::vector<Moment> faults_of(const scenario::Scenario& scenario) {
  std::vector<Moment> moments;
  for (const sensor_errors::Fault& fault : scenario.errors.faults)
    std::visit(
        [&](const auto& one) {
          std::string name = one.kName;
          std::replace(name.begin(), name.end(), '_', ' ');
          moments.push_back({one.from_s, "fault", fmt::format("{} for {} s", name, one.duration_s)});
        },
        fault);
  return moments;
}

Message json_message(const ordered_json& content) {
  return {std::make_shared<const std::string>(files::json_text(content)), true, false};
}

Resource json_resource(std::string text) { return resource("application/json", text); }
Resource bytes_resource(std::string bytes) { return resource("application/octet-stream", bytes); }

Site::Site(const std::vector<ShownRun>& runs, ordered_json about) {
  add("/view.js",
      resource("text/javascript; charset=utf-8", {gaitslam_view_script_begin, gaitslam_view_script_end}));
  add("/view.css",
      resource("text/css; charset=utf-8",
               std::string(gaitslam_view_style_begin, gaitslam_view_style_end) + pages::figure_style()));
  add("/icon.svg", resource("image/svg+xml", kIcon));
  about["runs"] = ordered_json::array();
  for (std::size_t i = 0; i < runs.size(); ++i) {
    about["runs"].push_back(to_json(runs[i]));
    if (!runs[i].model) continue;
    add(fmt::format("/model/{}", i), bytes_resource(runs[i].model->pieces));
    add(fmt::format("/pictures/{}", i),
        [paint = runs[i].model->pictures] { return bytes_resource(paint()); });
  }
  add("/about", json_resource(files::json_text(about)));
}

void Site::add(const std::string& path, Resource resource) {
  files_[path] = [resource] { return resource; };
}

void Site::add(const std::string& path, std::function<Resource()> make) {
  files_[path] = [make = std::move(make), made = std::shared_future<Resource>()]() mutable {
    if (!made.valid()) made = std::async(std::launch::async, make).share();
    return made.wait_for(std::chrono::seconds(0)) == std::future_status::ready ? made.get()
                                                                               : bytes_resource("");
  };
}

void Site::add_list(const std::string& folder, std::function<std::optional<Resource>(std::size_t)> element) {
  lists_[folder] = std::move(element);
}

std::optional<Resource> Site::at(std::string_view path, std::string_view token) {
  if (path == "/") return resource("text/html; charset=utf-8", page_with(token));
  if (const auto file = files_.find(path); file != files_.end()) return file->second();
  const std::size_t slash = path.rfind('/');
  if (slash == path.npos) return std::nullopt;
  const auto list = lists_.find(path.substr(0, slash));
  const auto number = files::parse_number<std::size_t>(path.substr(slash + 1));
  return list != lists_.end() && number ? list->second(*number) : std::nullopt;
}

}  // namespace sim::view
