#include "sim/pages/scene_data.h"

#include <fmt/core.h>

#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <vector>

#include "sim/files/tum.h"

namespace sim::pages {
namespace {

using nlohmann::ordered_json;

constexpr double kLongest = 4;  // m: a landmark of unknown depth has no end
constexpr int kEvery = 6;       // frames between the poses that the slider visits

double rounded(double value) { return std::round(value * 1e4) / 1e4; }

ordered_json row(const Eigen::Vector3d& v) { return {rounded(v.x()), rounded(v.y()), rounded(v.z())}; }

// The unit sphere mapped by these axes is where normalised errors are 3.
ordered_json ellipsoid(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  const Eigen::Vector3d half = 3 * solver.eigenvalues().cwiseMax(0).cwiseSqrt().cwiseMin(kLongest / 3);
  const Eigen::Matrix3d axes = solver.eigenvectors() * half.asDiagonal();
  ordered_json json = ordered_json::array();
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) json.push_back(std::round(axes(r, c) * 1e4) / 1e4);
  return json;
}

ordered_json line(const Path& path) {
  ordered_json json{{"x", ordered_json::array()}, {"y", ordered_json::array()}, {"z", ordered_json::array()}};
  for (std::size_t i = 0; i < path.t.size(); i += 2) {
    json["x"].push_back(rounded(path.x[i]));
    json["y"].push_back(rounded(path.y[i]));
    json["z"].push_back(rounded(path.z[i]));
  }
  return json;
}

// {p, axes} of one row of a map.
ordered_json landmark(const Eigen::Vector3d& p, const std::array<double, 6>& P) {
  Eigen::Matrix3d covariance;
  covariance << P[0], P[1], P[2], P[1], P[3], P[4], P[2], P[4], P[5];
  return {{"p", row(p)}, {"axes", ellipsoid(covariance)}};
}

// The rows of a map, or of maps over time, in the order of the file.
std::vector<ordered_json> landmarks(const Table& map) {
  constexpr std::array kCovariance{"P_xx", "P_xy", "P_xz", "P_yy", "P_yz", "P_zz"};
  const Column x = map.numbers("p_W_x"), y = map.numbers("p_W_y"), z = map.numbers("p_W_z");
  std::vector<Column> P;
  for (const char* entry : kCovariance) P.push_back(map.numbers(entry));
  std::vector<ordered_json> rows;
  for (std::size_t i = 0; i < map.rows(); ++i)
    rows.push_back(landmark({x[i], y[i], z[i]}, {P[0][i], P[1][i], P[2][i], P[3][i], P[4][i], P[5][i]}));
  return rows;
}

// [{t, landmarks}], by time; the map at the end comes last.
ordered_json maps(const RunData& run) {
  ordered_json json = ordered_json::array();
  if (run.maps) {
    const Column t = run.maps->seconds("timestamp");
    const std::vector<ordered_json> rows = landmarks(*run.maps);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (i == 0 || t[i] != t[i - 1])
        json.push_back({{"t", rounded(t[i])}, {"landmarks", ordered_json::array()}});
      json.back()["landmarks"].push_back(rows[i]);
    }
  }
  const double end = run.estimate->t.empty() ? 0 : run.estimate->t.back();
  json.push_back({{"t", rounded(end)}, {"landmarks", landmarks(*run.map)}});
  return json;
}

ordered_json poses(const std::filesystem::path& file) {
  ordered_json json = ordered_json::array();
  const auto rows = files::read_tum(file);
  for (std::size_t i = 0; i < rows.size(); i += kEvery) {
    const Eigen::Quaterniond q(rows[i].X.linear());
    const double t = 1e-9 * static_cast<double>(rows[i].t.count());
    json.push_back(
        {{"t", rounded(t)},
         {"p", row(rows[i].X.translation())},
         {"q", {rounded(q.x()), rounded(q.y()), rounded(q.z()), rounded(q.w())}},
         {"axes", ellipsoid(rows[i].covariance ? rows[i].covariance->bottomRightCorner<3, 3>().eval()
                                               : Eigen::Matrix3d::Zero().eval())}});
  }
  return json;
}

}  // namespace

ordered_json scene_data(const RunData& run) {
  return {{"plan", line(run.plan)},
          {"truth", line(run.truth)},
          {"estimate", line(*run.estimate)},
          {"maps", maps(run)},
          {"poses", poses(run.folder / "estimate_cov.txt")}};
}

}  // namespace sim::pages
