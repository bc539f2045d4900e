#include "sim/pages/frame.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "sim/files/csv.h"
#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/recording/image_file.h"
#include "sim/recording/recording_format.h"
#include "sim/score/trajectory.h"

namespace sim::pages {
namespace {

using nlohmann::ordered_json;
constexpr double kSigmas = 3;     // of every ellipse and ellipsoid
constexpr double kLongest_m = 4;  // half axis as drawn: the depth of a new landmark has no end

/// Numbers as a list, to 0.01 mm or 0.00001 rad.
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

/// Rows of the matrix that maps the unit sphere to the ellipsoid of kSigmas.
ordered_json ellipsoid(const Eigen::Matrix3d& P) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(P);
  const Eigen::Vector3d half = (kSigmas * solver.eigenvalues().cwiseMax(0).cwiseSqrt()).cwiseMin(kLongest_m);
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> axes = solver.eigenvectors() * half.asDiagonal();
  return list(axes.reshaped<Eigen::RowMajor>());
}

/// The state of the filter as a sentence.
std::string state_in_words(const slam::FrameReport& report) {
  constexpr std::array kHealth{"tracking", "lost", "diverged"};
  std::string words = kHealth[static_cast<std::size_t>(report.health)];
  if (!report.cause.empty()) words += ": " + report.cause;
  if (report.health == slam::Health::ok && report.searched.empty()) words += ", no landmark searched for";
  if (report.relocalized) words += "; recognized its map";
  if (!report.suspect.empty()) words += "; " + report.suspect;
  if (!report.refused.empty()) words += "; rejected: " + report.refused;
  return files::sanitize(words);
}

/// [landmark, u, v, half axes, angle of the longer one, outcome, place of the match]
ordered_json to_json(const slam::Search& search) {
  const Eigen::Vector3d shape = ellipse(search.S);
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
  ordered_json searches = ordered_json::array(), initialized = ordered_json::array();
  for (const slam::Search& search : report.searched) searches.push_back(to_json(search));
  for (const slam::Sighting& first : report.initialized) initialized.push_back(list(first.pixel));
  to["searches"] = std::move(searches), to["new"] = std::move(initialized);
}

ordered_json to_json(const FootPlace& foot) {
  ordered_json all{{"truth", list(foot.truth)},
                   {"plan", list(foot.plan)},
                   {"planned_down", foot.planned_down},
                   {"load", std::round(foot.load_n)}};
  if (foot.landed) all["landed"] = list(*foot.landed);
  return all;
}

}  // namespace

std::optional<FrameError> error_of(const Frame& frame) {
  if (!frame.truth || !frame.estimate) return std::nullopt;
  const Eigen::Vector3d e = frame.estimate->translation() - frame.truth->translation();
  FrameError all;
  all.error << e, score::yaw(frame.estimate->linear() * frame.truth->linear().transpose());
  if (!frame.covariance) return all;
  const files::Matrix6d& P = *frame.covariance;
  const Eigen::Vector3d vertical_C = frame.estimate->linear().transpose() * Eigen::Vector3d::UnitZ();
  const double yaw_variance = vertical_C.dot(P.topLeftCorner<3, 3>() * vertical_C);
  all.sigma << P.diagonal().tail<3>().cwiseSqrt(), yaw_variance < 0 ? 0 : std::sqrt(yaw_variance);
  if (const auto nees = score::pose_nees(*frame.truth, *frame.estimate, P)) all.nees = *nees;
  return all;
}

Eigen::Vector3d ellipse(const Eigen::Matrix2d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(covariance);
  const Eigen::Vector2d half = kSigmas * solver.eigenvalues().cwiseMax(0).cwiseSqrt(),
                        along = solver.eigenvectors().col(1);
  return {half(1), half(0), std::atan2(along.y(), along.x())};
}

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
  if (frame.estimate && frame.covariance)
    all["ellipsoid"] = ellipsoid(frame.covariance->bottomRightCorner<3, 3>());
  if (frame.report) add_report(all, *frame.report);
  if (frame.rig) all["rig"] = *frame.rig;
  if (!frame.map) return all;
  all["map"] = ordered_json::array();
  for (const slam::MapPoint& point : *frame.map)
    all["map"].push_back({point.id, list(point.p_W), ellipsoid(point.covariance)});
  return all;
}

