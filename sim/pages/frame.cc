#include "sim/pages/frame.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "sim/files/contained_path.h"
#include "sim/files/csv.h"
#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/recording/image_file.h"
#include "sim/recording/recording.h"
#include "sim/score/consistency.h"
#include "sim/score/trajectory.h"

namespace sim::pages {
namespace {

namespace fs = std::filesystem;
constexpr double kSigmas = 3;     // of every ellipse and ellipsoid
constexpr double kLongest_m = 4;  // half axis as drawn: the depth of a new landmark has no end

/// JSON written key by key.
class Text {
 public:
  Text& raw(std::string_view text) {
    out_ += text;
    return *this;
  }
  Text& number(double x, int decimals = 4) {
    if (!std::isfinite(x)) return raw("null");
    fmt::format_to(std::back_inserter(out_), "{:.{}f}", x, decimals);
    return *this;
  }
  Text& list(const auto& numbers, int decimals = 4) {
    char before = '[';
    for (const double x : numbers) {
      out_ += before;
      number(x, decimals);
      before = ',';
    }
    return raw(before == '[' ? "[]" : "]");
  }
  Text& key(std::string_view name) {
    out_ += out_.back() == '{' ? "\"" : ",\"";
    out_ += name;
    return raw("\":");
  }
  Text& text(std::string_view words) { return raw(files::json_text(nlohmann::ordered_json(words))); }
  template <typename List, typename Write>
  Text& objects(const List& list, const Write& write) {
    raw("[");
    bool first = true;
    for (const auto& one : list) {
      if (!std::exchange(first, false)) raw(",");
      write(one);
    }
    return raw("]");
  }
  std::string take() { return std::move(out_); }

 private:
  std::string out_;
};

std::array<double, 7> numbers(const Eigen::Isometry3d& X) {
  const Eigen::Quaterniond q(X.linear());
  const Eigen::Vector3d p = X.translation();
  return {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()};
}

// Rows of the matrix that maps the unit sphere to the ellipsoid of kSigmas.
std::array<double, 9> ellipsoid(const Eigen::Matrix3d& P) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(P);
  const Eigen::Vector3d half = (kSigmas * solver.eigenvalues().cwiseMax(0).cwiseSqrt()).cwiseMin(kLongest_m);
  const Eigen::Matrix3d axes = solver.eigenvectors() * half.asDiagonal();
  return {axes(0, 0), axes(0, 1), axes(0, 2), axes(1, 0), axes(1, 1),
          axes(1, 2), axes(2, 0), axes(2, 1), axes(2, 2)};
}

const char* outcome(const slam::Search& search) {
  return search.used ? "found" : search.match ? "rejected" : "missed";
}

// [landmark, u, v, half axes, angle of the longer one, outcome, place of the match]
void write_search(Text& out, const slam::Search& search) {
  const Eigen::Vector3d shape = ellipse(search.S);
  out.raw(fmt::format("[{},", search.landmark));
  for (const double x : {search.pixel.x(), search.pixel.y(), shape(0), shape(1)}) out.number(x, 2).raw(",");
  out.number(shape(2), 3).raw(fmt::format(",\"{}\"", outcome(search)));
  if (search.match) out.raw(",").number(search.match->x(), 2).raw(",").number(search.match->y(), 2);
  out.raw("]");
}

void write_report(Text& out, const slam::FrameReport& report) {
  out.key("landmarks").raw(fmt::format("{}", report.landmarks));
  out.key("health").raw(fmt::format("{}", static_cast<int>(report.health)));
  out.key("state").text(state_in_words(report));
  out.key("searches").objects(report.searched, [&](const slam::Search& search) {
    write_search(out, search);
  });
  out.key("new").objects(report.initialized, [&](const slam::Sighting& first) { out.list(first.pixel, 2); });
}

void write_foot(Text& out, const FootPlace& foot) {
  out.raw("{\"truth\":").list(foot.truth).raw(",\"plan\":").list(foot.plan);
  out.raw(fmt::format(",\"planned_down\":{},\"load\":{:.0f}", foot.planned_down, foot.load_n));
  if (foot.landed) out.key("landed").list(*foot.landed);
  out.raw("}");
}

void write_places(Text& out, const Frame& frame) {
  if (!frame.bodies.empty()) out.key("bodies").list(frame.bodies);
  if (frame.truth) out.key("truth").list(numbers(*frame.truth), 5);
  if (frame.plan) out.key("plan").list(numbers(*frame.plan), 5);
  if (frame.estimate) out.key("estimate").list(numbers(*frame.estimate), 5);
  if (frame.feet) out.key("feet").objects(*frame.feet, [&](const FootPlace& foot) { write_foot(out, foot); });
  if (frame.zmp) out.key("zmp").list(*frame.zmp);
  if (frame.planned_zmp) out.key("planned_zmp").list(*frame.planned_zmp);
  if (!frame.support.empty())
    out.key("support").objects(frame.support, [&](const Eigen::Vector2d& corner) { out.list(corner); });
}

void write_map(Text& out, const std::vector<slam::MapPoint>& map) {
  out.key("map").objects(map, [&](const slam::MapPoint& point) {
    out.raw(fmt::format("[{},", point.id))
        .list(point.p_W, 3)
        .raw(",")
        .list(ellipsoid(point.covariance), 3)
        .raw("]");
  });
}

}  // namespace

