#include <map>

#include "sim/files/csv.h"
#include "sim/recording/map_file.h"
#include "sim/result/result.h"

namespace sim::result {
namespace {

// A pose without covariance has eight columns in both files.
void write_estimate(const fs::path& folder, const tracking::Tracked& tracked) {
  std::string poses, smoothed, with_covariance = files::kTumCovarianceHeader;
  for (const estimators::PoseEstimate& e : tracked.estimates()) {
    poses += files::tum_row(e.t, e.X_WC);
    with_covariance +=
        e.covariance ? files::tum_row(e.t, e.X_WC, *e.covariance) : files::tum_row(e.t, e.X_WC);
  }
  for (const estimators::PoseEstimate& e : tracked.smoothed) smoothed += files::tum_row(e.t, e.X_WC);
  if (!tracked.log.empty()) files::write_text(folder / "estimator.log", tracked.log);
  files::write_text(folder / "estimate.tum", poses);
  if (!smoothed.empty()) files::write_text(folder / "estimate_smoothed.tum", smoothed);
  files::write_text(folder / "estimate_cov.txt", with_covariance);
}

constexpr std::string_view kPointColumns =
    "p_W_x [m],p_W_y [m],p_W_z [m],P_xx [m^2],P_xy [m^2],P_xz [m^2],P_yy [m^2],P_yz [m^2],P_zz [m^2]";

std::string_view name(slam::Health health) {
  constexpr std::array<std::string_view, 3> kNames{"ok", "lost", "diverged"};
  return kNames[std::size_t(health)];
}

// The row of frames.csv.
std::string frame_row(const slam::FrameReport& r) {
  std::string text = fmt::format("{},{},{},{},{},{},{}", r.t.count(), r.landmarks, r.predicted, r.measured,
                                 r.accepted, r.initialized.size(), r.deleted.size());
  for (const std::string_view sensor : score::kSensors) {
    const auto nis = slam::nis_of(r.innovations, sensor);
    text += nis ? fmt::format(",{},{}", nis->value, nis->dof) : ",,";
  }
  return text + fmt::format(",{},{},{},{}\n", name(r.health), files::csv_field(r.cause.value_or("")),
                            files::csv_field(r.refused.text()), files::csv_field(r.suspect.value_or("")));
}

/// Returns ",u,v" for a match, or two empty fields.
std::string fields_if(bool holds, const std::optional<Eigen::Vector2d>& match) {
  return holds && match ? fmt::format(",{:.3f},{:.3f}", match->x(), match->y()) : ",,";
}

void write_frames(const fs::path& folder, const std::vector<tracking::TrackedFrame>& all) {
  std::string frames = "#timestamp [ns],landmarks,predicted,measured,accepted,begun,deleted",
              landmarks = "#landmark,begun [ns],u [px],v [px],ended [ns]\n",
              searches =
                  "#timestamp [ns],landmark,u [px],v [px],S_uu [px^2],S_uv [px^2],S_vv [px^2],found_u [px],"
                  "found_v [px],refused_u [px],refused_v [px]\n",
              depths;
  for (const std::string_view sensor : score::kSensors) frames += fmt::format(",nis_{0},dof_{0}", sensor);
  frames += ",health,cause,refused,suspect\n";
  std::map<int, slam::Stamp> ends;
  for (const tracking::TrackedFrame& frame : all)
    for (const int landmark : frame.report.deleted) ends[landmark] = frame.report.t;
  for (const tracking::TrackedFrame& frame : all) {
    const slam::FrameReport& r = frame.report;
    frames += frame_row(r);
    for (const slam::Sighting& first : r.initialized)
      landmarks +=
          fmt::format("{},{},{},{},{}\n", first.landmark, r.t.count(), first.pixel.x(), first.pixel.y(),
                      ends.contains(first.landmark) ? std::to_string(ends[first.landmark].count()) : "");
    for (const slam::Search& s : r.searched)
      searches += fmt::format("{},{},{:.3f},{:.3f},{:.3f},{:.3f},{:.3f}{}{}\n", r.t.count(), s.landmark,
                              s.pixel.x(), s.pixel.y(), s.S(0, 0), s.S(0, 1), s.S(1, 1),
                              fields_if(s.used, s.match), fields_if(!s.used, s.match));
    for (const slam::DepthHypotheses& line : r.lines)
      for (const slam::DepthParticle& p : line.particles)
        depths += fmt::format("{},{},{:.4g},{:.3g}\n", r.t.count(), line.landmark, p.depth_m, p.probability);
  }
  files::write_text(folder / "frames.csv", frames);
  files::write_text(folder / "landmarks.csv", landmarks);
  files::write_text(folder / "searches.csv", searches);
  if (!depths.empty())
    files::write_text(folder / "depths.csv", "#timestamp [ns],landmark,depth [m],probability\n" + depths);
}

void write_maps(const fs::path& folder, const tracking::Tracked& tracked) {
  std::string last = fmt::format("#id,kind,{},begun [ns],attempts,successes\n", kPointColumns),
              over_time = fmt::format("#timestamp [ns],id,{}\n", kPointColumns);
  for (const slam::MapPoint& point : tracked.map) {
    const Eigen::Matrix3d& P = point.covariance;
    last += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", point.id, point.kind, point.p_W.x(),
                        point.p_W.y(), point.p_W.z(), P(0, 0), P(0, 1), P(0, 2), P(1, 1), P(1, 2), P(2, 2),
                        point.initialized.count(), point.attempts, point.successes);
  }
  for (const tracking::TimedMap& map : tracked.maps)
    for (const slam::MapPoint& point : map.points) {
      const Eigen::Matrix3d& P = point.covariance;
      over_time += fmt::format("{},{},{:.4f},{:.4f},{:.4f},{:.3e},{:.3e},{:.3e},{:.3e},{:.3e},{:.3e}\n",
                               map.t.count(), point.id, point.p_W.x(), point.p_W.y(), point.p_W.z(), P(0, 0),
                               P(0, 1), P(0, 2), P(1, 1), P(1, 2), P(2, 2));
    }
  files::write_text(folder / "map.csv", last);
  files::write_text(folder / "map_over_time.csv", over_time);
}

}  // namespace

void write_answers(const fs::path& file, const tracking::Tracked& tracked, slam::Stamp exposure) {
  std::vector<std::pair<slam::Stamp, std::string>> rows;
  for (const tracking::TrackedFrame& frame : tracked.frames)
    rows.emplace_back(frame.report.t, fmt::format("{},{}", (frame.effect + exposure).count(),
                                                  1e3 * slam::seconds(frame.took)));
  for (const slam::Stamp t : tracked.dropped) rows.emplace_back(t, ",");
  std::ranges::stable_sort(rows, {}, [](const auto& row) { return row.first; });
  std::string text = "#timestamp [ns],effect [ns],took [ms]\n";
  for (const auto& [t, fields] : rows) text += fmt::format("{},{}\n", t.count(), fields);
  files::write_text(file, text);
}

void write_tracked(const fs::path& folder, const tracking::Tracked& tracked) {
  write_estimate(folder, tracked);
  write_frames(folder, tracked.frames);
  write_maps(folder, tracked);
  if (tracked.saved_map) files::write_text(folder / "map.bin", recording::map_bytes(*tracked.saved_map));
}

}  // namespace sim::result
