#include "sim/view/messages.h"

#include <Eigen/Eigenvalues>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/recording/image_file.h"

namespace sim::view {
namespace {

using nlohmann::ordered_json;

/// Returns numbers as a list, rounded to 0.01 mm or 0.00001 rad.
ordered_json list(const auto& numbers) {
  ordered_json all = ordered_json::array();
  for (const double x : numbers) all.push_back(std::round(1e5 * x) / 1e5);
  return all;
}

ordered_json pose(const Eigen::Isometry3d& X) {
  const Eigen::Quaterniond q(X.linear());
  const Eigen::Vector3d p = X.translation();
  return list(std::array{p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()});
}

/// Returns the rows of the matrix that maps the unit sphere to the kSigmas ellipsoid.
ordered_json ellipsoid(const Eigen::Matrix3d& P) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(P);
  const Eigen::Vector3d half = pages::kSigmas * solver.eigenvalues().cwiseMax(0).cwiseSqrt();
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> axes = solver.eigenvectors() * half.asDiagonal();
  return list(axes.reshaped<Eigen::RowMajor>());
}

std::string state_in_words(const slam::FrameReport& report) {
  constexpr std::array kHealth{"tracking", "lost", "diverged"};
  std::string words = kHealth[static_cast<std::size_t>(report.health)];
  if (report.cause) words += ": " + *report.cause;
  if (report.health == slam::Health::ok && report.searched.empty()) words += ", no landmark searched for";
  if (report.relocalized) words += "; recognized its map";
  if (report.suspect) words += "; " + *report.suspect;
  if (report.refused) words += "; rejected: " + report.refused.text();
  return files::sanitize(words);
}

/// [landmark, u, v, half axes, angle of the longer one, outcome, pixel of the match]
ordered_json to_json(const slam::Search& search) {
  const Eigen::Vector3d shape = pages::ellipse(search.S);
  ordered_json all = list(std::array{search.pixel.x(), search.pixel.y(), shape(0), shape(1), shape(2)});
  all.insert(all.begin(), search.landmark);
  all.push_back(search.used ? "found" : search.match ? "rejected" : "missed");
  if (search.match)
    for (const ordered_json& x : list(*search.match)) all.push_back(x);
  return all;
}

void add_report(ordered_json& to, const slam::FrameReport& report) {
  to["landmarks"] = report.landmarks;
  to["health"] = static_cast<int>(report.health);
  to["state"] = state_in_words(report);
  ordered_json searches = ordered_json::array(), begun = ordered_json::array();
  for (const slam::Search& search : report.searched) searches.push_back(to_json(search));
  for (const slam::Sighting& first : report.initialized)
    begun.push_back({first.pixel.x(), first.pixel.y(), first.landmark});
  to["searches"] = std::move(searches), to["new"] = std::move(begun), to["ended"] = report.deleted;
}

ordered_json to_json(const FootPlace& foot) {
  ordered_json all{{"plan", list(foot.plan)}, {"planned_down", foot.planned_down}};
  if (foot.landed) all["landed"] = list(*foot.landed), all["slip"] = pages::kMm * foot.slip_m;
  return all;
}

}  // namespace

ordered_json to_json(const Frame& frame) {
  ordered_json all{{"t", slam::seconds(frame.t)}};
  if (!frame.image.empty()) all["image"] = {frame.image.cols, frame.image.rows};
  if (!frame.bodies.empty()) all["bodies"] = list(frame.bodies);
  for (const auto& [name, X] : {std::pair{"truth", &frame.truth}, std::pair{"plan", &frame.plan},
                                std::pair{"estimate", &frame.estimate}})
    if (*X) all[name] = pose(**X);
  if (frame.feet) all["feet"] = {to_json((*frame.feet)[0]), to_json((*frame.feet)[1])};
  if (frame.zmp) all["zmp"] = list(*frame.zmp);
  for (const cv::Point2f& corner : frame.support)
    all["support"].push_back(list(std::array{corner.x, corner.y}));
  if (std::isfinite(frame.margin_m)) all["margin"] = pages::kMm * frame.margin_m;
  if (frame.estimate && frame.covariance)
    all["ellipsoid"] = ellipsoid(frame.covariance->bottomRightCorner<3, 3>());
  if (frame.report) add_report(all, *frame.report);
  if (frame.rig) all["rig"] = *frame.rig;
  if (!frame.map) return all;
  all["map"] = ordered_json::array();
  for (const slam::MapPoint& point : *frame.map)
    all["map"].push_back(
        {point.id, list(point.p_W), ellipsoid(point.covariance), slam::seconds(point.initialized)});
  return all;
}

std::string with_length(std::string json) {
  json.append(3 - (json.size() + 3) % 4, ' ');
  const auto length = static_cast<std::uint32_t>(json.size());
  return std::string(reinterpret_cast<const char*>(&length), sizeof length) + json;
}

std::string to_message(const Frame& frame) {
  std::string message = with_length(files::json_text(to_json(frame)));
  for (int row = 0; row < frame.image.rows; ++row)
    message.append(reinterpret_cast<const char*>(frame.image.ptr(row)),
                   static_cast<std::size_t>(frame.image.cols));
  return message;
}

std::string sent(const slam::RigReading& reading, const rig::RigSensor& sensor) {
  std::string bytes;
  if (sensor.kind == rig::Kind::depth) {
    const std::array size{reading.image.cols, reading.image.rows};
    bytes.assign(reinterpret_cast<const char*>(size.data()), sizeof size);
    for (int row = 0; row < reading.image.rows; ++row)
      bytes.append(reinterpret_cast<const char*>(reading.image.ptr(row)),
                   reading.image.elemSize() * static_cast<std::size_t>(reading.image.cols));
    return bytes;
  }
  if (rig::is_camera(sensor)) return recording::encode_png(reading.image);
  const Eigen::Isometry3f X_CS = sensor.X_CS.cast<float>();
  for (const slam::LidarPoint& point : reading.points) {
    const Eigen::Vector3f p_C = X_CS * Eigen::Vector3f(point.x_m, point.y_m, point.z_m);
    bytes.append(reinterpret_cast<const char*>(p_C.data()), sizeof(p_C));
    bytes.append(reinterpret_cast<const char*>(&point.intensity), sizeof(point.intensity));
  }
  return bytes;
}

const cv::Mat3b& palette() {
  static const cv::Mat3b kColors = [] {
    cv::Mat levels(1, 256, CV_8U), colors;
    for (int i = 0; i < 256; ++i) levels.at<unsigned char>(i) = static_cast<unsigned char>(i);
    cv::applyColorMap(levels, colors, cv::COLORMAP_TURBO);
    cv::cvtColor(colors, colors, cv::COLOR_BGR2RGB);
    return cv::Mat3b(colors);
  }();
  return kColors;
}

}  // namespace sim::view
