#include "sim/pages/run_data.h"

#include <fmt/format.h>

#include <algorithm>

#include "sim/files/csv.h"
#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/pages/settings.h"
#include "sim/recording/recording_format.h"
#include "sim/score/run.h"

namespace sim::pages {

namespace {

using files::TumRow;

void add(Path& path, slam::Stamp t, const std::optional<Eigen::Isometry3d>& X) {
  const Eigen::Vector3d p = X ? Eigen::Vector3d(X->translation()) : Eigen::Vector3d::Constant(NAN);
  path.t.push_back(slam::seconds(t));
  path.x.push_back(p.x()), path.y.push_back(p.y()), path.z.push_back(p.z());
}

Path read_path(const fs::path& file) {
  Path path;
  for (const TumRow& row : files::read_tum(file)) add(path, row.t, row.X);
  return path;
}

/// True for a frame between two estimates less than 0.25 s apart: such a frame was dropped and is not a gap.
bool is_dropped(const std::vector<Frame>& frames, std::size_t i) {
  std::size_t before = i, after = i;
  while (before > 0 && !frames[before].estimate) --before;
  while (after + 1 < frames.size() && !frames[after].estimate) ++after;
  return before < i && i < after && frames[before].estimate && frames[after].estimate &&
         frames[after].t - frames[before].t < std::chrono::milliseconds(250);
}

/// Returns the path of a pose of all frames, shifted by X in its own axes.
Path path_of(const std::vector<Frame>& frames, std::optional<Eigen::Isometry3d> Frame::*pose,
             const Eigen::Isometry3d& X = Eigen::Isometry3d::Identity()) {
  Path path;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (pose == &Frame::estimate && is_dropped(frames, i)) continue;
    const auto& X_W = frames[i].*pose;
    add(path, frames[i].t, X_W ? std::optional(*X_W * X) : std::nullopt);
  }
  return path;
}

// fitted: the estimate was fitted to the truth, so there is no NEES.
Errors errors_of(const std::vector<Frame>& frames, bool fitted) {
  Errors errors;
  for (std::size_t index = 0; index < frames.size(); ++index) {
    if (is_dropped(frames, index)) continue;
    const Frame& frame = frames[index];
    FrameError e = error_of(frame).value_or(FrameError{});
    if (fitted) e.nees = FrameError{}.nees;
    errors.t.push_back(slam::seconds(frame.t));
    for (std::size_t i = 0; i < 4; ++i) {
      errors.error[i].push_back(e.error(static_cast<Eigen::Index>(i)));
      errors.sigma[i].push_back(e.sigma(static_cast<Eigen::Index>(i)));
    }
    errors.distance.push_back(e.error.head<3>().norm());
    errors.nees_position.push_back(e.nees.position);
    errors.nees_orientation.push_back(e.nees.orientation);
  }
  return errors;
}

/// Returns the frame with a stamp (which other programs round), or null.
Frame* frame_at(std::vector<Frame>& frames, slam::Stamp t) {
  constexpr slam::Stamp kSame = std::chrono::microseconds(100);
  const auto found = std::ranges::lower_bound(frames, t - kSame, {}, &Frame::t);
  return found != frames.end() && found->t <= t + kSame ? &*found : nullptr;
}

/// Calls add(frame, row) for each row of a table whose stamp has a frame.
void for_rows(std::vector<Frame>& frames, const std::vector<slam::Stamp>& stamps, const auto& add) {
  for (std::size_t i = 0; i < stamps.size(); ++i)
    if (Frame* const frame = frame_at(frames, stamps[i])) add(*frame, i);
}

void add_reports(std::vector<Frame>& frames, const Table& table) {
  const auto &health = table.text("health"), &cause = table.text("cause"), &refused = table.text("refused");
  const Column landmarks = table.numbers("landmarks");
  std::vector<std::tuple<std::string_view, Column, Column>> innovations;
  for (const std::string_view sensor : score::kSensors)
    if (const std::string name = fmt::format("nis_{}", sensor); table.has(name))
      innovations.emplace_back(sensor, table.numbers(name), table.numbers(fmt::format("dof_{}", sensor)));
  for_rows(frames, table.stamps("timestamp"), [&](Frame& frame, std::size_t i) {
    slam::FrameReport& report = frame.report.emplace();
    report.t = frame.t;
    report.landmarks = landmarks[i] >= 0 && landmarks[i] < 1e6 ? static_cast<int>(landmarks[i]) : 0;
    report.health = health[i] == "lost"       ? slam::Health::lost
                    : health[i] == "diverged" ? slam::Health::diverged
                                              : slam::Health::ok;
    if (!cause[i].empty()) report.cause = cause[i];
    if (!refused[i].empty()) report.refused.add(refused[i]);
    for (const auto& [sensor, nis, dof] : innovations)
      if (std::isfinite(nis[i]) && dof[i] > 0)
        report.innovations.push_back({sensor, {nis[i], static_cast<int>(dof[i])}});
    if (table.has("suspect") && !table.text("suspect")[i].empty()) report.suspect = table.text("suspect")[i];
  });
}

void add_searches(std::vector<Frame>& frames, const Table& table) {
  const Column landmark = table.numbers("landmark"), u = table.numbers("u"), v = table.numbers("v"),
               uu = table.numbers("S_uu"), uv = table.numbers("S_uv"), vv = table.numbers("S_vv"),
               found_u = table.numbers("found_u"), found_v = table.numbers("found_v"),
               rejected_u = table.numbers("refused_u"), rejected_v = table.numbers("refused_v");
  for_rows(frames, table.stamps("timestamp"), [&](Frame& frame, std::size_t i) {
    if (!frame.report || !(std::abs(landmark[i]) < 1e9)) return;
    slam::Search search{static_cast<int>(landmark[i]), {u[i], v[i]}, Eigen::Matrix2d::Zero()};
    search.S << uu[i], uv[i], uv[i], vv[i];
    if (!search.S.allFinite() || !search.pixel.allFinite()) return;
    search.used = std::isfinite(found_u[i]);
    if (search.used) search.match = {found_u[i], found_v[i]};
    if (std::isfinite(rejected_u[i])) search.match = {rejected_u[i], rejected_v[i]};
    frame.report->searched.push_back(search);
  });
}

void add_landmarks(std::vector<Frame>& frames, const Table& table) {
  const Column id = table.numbers("landmark"), u = table.numbers("u"), v = table.numbers("v");
  const auto number = [&](std::size_t i) { return std::abs(id[i]) < 1e9 ? static_cast<int>(id[i]) : 0; };
  for_rows(frames, table.stamps("begun"), [&](Frame& frame, std::size_t i) {
    if (frame.report && std::isfinite(u[i] + v[i]))
      frame.report->initialized.push_back({number(i), {u[i], v[i]}});
  });
  if (!table.has("ended")) return;  // results of earlier versions
  const std::vector<std::string>& ends = table.text("ended");
  for (std::size_t i = 0; i < ends.size(); ++i)
    if (const auto t = files::parse_number<std::int64_t>(ends[i]))
      if (Frame* const frame = frame_at(frames, slam::Stamp(*t)); frame && frame->report)
        frame->report->deleted.push_back(number(i));
}

/// Adds rows of map_over_time.csv to the frames with their stamps, or rows of map.csv, which has no stamps,
/// to the last frame.
void add_maps(std::vector<Frame>& frames, const Table& table) {
  constexpr std::array kColumns{"p_W_x", "p_W_y", "p_W_z", "P_xx", "P_xy", "P_xz", "P_yy", "P_yz", "P_zz"};
  const bool over_time = table.has("timestamp");
  if (!over_time) frames.back().map.reset();
  const Column id = table.numbers("id");
  std::vector<Column> c;
  for (const char* const column : kColumns) c.push_back(table.numbers(column));
  const auto stamps = over_time ? table.stamps("timestamp") : std::vector(table.rows(), frames.back().t);
  for_rows(frames, stamps, [&](Frame& frame, std::size_t i) {
    slam::MapPoint point;
    point.p_W = {c[0][i], c[1][i], c[2][i]};
    point.covariance << c[3][i], c[4][i], c[5][i], c[4][i], c[6][i], c[7][i], c[5][i], c[7][i], c[8][i];
    if (!(std::abs(id[i]) < 1e9) || !point.p_W.allFinite() || !point.covariance.allFinite()) return;
    point.id = static_cast<int>(id[i]);
    if (!frame.map) frame.map.emplace();
    frame.map->push_back(point);
  });
}

/// Aligns a positions-only truth, which is in its own frame, with the estimate; removes it if that is
/// impossible.
void align_positions(std::vector<Frame>& frames) {
  std::vector<score::PosePair> pairs;
  for (const Frame& frame : frames)
    if (frame.truth && frame.estimate) pairs.push_back({frame.t, *frame.estimate, *frame.truth});
  const auto found = score::align(pairs, score::Alignment::se3);
  for (Frame& frame : frames)
    if (const auto* const S = std::get_if<score::Similarity>(&found); S && frame.truth)
      frame.truth = *S * *frame.truth;
    else
      frame.truth.reset();
}

void read_frames(RunData& run) {
  std::vector<Frame>& frames = run.frames;
  const std::vector<TumRow> truth = files::read_tum(run.folder / "truth.tum");
  frames.reserve(truth.size());
  for (const TumRow& row : truth) frames.push_back({.t = row.t, .truth = row.X});
  const auto for_poses = [&](const char* file, const auto& add) {
    for (const TumRow& row : files::read_tum(run.folder / file))
      if (Frame* const frame = frame_at(frames, row.t)) add(*frame, row);
  };
  for_poses("plan.tum", [](Frame& frame, const TumRow& row) { frame.plan = row.X; });
  if (fs::exists(run.folder / "estimate_cov.txt")) {
    for_poses("estimate_cov.txt", [](Frame& frame, const TumRow& row) {
      frame.estimate = row.X, frame.covariance = row.covariance;
    });
    run.estimate = path_of(frames, &Frame::estimate);
    run.truth_aligned = !run.value("rotation_rmse_deg") && run.value("ate_sim3_rmse_m");  // positions only
    if (run.truth_aligned)
      align_positions(frames);
    else
      run.errors = errors_of(frames, score::alignment_of(run.alignment) > score::Alignment::origin);
  }
  if (fs::exists(run.folder / "odometry.tum")) {
    Path& path = run.odometry.emplace();
    for_poses("odometry.tum", [&](const Frame& frame, const TumRow& row) {
      add(path, row.t, row.X);
      run.odometry_error.push_back(frame.truth ? (row.X.translation() - frame.truth->translation()).norm()
                                               : NAN);
    });
  }
  const auto paired = std::ranges::count_if(
      frames, [](const Frame& frame) { return frame.truth.has_value() && frame.estimate.has_value(); });
  if (const auto scored = run.value("poses_matched"); scored && static_cast<double>(paired) < *scored)
    throw files::FileError(run.folder / "truth.tum",
                           "has only {} poses with an estimate, expected at least {:.0f} as in score.json: "
                           "it or estimate_cov.txt was truncated",
                           paired, *scored);
  for (const auto& [planned, walked] :
       {std::pair{"plan.tum", "truth.tum"}, {"waist_plan.tum", "waist_truth.tum"}}) {
    const auto plan = files::read_tum(run.folder / planned), walk = files::read_tum(run.folder / walked);
    if (!plan.empty() && (walk.empty() || walk.back().t != plan.back().t))
      throw files::FileError(run.folder / walked, "does not end like {}: one of them was truncated", planned);
  }
  run.truth = path_of(frames, &Frame::truth), run.plan = path_of(frames, &Frame::plan);
  if (run.filter_frames) add_reports(frames, *run.filter_frames);
  if (frames.empty()) return;
  for (const auto& [file, add] :
       {std::pair{"searches.csv", &add_searches}, std::pair{"landmarks.csv", &add_landmarks},
        std::pair{"map_over_time.csv", &add_maps}, std::pair{"map.csv", &add_maps}})
    if (fs::exists(run.folder / file)) add(frames, Table(run.folder / file));
}

}  // namespace

