#include "sim/view/shown_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

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

void put_number(std::string& to, std::uint32_t x) {
  for (int byte = 0; byte < 4; ++byte) to += static_cast<char>(x >> 8 * byte & 0xff);
}

// Numbers of four bytes, as this little-endian machine has them.
template <typename Number>
void put_all(std::string& to, const std::vector<Number>& numbers) {
  static_assert(sizeof(Number) == 4);
  to.append(reinterpret_cast<const char*>(numbers.data()), 4 * numbers.size());
}

std::string heads(const Model& model) {
  std::string list = "[";
  for (const ModelPiece& piece : model.pieces)
    list += fmt::format("{}{{\"body\":{},\"picture\":{},\"vertices\":{},\"indices\":{}}}",
                        list.size() > 1 ? "," : "", piece.body, piece.picture, piece.positions.size() / 3,
                        piece.indices.size());
  list += "]";
  list.append((4 - list.size() % 4) % 4, ' ');
  return list;
}

}  // namespace

std::string model_bytes(const Model& model) {
  const std::string head = heads(model);
  std::string bytes;
  put_number(bytes, static_cast<std::uint32_t>(head.size()));
  bytes += head;
  for (const ModelPiece& piece : model.pieces) {
    for (const auto* const numbers : {&piece.positions, &piece.normals, &piece.colours, &piece.uv})
      put_all(bytes, *numbers);
    put_all(bytes, piece.indices);
  }
  return bytes;
}

std::string picture_bytes(const std::vector<cv::Mat3b>& pictures) {
  std::string bytes;
  for (const cv::Mat3b& picture : pictures) {
    put_number(bytes, static_cast<std::uint32_t>(picture.cols));
    put_number(bytes, static_cast<std::uint32_t>(picture.rows));
    for (int row = 0; row < picture.rows; ++row)
      bytes.append(reinterpret_cast<const char*>(picture.ptr(row)),
                   3 * static_cast<std::size_t>(picture.cols));
  }
  return bytes;
}

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
