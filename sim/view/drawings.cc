// The time series that the page draws, the feet, and the pictures of a video.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "sim/score/run.h"
#include "sim/view/session.h"
#include "sim/view/site.h"
#include "slam/vision/patch.h"

namespace sim::view {
namespace {

using pages::kDeg, pages::kMm;

constexpr double kLoaded_n = 60, kUnloaded_n = 20;
const cv::Scalar kUsed(80, 220, 60), kMissed(40, 210, 255), kNew(255, 150, 40), kPaper(250, 250, 250),
    kDark(30, 30, 30);

void write(cv::Mat3b& picture, const std::string& text, const cv::Point& at, const cv::Scalar& color) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.5, kDark, 3, cv::LINE_AA);
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.5, color, 1, cv::LINE_AA);
}

}  // namespace

std::optional<Eigen::Vector2d> zero_moment_point(const std::array<SoleForce, 2>& soles) {
  Eigen::Vector2d weighted = Eigen::Vector2d::Zero();
  double load = 0;
  for (const SoleForce& sole : soles) {
    const Eigen::Vector2d from_moments(-sole.torque.y(), sole.torque.x());  // times the force
    weighted += sole.force.z() * sole.place.head<2>() + Eigen::Rotation2Dd(sole.place.z()) * from_moments;
    load += sole.force.z();
  }
  if (load < kUnloaded_n) return std::nullopt;
  return weighted / load;
}

void Series::add(const Frame& frame) {
  // NaN in frames without an estimate.
  const pages::FrameError e = error_of(frame).value_or(pages::FrameError{});
  Row row;
  row.fill(NAN);
  row[0] = slam::seconds(frame.t);
  for (int axis = 0; axis < 4; ++axis) {
    const double factor = axis == 3 ? kDeg : kMm;
    row[1 + static_cast<std::size_t>(axis)] = factor * e.error(axis);
    row[5 + static_cast<std::size_t>(axis)] = factor * e.sigma(axis);
  }
  row[9] = e.nees.position;
  if (frame.report) {
    row[10] = frame.report->landmarks;
    row[19] = static_cast<double>(frame.report->health);
    row[11] = frame.report->accepted;
    for (std::size_t i = 0; i < score::kSensors.size(); ++i)
      if (const auto nis = slam::nis_of(frame.report->innovations, score::kSensors[i]); nis && nis->dof > 0)
        row[15 + i] = nis->value / nis->dof;
  }
  for (std::size_t i = 0; frame.feet && i < 2; ++i) row[12 + i] = kMm * (*frame.feet)[i].slip_m;
  row[14] = kMm * frame.margin_m;
  rows_.push_back(row);
}

void Footing::add(Frame& frame) {
  frame.support.clear();
  std::vector<cv::Point2f> corners;
  for (std::size_t i = 0; frame.feet && i < 2; ++i) {
    FootPlace& foot = (*frame.feet)[i];
    if (foot.load_n > kLoaded_n && !landed_[i]) landed_[i] = foot.truth;
    if (foot.load_n < kUnloaded_n) landed_[i].reset();
    foot.landed = landed_[i];
    if (landed_[i]) foot.slip_m = (foot.truth - *landed_[i]).head<2>().norm();
    for (int k = 0; sole_ && foot.load_n > kUnloaded_n && k < 4; ++k) {
      const Eigen::Vector2d corner = sole_->corner(Eigen::AlignedBox2d::CornerType(k)),
                            p = foot.truth.head<2>() + Eigen::Rotation2Dd(foot.truth.z()) * corner;
      corners.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
    }
  }
  if (corners.empty()) return;
  cv::convexHull(corners, frame.support);
  if (!frame.zmp) return;
  const cv::Point2f zmp(static_cast<float>(frame.zmp->x()), static_cast<float>(frame.zmp->y()));
  frame.margin_m = cv::pointPolygonTest(frame.support, zmp, true);
}

std::string Series::bytes() const {
  std::string bytes = with_length(nlohmann::json(kNames).dump());
  for (std::size_t column = 0; column < kNames.size(); ++column)
    for (const Row& row : rows_) {
      const auto value = static_cast<float>(row[column]);
      bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
  return bytes;
}

cv::Mat3b draw_view(const slam::Observation& seen, const slam::FrameReport& report) {
  cv::Mat3b picture(kPanelHeight, kPanelWidth, cv::Vec3b(30, 30, 30));
  double scale = 1;
  if (seen.image.empty()) {
    write(picture, "no image", {280, 240}, kMissed);
  } else {
    scale = std::min(1.0 * kPanelWidth / seen.image.cols, 1.0 * kPanelHeight / seen.image.rows);
    cv::Mat large, color;
    cv::resize(seen.image, large, {}, scale, scale, cv::INTER_LINEAR);
    cv::cvtColor(large, color, cv::COLOR_GRAY2BGR);
    color.copyTo(picture(cv::Rect({0, 0}, color.size())));
  }
  const auto at = [&](const Eigen::Vector2d& pixel) {
    return cv::Point2d(scale * (pixel.x() + 0.5), scale * (pixel.y() + 0.5));
  };
  const auto patch = [&](const Eigen::Vector2d& pixel, const cv::Scalar& color) {
    const double half = (slam::kPatchHalf + 0.5) * scale;
    const cv::Point2d corner(half, half);
    cv::rectangle(picture, at(pixel) - corner, at(pixel) + corner, color, 1, cv::LINE_AA);
  };
  for (const slam::Search& search : report.searched) {
    const Eigen::Vector3d shape = pages::ellipse(scale * scale * search.S);
    if (!(shape.allFinite() && shape(0) < 1e4)) continue;
    const cv::Size2d size(2 * shape(0), 2 * shape(1));
    const cv::RotatedRect ellipse(at(search.pixel), size, static_cast<float>(kDeg * shape(2)));
    cv::ellipse(picture, ellipse, search.used ? kUsed : kMissed, 1, cv::LINE_AA);
  }
  for (const slam::Sighting& match : report.matched) patch(match.pixel, kUsed);
  for (const slam::Sighting& first : report.initialized) patch(first.pixel, kNew);
  cv::Mat below = picture.rowRange(kPanelHeight - 48, kPanelHeight);
  below *= 0.3;
  write(picture, "squares: matched (blue: new); ellipses: searched (yellow: not found)",
        {8, kPanelHeight - 30}, kPaper);
  write(picture,
        fmt::format("{:.2f} s   {} landmarks, {} searched for, {} matched", slam::seconds(report.t),
                    report.landmarks, report.searched.size(), report.accepted),
        {8, kPanelHeight - 10}, kPaper);
  return picture;
}

}  // namespace sim::view
