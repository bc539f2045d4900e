#include "sim/pages/run_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <future>

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

Path path_of(const std::vector<TumRow>& rows) {
  Path path;
  for (const TumRow& row : rows) add(path, row.t, row.X);
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

constexpr slam::Stamp kSame = std::chrono::microseconds(100);  // other programs round stamps

/// Returns the frame with a stamp, or null.
Frame* frame_at(std::vector<Frame>& frames, slam::Stamp t) {
  const auto found = std::ranges::lower_bound(frames, t - kSame, {}, &Frame::t);
  return found != frames.end() && found->t <= t + kSame ? &*found : nullptr;
}

/// The rows of a CSV file in chronological order, with columns by name, read as their frames are. All members
/// throw FileError.
class FrameRows {
 public:
  explicit FrameRows(const fs::path& file) : csv_(file), file_(file), names_(names_of(csv_.titles())) {
    stamp_ = column("timestamp");
    advance();
  }
  bool has(std::string_view name) const { return std::ranges::find(names_, name) != names_.end(); }
  std::size_t column(std::string_view name) const {
    if (!has(name)) throw files::FileError(file_, "has no column '{}'", name);
    return static_cast<std::size_t>(std::ranges::find(names_, name) - names_.begin());
  }
  /// Returns NaN if a field is not a number.
  double number(std::size_t column) const {
    return files::parse_number<double>(csv_.text(column)).value_or(NAN);
  }
  std::string text(std::size_t column) const { return std::string(csv_.text(column)); }

  /// Calls add() for each row of the frame; rows without a frame are skipped.
  void at(slam::Stamp t, const auto& add) {
    for (; t_ && *t_ <= t + kSame; advance())
      if (*t_ >= t - kSame) add();
  }

 private:
  void advance() { t_ = csv_.next() ? std::optional(slam::Stamp(csv_.integer(stamp_))) : std::nullopt; }

  files::CsvReader csv_;
  fs::path file_;
  std::vector<std::string> names_;
  std::size_t stamp_ = 0;
  std::optional<slam::Stamp> t_;
};

std::optional<FrameRows> rows_of(const fs::path& file) {
  return fs::exists(file) ? std::optional<FrameRows>(std::in_place, file) : std::nullopt;
}

void add_reports(std::vector<Frame>& frames, FrameRows rows) {
  const std::size_t landmarks = rows.column("landmarks"), accepted = rows.column("accepted"),
                    health = rows.column("health"), cause = rows.column("cause"),
                    refused = rows.column("refused");
  std::vector<std::tuple<std::string_view, std::size_t, std::size_t>> innovations;
  for (const std::string_view sensor : score::kSensors)
    if (const std::string name = fmt::format("nis_{}", sensor); rows.has(name))
      innovations.emplace_back(sensor, rows.column(name), rows.column(fmt::format("dof_{}", sensor)));
  const auto suspect = rows.has("suspect") ? std::optional(rows.column("suspect")) : std::nullopt;
  const auto count = [&](std::size_t column) {
    const double n = rows.number(column);
    return n >= 0 && n < 1e6 ? static_cast<int>(n) : 0;
  };
  for (Frame& frame : frames)
    rows.at(frame.t, [&] {
      slam::FrameReport& report = frame.report.emplace();
      report.t = frame.t;
      report.landmarks = count(landmarks), report.accepted = count(accepted);
      const std::string state = rows.text(health);
      report.health = state == "lost"       ? slam::Health::lost
                      : state == "diverged" ? slam::Health::diverged
                                            : slam::Health::ok;
      if (std::string text = rows.text(cause); !text.empty()) report.cause = std::move(text);
      if (const std::string text = rows.text(refused); !text.empty()) report.refused.add(text);
      for (const auto& [sensor, nis, dof] : innovations)
        if (std::isfinite(rows.number(nis)) && rows.number(dof) > 0)
          report.innovations.push_back({sensor, {rows.number(nis), static_cast<int>(rows.number(dof))}});
      if (std::string text = suspect ? rows.text(*suspect) : ""; !text.empty())
        report.suspect = std::move(text);
    });
}

/// A landmark's number, or nothing if the field is not one.
std::optional<int> landmark_of(double number) {
  return std::abs(number) < 1e9 ? std::optional(static_cast<int>(number)) : std::nullopt;
}

void add_searches(Frame& frame, FrameRows& rows, const std::vector<std::size_t>& c) {
  rows.at(frame.t, [&] {
    const auto id = landmark_of(rows.number(c[0]));
    if (!frame.report || !id) return;
    slam::Search search{*id, {rows.number(c[1]), rows.number(c[2])}, Eigen::Matrix2d::Zero()};
    search.S << rows.number(c[3]), rows.number(c[4]), rows.number(c[4]), rows.number(c[5]);
    if (!search.S.allFinite() || !search.pixel.allFinite()) return;
    for (const std::size_t match : {6, 8})
      if (const double u = rows.number(c[match]); std::isfinite(u))
        search.match = {u, rows.number(c[match + 1])}, search.used |= match == 6;
    frame.report->searched.push_back(search);
  });
}

/// Adds the current row of map.csv or map_over_time.csv, whose values are number(0), number(1) ...
void add_point(Frame& frame, const auto& number) {
  slam::MapPoint point;
  const auto id = landmark_of(number(0));
  point.p_W = {number(1), number(2), number(3)};
  for (int k = 4, i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j, ++k)
      point.covariance(i, j) = point.covariance(j, i) = number(static_cast<std::size_t>(k));
  if (!id || !point.p_W.allFinite() || !point.covariance.allFinite()) return;
  point.id = *id;
  if (!frame.map) frame.map.emplace();
  frame.map->push_back(point);
}

constexpr std::array kSearch{"landmark", "u",       "v",       "S_uu",      "S_uv",
                             "S_vv",     "found_u", "found_v", "refused_u", "refused_v"};
constexpr std::array kPoint{"id", "p_W_x", "p_W_y", "p_W_z", "P_xx", "P_xy", "P_xz", "P_yy", "P_yz", "P_zz"};

std::vector<std::size_t> columns_of(const std::optional<FrameRows>& rows, const auto& names) {
  std::vector<std::size_t> all;
  for (const char* const name : names)
    if (rows) all.push_back(rows->column(name));
  return all;
}

/// The files that FrameParts reads.
struct Parts {
  explicit Parts(const RunData& run)
      : folder(run.folder),
        end(run.frames.empty() ? slam::Stamp{0} : run.frames.back().t),
        searches(rows_of(folder / "searches.csv")),
        maps(rows_of(folder / "map_over_time.csv")) {
    if (!fs::exists(folder / "landmarks.csv")) return;
    const Table table(folder / "landmarks.csv");
    const Column id = table.numbers("landmark"), u = table.numbers("u"), v = table.numbers("v");
    const auto stamps = table.stamps("begun");
    for (std::size_t i = 0; i < stamps.size(); ++i) {
      const int number = landmark_of(id[i]).value_or(0);
      if (std::isfinite(u[i] + v[i])) begun.emplace(stamps[i], slam::Sighting{number, {u[i], v[i]}});
      if (!table.has("ended")) continue;  // results of earlier versions
      if (const auto t = files::parse_number<std::int64_t>(table.text("ended")[i]))
        ended.emplace(slam::Stamp(*t), number);
    }
  }

  void add(Frame& frame) {
    const auto each = [&](const auto& events, const auto& take) {
      for (auto at = events.lower_bound(frame.t - kSame); at != events.end() && at->first <= frame.t + kSame;
           ++at)
        take(at->second);
    };
    if (frame.report) {
      each(begun, [&](const slam::Sighting& s) { frame.report->initialized.push_back(s); });
      each(ended, [&](int id) { frame.report->deleted.push_back(id); });
    }
    if (searches) add_searches(frame, *searches, search_columns);
    if (maps)
      maps->at(frame.t,
               [&] { add_point(frame, [&](std::size_t i) { return maps->number(map_columns[i]); }); });
    if (frame.t != end || !fs::exists(folder / "map.csv")) return;
    const Table table(folder / "map.csv");
    std::vector<Column> columns;
    for (const char* const name : kPoint) columns.push_back(table.numbers(name));
    frame.map.reset();
    for (std::size_t row = 0; row < table.rows(); ++row)
      add_point(frame, [&](std::size_t i) { return columns[i][row]; });
  }

  fs::path folder;
  slam::Stamp end;
  std::optional<FrameRows> searches, maps;
  std::vector<std::size_t> search_columns = columns_of(searches, kSearch),
                           map_columns = columns_of(maps, kPoint);
  std::multimap<slam::Stamp, slam::Sighting> begun;
  std::multimap<slam::Stamp, int> ended;
};

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

std::future<std::vector<TumRow>> poses_of(const fs::path& file) {
  return std::async(std::launch::async,
                    [file] { return fs::exists(file) ? files::read_tum(file) : std::vector<TumRow>(); });
}

/// Throws FileError unless both files end at the same time.
void require_same_end(const fs::path& planned, const std::vector<TumRow>& plan, const fs::path& walked,
                      const std::vector<TumRow>& walk) {
  if (!plan.empty() && (walk.empty() || walk.back().t != plan.back().t))
    throw files::FileError(walked, "does not end like {}: one of them was truncated",
                           planned.filename().string());
}

void read_frames(RunData& run) {
  std::vector<Frame>& frames = run.frames;
  const fs::path truth_file = run.folder / "truth.tum", plan_file = run.folder / "plan.tum",
                 estimate_file = run.folder / "estimate_cov.txt";
  auto plan_of = poses_of(plan_file), estimate_of = poses_of(estimate_file);
  const std::vector<TumRow> truth = files::read_tum(truth_file);
  frames.reserve(truth.size());
  for (const TumRow& row : truth) frames.push_back({.t = row.t, .truth = row.X});
  const auto for_frames = [&](const std::vector<TumRow>& rows, const auto& add) {
    for (const TumRow& row : rows)
      if (Frame* const frame = frame_at(frames, row.t)) add(*frame, row);
  };
  const std::vector<TumRow> plan = plan_of.get(), estimate = estimate_of.get();
  for_frames(plan, [](Frame& frame, const TumRow& row) { frame.plan = row.X; });
  for_frames(estimate, [](Frame& frame, const TumRow& row) {
    frame.estimate = row.X, frame.covariance = row.covariance;
  });
  if (fs::exists(estimate_file)) {
    run.estimate = path_of(frames, &Frame::estimate);
    run.truth_aligned = !run.value("rotation_rmse_deg") && run.value("ate_sim3_rmse_m");  // positions only
    if (run.truth_aligned)
      align_positions(frames);
    else
      run.errors = errors_of(frames, score::alignment_of(run.alignment) > score::Alignment::origin);
  }
  const auto paired = std::ranges::count_if(
      frames, [](const Frame& frame) { return frame.truth.has_value() && frame.estimate.has_value(); });
  if (const auto scored = run.value("poses_matched"); scored && static_cast<double>(paired) < *scored)
    throw files::FileError(truth_file,
                           "has only {} poses with an estimate, expected at least {:.0f} as in score.json: "
                           "it or estimate_cov.txt was truncated",
                           paired, *scored);
  require_same_end(plan_file, plan, truth_file, truth);
  if (const fs::path file = run.folder / "frames.csv"; fs::exists(file)) add_reports(frames, FrameRows(file));
}

/// Reads what only reports show.
void read_rest(RunData& run) {
  const fs::path& folder = run.folder;
  const auto add = frame_parts(run);
  for (Frame& frame : run.frames) add(frame);
  run.truth = path_of(run.frames, &Frame::truth), run.plan = path_of(run.frames, &Frame::plan);
  if (fs::exists(folder / "odometry.tum")) {
    Path& path = run.odometry.emplace();
    for (const TumRow& row : files::read_tum(folder / "odometry.tum"))
      if (const Frame* const frame = frame_at(run.frames, row.t)) {
        pages::add(path, row.t, row.X);
        run.odometry_error.push_back(frame->truth ? (row.X.translation() - frame->truth->translation()).norm()
                                                  : NAN);
      }
  }
  for (const auto& [file, table] : {std::pair{"frames.csv", &RunData::filter_frames},
                                    {"feet.csv", &RunData::feet},
                                    {"timing.csv", &RunData::frame_times},
                                    {"answers.csv", &RunData::answers},
                                    {"corrected_steps.csv", &RunData::corrected_steps}})
    if (fs::exists(folder / file)) (run.*table).emplace(folder / file);
  const auto waist = files::read_tum(folder / "waist_truth.tum"),
             planned = files::read_tum(folder / "waist_plan.tum");
  require_same_end(folder / "waist_plan.tum", planned, folder / "waist_truth.tum", waist);
  run.waist_truth = path_of(waist), run.waist_plan = path_of(planned);
  if (!fs::exists(folder / "waist_desired.tum")) return;
  run.waist_desired = path_of(files::read_tum(folder / "waist_desired.tum"));
  // The estimated waist, assuming the planned pose of the camera relative to the waist at the start.
  if (run.estimate && !planned.empty() && run.frames.front().plan)
    run.waist_estimate =
        path_of(run.frames, &Frame::estimate, run.frames.front().plan->inverse() * planned.front().X);
}

}  // namespace

std::function<void(Frame&)> frame_parts(const RunData& run) {
  return [parts = std::make_shared<Parts>(run)](Frame& frame) { parts->add(frame); };
}

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
  read_frames(run);
  if (reads == Reads::all) read_rest(run);
  return run;
}

}  // namespace sim::pages