std::string RunData::setting(const std::string& key) const {
  const auto found = settings.find(key);
  return found == settings.end() ? "" : in_one_line(found->second);
}

std::string RunData::label() const {
  return fmt::format("{}, seed {}{}{}", scenario, seed, estimator == "filter" ? "" : ", " + estimator,
                     alignment == "none" ? "" : " after " + alignment);
}

RunData read_run(const fs::path& folder, Reads reads) {
  if (!fs::is_directory(folder)) throw files::FileError(folder, "no such result folder");
  RunData run;
  run.folder = folder;
  if (fs::exists(folder / "recording/manifest.csv")) {
    run.recording = folder / "recording";
    if (reads == Reads::all) {
      recording::RecordingReader checked(run.recording);
      run.recorded = recording::read_truth(run.recording);
    }
  }
  static_cast<result::SeedScore&>(run) = result::read_score(folder / "score.json");
  run.about = result::read_about(folder / "about.json");
  run.alignment = alignment_of(run.about);
  run.settings = settings_of(folder, run.about);
  const fs::path timing_file = folder / "timing.json";  // not part of the result
  const auto timing = fs::exists(timing_file) ? std::optional(files::read_json(timing_file)) : std::nullopt;
  for (const auto& [key, member] : {std::pair{"frame_cpu_ms_mean", &RunData::frame_cpu_ms_mean},
                                    {"frame_cpu_ms_median", &RunData::frame_cpu_ms_median},
                                    {"frame_cpu_ms_p99", &RunData::frame_cpu_ms_p99}})
    if (const auto value = timing ? timing->find(key) : std::nullopt) run.*member = value->number();
  for (const auto& [file, table] : {std::pair{"frames.csv", &RunData::filter_frames},
                                    {"feet.csv", &RunData::feet},
                                    {"timing.csv", &RunData::frame_times},
                                    {"answers.csv", &RunData::answers},
                                    {"corrected_steps.csv", &RunData::corrected_steps}})
    if (fs::exists(folder / file)) (run.*table).emplace(folder / file);
  read_frames(run);
  run.waist_truth = read_path(folder / "waist_truth.tum");
  run.waist_plan = read_path(folder / "waist_plan.tum");
  if (fs::exists(folder / "waist_desired.tum")) {
    run.waist_desired = read_path(folder / "waist_desired.tum");
    // The estimated waist, assuming the planned pose of the camera relative to the waist at the start.
    const auto waist = files::read_tum(folder / "waist_plan.tum");
    if (run.estimate && !waist.empty() && run.frames.front().plan)
      run.waist_estimate =
          path_of(run.frames, &Frame::estimate, run.frames.front().plan->inverse() * waist.front().X);
  }
  return run;
}

}  // namespace sim::pages
