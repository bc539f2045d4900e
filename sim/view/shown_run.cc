#include "sim/view/shown_run.h"

#include <fmt/format.h>

#include <algorithm>

#include "walking/hrp2.h"

namespace sim::view {
namespace {

using nlohmann::ordered_json;

std::string in_words(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

ordered_json to_json(const slam::CameraIntrinsics& camera) {
  return {{"width", camera.width_px}, {"height", camera.height_px}, {"fu", camera.fu_px},
          {"fv", camera.fv_px},       {"u0", camera.u0_px},         {"v0", camera.v0_px}};
}

ordered_json sole() {
  using namespace walking::hrp2;
  return {kSoleMin.x(), kSoleMin.y(), kSoleMax.x(), kSoleMax.y()};
}

}  // namespace

std::vector<Moment> faults_of(const scenario::Scenario& scenario) {
  std::vector<Moment> moments;
  for (const sensor_errors::Fault& fault : scenario.errors.faults)
    std::visit(
        [&](const auto& one) {
          moments.push_back(
              {one.from_s, "fault", fmt::format("{} for {} s", in_words(one.kName), one.duration_s)});
        },
        fault);
  return moments;
}

ordered_json to_json(const ShownRun& run) {
  ordered_json about{
      {"label", run.label},     {"duration", run.duration_s},         {"sole", sole()},
      {"missing", run.missing}, {"has_model", run.model.has_value()}, {"next_follows", run.next_follows}};
  about["camera"] = run.camera ? to_json(*run.camera) : ordered_json(nullptr);
  about["moments"] = ordered_json::array();
  for (const Moment& moment : run.moments)
    about["moments"].push_back({{"t", moment.t_s}, {"kind", moment.kind}, {"text", moment.text}});
  return about;
}

}  // namespace sim::view
