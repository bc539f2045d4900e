#include "sim/report/scene_data.h"

#include <fmt/core.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "sim/stream/tum.h"

namespace sim::report {
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
    for (int c = 0; c < 3; ++c) json.push_back(std::round(axes(r, c) * 1e6) / 1e6);
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

ordered_json landmarks(const Table& map) {
  const Column x = map.numbers("p_W_x"), y = map.numbers("p_W_y"), z = map.numbers("p_W_z");
  const Column xx = map.numbers("P_xx"), xy = map.numbers("P_xy"), xz = map.numbers("P_xz");
  const Column yy = map.numbers("P_yy"), yz = map.numbers("P_yz"), zz = map.numbers("P_zz");
  const Column begun = map.seconds("begun");
  std::vector<std::pair<double, ordered_json>> all;
  for (std::size_t i = 0; i < map.rows(); ++i) {
    Eigen::Matrix3d P;
    P << xx[i], xy[i], xz[i], xy[i], yy[i], yz[i], xz[i], yz[i], zz[i];
    all.push_back(
        {begun[i], {{"p", row({x[i], y[i], z[i]})}, {"axes", ellipsoid(P)}, {"begun", rounded(begun[i])}}});
  }
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  ordered_json json = ordered_json::array();
  for (auto& landmark : all) json.push_back(std::move(landmark.second));
  return json;
}

ordered_json poses(const std::filesystem::path& file) {
  ordered_json json = ordered_json::array();
  const auto rows = stream::read_tum(file);
  for (std::size_t i = 0; i < rows.size(); i += kEvery) {
    const Eigen::Quaterniond q(rows[i].X.linear());
    const double t = 1e-9 * static_cast<double>(rows[i].t.count());
    json.push_back({{"t", rounded(t)},
                    {"p", row(rows[i].X.translation())},
                    {"q", {rounded(q.x()), rounded(q.y()), rounded(q.z()), rounded(q.w())}},
                    {"axes", ellipsoid(rows[i].covariance->bottomRightCorner<3, 3>())}});
  }
  return json;
}

}  // namespace

ordered_json scene_data(const RunData& run) {
  return {{"plan", line(run.plan)},
          {"truth", line(run.truth)},
          {"estimate", line(*run.estimate)},
          {"landmarks", landmarks(*run.map)},
          {"poses", poses(run.folder / "estimate_cov.txt")}};
}

}  // namespace sim::report