std::string to_message(const Frame& frame) {
  const std::string head = files::json_text(to_json(frame));
  std::string message;
  message.reserve(4 + head.size() + frame.image.total());
  for (int byte = 0; byte < 4; ++byte) message += static_cast<char>(head.size() >> 8 * byte & 0xff);
  message += head;
  for (int row = 0; row < frame.image.rows; ++row)
    message.append(reinterpret_cast<const char*>(frame.image.ptr(row)),
                   static_cast<std::size_t>(frame.image.cols));
  return message;
}

std::string shown(const slam::RigReading& reading, const rig::RigSensor& sensor) {
  if (sensor.kind == rig::Kind::depth) {
    const double levels_per_m = 255 / (sensor.furthest_m - sensor.nearest_m);
    cv::Mat levels, colors;
    reading.image.convertTo(levels, CV_8U, 1e-3 * levels_per_m, -levels_per_m * sensor.nearest_m);
    cv::applyColorMap(levels, colors, cv::COLORMAP_TURBO);
    cv::cvtColor(colors, colors, cv::COLOR_BGR2RGB);
    colors.setTo(0, reading.image == 0);
    return recording::encode_png(colors);
  }
  if (rig::is_camera(sensor)) return recording::encode_png(reading.image);
  std::string bytes;
  const Eigen::Isometry3f X_CS = sensor.X_CS.cast<float>();
  for (const slam::LidarPoint& point : reading.points) {
    const Eigen::Vector3f p_C = X_CS * Eigen::Vector3f(point.x_m, point.y_m, point.z_m);
    bytes.append(reinterpret_cast<const char*>(p_C.data()), sizeof(p_C));
  }
  return bytes;
}

std::string words_of(const rig::RigSensor& sensor) {
  if (sensor.kind == rig::Kind::depth)
    return fmt::format("depth from {} m (blue) to {} m (red); black: none", sensor.nearest_m,
                       sensor.furthest_m);
  if (sensor.kind == rig::Kind::lidar) return "lidar, points in the room";
  return sensor.kind == rig::Kind::grey ? "gray" : std::string(rig::kKinds.at(std::size_t(sensor.kind)));
}

std::vector<fs::path> image_files(const std::vector<Frame>& frames, const fs::path& recording,
                                  const std::string& sensor) {
  std::vector<fs::path> images(frames.size());
  const fs::path folder = recording / "mav0" / sensor;
  if (recording.empty() || !fs::exists(folder / "data.csv")) return images;
  files::CsvReader list(folder / "data.csv");
  const bool of_rig = list.titles().size() == 3;  // the last one: the frame that has the reading
  std::size_t row = 0;
  while (list.next()) {
    const slam::Stamp t = slam::Stamp(list.integer(of_rig ? 2 : 0)) - recording::kEpoch;
    while (row < frames.size() && frames[row].t < t) ++row;
    if (row < frames.size() && frames[row].t == t)
      images[row] = files::contained_path(folder / "data", list.text(1));
  }
  for (std::size_t i = 1; of_rig && i < images.size(); ++i)
    if (images[i].empty()) images[i] = images[i - 1];
  return images;
}

Pictures::Pictures(const fs::path& recording)
    : folder_(recording), manifest_(recording), setup_(recording::RecordingReader(recording).setup()) {}

std::string Pictures::png(const fs::path& file) const {
  std::string bytes = manifest_.read(file.lexically_relative(folder_).generic_string(), files::kMostOfImage);
  if (!bytes.starts_with("\x89PNG")) throw files::FileError(file, "is not a PNG image");
  const slam::CameraIntrinsics& camera = setup_.calibration.camera;
  recording::require_image_size(file, bytes, {camera.width_px, camera.height_px});
  return bytes;
}

std::string Pictures::rig(const rig::RigSensor& sensor, const fs::path& file) const {
  return shown(recording::read_rig_file(folder_, manifest_, sensor, file.filename().string()), sensor);
}

}  // namespace sim::pages
