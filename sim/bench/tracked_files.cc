#include "sim/bench/tracked_files.h"

#include <fmt/core.h>

#include <array>
#include <fstream>
#include <string_view>

#include "sim/stream/file_error.h"

namespace sim::bench {
namespace {

namespace fs = std::filesystem;

void write(const fs::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  out.close();
  if (!out) throw stream::FileError(file, "cannot be written");
}

std::string_view name(slam::Health health) {
  constexpr std::array<std::string_view, 3> kNames{"ok", "lost", "diverged"};
  return kNames[static_cast<std::size_t>(health)];
}

std::string nis_fields(const std::optional<slam::Nis>& nis) {
  return nis ? fmt::format(",{},{}", nis->value, nis->dof) : ",,";
}

void write_frames(const fs::path& folder, const Tracked& tracked) {
  std::string text =
      "#timestamp "
      "[ns],landmarks,predicted,measured,accepted,begun,deleted,nis_vision,dof_vision,nis_gyro,dof_gyro,"
      "nis_plan_velocity,dof_plan_velocity,nis_height,dof_height,health,cause,refused\n";
  for (const TrackedFrame& frame : tracked.frames) {
    const slam::FrameReport& r = frame.report;
    text += fmt::format("{},{},{},{},{},{},{}", r.t.count(), r.landmarks, r.predicted, r.measured, r.accepted,
                        r.begun.size(), r.deleted.size());
    for (const auto& nis : {r.vision, r.gyro, r.plan_velocity, r.height}) text += nis_fields(nis);
    text += fmt::format(",{},{},{}\n", name(r.health), r.cause, r.refused);
  }
  write(folder / "frames.csv", text);
}

void write_map(const fs::path& folder, const Tracked& tracked) {
  std::string text =
      "#id,kind,p_W_x [m],p_W_y [m],p_W_z [m],P_xx [m^2],P_xy [m^2],P_xz [m^2],P_yy [m^2],P_yz [m^2],P_zz "
      "[m^2],"
      "begun [ns],attempts,successes\n";
  for (const slam::MapPoint& point : tracked.map) {
    const Eigen::Matrix3d& P = point.covariance;
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", point.id, point.kind, point.p_W.x(),
                        point.p_W.y(), point.p_W.z(), P(0, 0), P(0, 1), P(0, 2), P(1, 1), P(1, 2), P(2, 2),
                        point.begun.count(), point.attempts, point.successes);
  }
  write(folder / "map.csv", text);
}

void write_maps(const fs::path& folder, const Tracked& tracked) {
  std::string text =
      "#timestamp [ns],id,p_W_x [m],p_W_y [m],p_W_z [m],P_xx [m^2],P_xy [m^2],P_xz [m^2],P_yy [m^2],P_yz "
      "[m^2],"
      "P_zz [m^2]\n";
  for (const TimedMap& map : tracked.maps)
    for (const slam::MapPoint& point : map.points) {
      const Eigen::Matrix3d& P = point.covariance;
      text += fmt::format("{},{},{:.4f},{:.4f},{:.4f},{:.3e},{:.3e},{:.3e},{:.3e},{:.3e},{:.3e}\n",
                          map.t.count(), point.id, point.p_W.x(), point.p_W.y(), point.p_W.z(), P(0, 0),
                          P(0, 1), P(0, 2), P(1, 1), P(1, 2), P(2, 2));
    }
  write(folder / "map_over_time.csv", text);
}

/// ",u,v" of the accepted match of a landmark, or two empty fields.
std::string found(const slam::FrameReport& report, int landmark) {
  for (const slam::Sighting& match : report.matched)
    if (match.landmark == landmark) return fmt::format(",{:.3f},{:.3f}", match.pixel.x(), match.pixel.y());
  return ",,";
}

void write_searches(const fs::path& folder, const Tracked& tracked) {
  std::string text =
      "#timestamp [ns],landmark,u [px],v [px],S_uu [px^2],S_uv [px^2],S_vv [px^2],found_u [px],found_v "
      "[px]\n";
  for (const TrackedFrame& frame : tracked.frames)
    for (const slam::Search& s : frame.report.searched)
      text += fmt::format("{},{},{:.3f},{:.3f},{:.3f},{:.3f},{:.3f}{}\n", frame.report.t.count(), s.landmark,
                          s.pixel.x(), s.pixel.y(), s.S(0, 0), s.S(0, 1), s.S(1, 1),
                          found(frame.report, s.landmark));
  write(folder / "searches.csv", text);
}

void write_depths(const fs::path& folder, const Tracked& tracked) {
  std::string text;
  for (const TrackedFrame& frame : tracked.frames)
    for (const slam::DepthHypotheses& line : frame.report.lines)
      for (const slam::DepthParticle& p : line.particles)
        text += fmt::format("{},{},{:.4g},{:.3g}\n", frame.report.t.count(), line.landmark, p.depth_m,
                            p.probability);
  if (!text.empty()) write(folder / "depths.csv", "#timestamp [ns],landmark,depth [m],probability\n" + text);
}

}  // namespace

void write_tracked(const fs::path& folder, const Tracked& tracked) {
  write_frames(folder, tracked);
  write_map(folder, tracked);
  write_maps(folder, tracked);
  write_searches(folder, tracked);
  write_depths(folder, tracked);
}

}  // namespace sim::bench
