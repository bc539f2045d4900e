#include "sim/view/frame.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "sim/files/json.h"
#include "sim/score/consistency.h"
#include "sim/score/trajectory.h"

namespace sim::view {
namespace {

constexpr double kSigmas = 3;  // of every ellipse and ellipsoid
constexpr double kLeastLoad_n = 20;

/// JSON as it is written.
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
  const Eigen::Matrix3d axes =
      solver.eigenvectors() * (kSigmas * solver.eigenvalues().cwiseMax(0).cwiseSqrt()).asDiagonal();
  return {axes(0, 0), axes(0, 1), axes(0, 2), axes(1, 0), axes(1, 1),
          axes(1, 2), axes(2, 0), axes(2, 1), axes(2, 2)};
}

double sigma_yaw(const Eigen::Isometry3d& X_WC, const files::Matrix6d& P) {
  const Eigen::Vector3d vertical_C = X_WC.linear().transpose() * Eigen::Vector3d::UnitZ();
  return std::sqrt(std::max(0.0, vertical_C.dot(P.topLeftCorner<3, 3>() * vertical_C)));
}

void write_errors(Text& out, const Frame& frame) {
  const Eigen::Vector3d e = frame.estimate->translation() - frame.truth->translation();
  const double turn = score::yaw(frame.estimate->linear() * frame.truth->linear().transpose());
  out.key("error").list(std::array{e.x(), e.y(), e.z(), turn}, 5);
  if (!frame.covariance) return;
  if (const auto nees = score::pose_nees(*frame.truth, *frame.estimate, *frame.covariance))
    out.key("nees").number(nees->position, 3);
}

void write_sigmas(Text& out, const Frame& frame) {
  const files::Matrix6d& P = *frame.covariance;
  out.key("sigma").list(
      std::array{std::sqrt(P(3, 3)), std::sqrt(P(4, 4)), std::sqrt(P(5, 5)), sigma_yaw(*frame.estimate, P)},
      5);
  out.key("ellipsoid").list(ellipsoid(P.bottomRightCorner<3, 3>()), 5);
}

const char* outcome(const slam::Search& search) {
  return search.used ? "found" : search.match ? "refused" : "missed";
}

// [landmark, u, v, half axes, angle of the longer one, outcome, place of the match]
void write_search(Text& out, const slam::Search& search) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(search.S);
  const Eigen::Vector2d half = kSigmas * solver.eigenvalues().cwiseMax(0).cwiseSqrt(),
                        along = solver.eigenvectors().col(1);
  out.raw(fmt::format("[{},", search.landmark));
  for (const double x : {search.pixel.x(), search.pixel.y(), half(1), half(0)}) out.number(x, 2).raw(",");
  out.number(std::atan2(along.y(), along.x()), 3).raw(fmt::format(",\"{}\"", outcome(search)));
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
  out.key("begun").objects(report.initialized,
                           [&](const slam::Sighting& first) { out.list(first.pixel, 2); });
}

void write_foot(Text& out, const FootPlace& foot) {
  out.raw("{\"truth\":").list(foot.truth).raw(",\"plan\":").list(foot.plan);
  out.raw(fmt::format(",\"planned_down\":{},\"load\":{:.0f}}}", foot.planned_down, foot.load_n));
}

void write_places(Text& out, const Frame& frame) {
  if (!frame.bodies.empty()) out.key("bodies").list(frame.bodies);
  if (frame.truth) out.key("truth").list(numbers(*frame.truth), 5);
  if (frame.plan) out.key("plan").list(numbers(*frame.plan), 5);
  if (frame.estimate) out.key("estimate").list(numbers(*frame.estimate), 5);
  if (frame.feet) out.key("feet").objects(*frame.feet, [&](const FootPlace& foot) { write_foot(out, foot); });
  if (frame.zmp) out.key("zmp").list(*frame.zmp);
  if (frame.planned_zmp) out.key("planned_zmp").list(*frame.planned_zmp);
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

Eigen::Vector2d turned(double yaw, const Eigen::Vector2d& v) { return Eigen::Rotation2Dd(yaw) * v; }

}  // namespace

std::optional<Eigen::Vector2d> zero_moment_point(const std::array<SoleForce, 2>& soles) {
  Eigen::Vector2d weighted = Eigen::Vector2d::Zero();
  double load = 0;
  for (const SoleForce& sole : soles) {
    const Eigen::Vector2d from_moments(-sole.torque.y(), sole.torque.x());  // times the force
    weighted += sole.force.z() * sole.place.head<2>() + turned(sole.place.z(), from_moments);
    load += sole.force.z();
  }
  if (load < kLeastLoad_n) return std::nullopt;
  return weighted / load;
}

std::string state_in_words(const slam::FrameReport& report) {
  constexpr std::array kHealth{"tracking", "lost", "diverged"};
  std::string words = kHealth[static_cast<std::size_t>(report.health)];
  if (!report.cause.empty()) words += ": " + report.cause;
  if (report.health == slam::Health::ok && report.searched.empty()) words += ", no landmark searched for";
  if (report.relocalized) words += "; recognised its map";
  if (!report.suspect.empty()) words += "; " + report.suspect;
  if (!report.refused.empty()) words += "; refused: " + report.refused;
  return words;
}

std::string to_json(const Frame& frame) {
  Text out;
  out.raw("{").key("t").number(slam::seconds(frame.t), 6);
  if (!frame.image.empty()) out.key("image").list(std::array{frame.image.cols, frame.image.rows}, 0);
  write_places(out, frame);
  if (frame.truth && frame.estimate) write_errors(out, frame);
  if (frame.estimate && frame.covariance) write_sigmas(out, frame);
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

}  // namespace sim::view