std::string state_in_words(const slam::FrameReport& report) {
  constexpr std::array kHealth{"tracking", "lost", "diverged"};
  std::string words = kHealth[static_cast<std::size_t>(report.health)];
  if (!report.cause.empty()) words += ": " + report.cause;
  if (report.health == slam::Health::ok && report.searched.empty()) words += ", no landmark searched for";
  if (report.relocalized) words += "; recognized its map";
  if (!report.suspect.empty()) words += "; " + report.suspect;
  if (!report.refused.empty()) words += "; rejected: " + report.refused;
  return words;
}

std::optional<FrameError> error_of(const Frame& frame) {
  if (!frame.truth || !frame.estimate) return std::nullopt;
  const Eigen::Vector3d e = frame.estimate->translation() - frame.truth->translation();
  FrameError all;
  all.error << e, score::yaw(frame.estimate->linear() * frame.truth->linear().transpose());
  if (!frame.covariance) return all;
  const files::Matrix6d& P = *frame.covariance;
  all.sigma << P.diagonal().tail<3>().cwiseSqrt(), sigma_yaw(*frame.estimate, P);
  if (const auto nees = score::pose_nees(*frame.truth, *frame.estimate, P)) all.nees = nees->position;
  return all;
}

double sigma_yaw(const Eigen::Isometry3d& X_WC, const files::Matrix6d& covariance) {
  const Eigen::Vector3d vertical_C = X_WC.linear().transpose() * Eigen::Vector3d::UnitZ();
  const double variance = vertical_C.dot(covariance.topLeftCorner<3, 3>() * vertical_C);
  return variance < 0 ? 0 : std::sqrt(variance);
}

Eigen::Vector3d ellipse(const Eigen::Matrix2d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(covariance);
  const Eigen::Vector2d half = kSigmas * solver.eigenvalues().cwiseMax(0).cwiseSqrt(),
                        along = solver.eigenvectors().col(1);
  return {half(1), half(0), std::atan2(along.y(), along.x())};
}

std::string to_json(const Frame& frame) {
  Text out;
  out.raw("{").key("t").number(slam::seconds(frame.t), 6);
  if (!frame.image.empty()) out.key("image").list(std::array{frame.image.cols, frame.image.rows}, 0);
  write_places(out, frame);
  if (frame.estimate && frame.covariance)
    out.key("ellipsoid").list(ellipsoid(frame.covariance->bottomRightCorner<3, 3>()), 5);
  if (frame.report) write_report(out, *frame.report);
  if (frame.map) write_map(out, *frame.map);
  return out.raw("}").take();
}

std::string to_message(const Frame& frame) {
  const std::string head = to_json(frame);
  std::string message;
  message.reserve(4 + head.size() + frame.image.total());
  for (int byte = 0; byte < 4; ++byte) message += static_cast<char>(head.size() >> 8 * byte & 0xff);
  message += head;
  for (int row = 0; row < frame.image.rows; ++row)
    message.append(reinterpret_cast<const char*>(frame.image.ptr(row)),
                   static_cast<std::size_t>(frame.image.cols));
  return message;
}

std::vector<fs::path> image_files(const std::vector<Frame>& frames, const fs::path& recording) {
  std::vector<fs::path> images(frames.size());
  const fs::path camera = recording / "mav0/cam0";
  if (recording.empty() || !fs::exists(camera / "data.csv")) return images;
  files::CsvReader list(camera / "data.csv");
  std::size_t row = 0;
  while (list.next()) {
    const slam::Stamp t = slam::Stamp(list.integer(0)) - recording::kEpoch;
    while (row < frames.size() && frames[row].t < t) ++row;
    if (row < frames.size() && frames[row].t == t)
      images[row] = files::contained_path(camera / "data", list.text(1));
  }
  return images;
}

Pictures::Pictures(const fs::path& recording) : folder_(recording), manifest_(recording) {
  const slam::CameraIntrinsics camera = recording::RecordingReader(recording).setup().calibration.camera;
  size_ = {camera.width_px, camera.height_px};
}

std::string Pictures::png(const fs::path& file) const {
  std::string bytes = manifest_.read(file.lexically_relative(folder_).generic_string(), files::kMostOfImage);
  if (!bytes.starts_with("\x89PNG")) throw files::FileError(file, "is not a PNG image");
  recording::require_image_size(file, bytes, size_);
  return bytes;
}

}  // namespace sim::pages
