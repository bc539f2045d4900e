#include "sim/pages/run_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "sim/files/csv.h"
#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/recording/recording.h"
#include "sim/result/score_file.h"
#include "sim/score/consistency.h"
#include "sim/score/trajectory.h"

namespace sim::pages {
namespace {

namespace fs = std::filesystem;
using files::Json;
using files::TumRow;

std::string column_name(std::string title) {
  if (title.starts_with('#')) title.erase(0, 1);
  return title.substr(0, title.find(" ["));
}

Path path_of(const std::vector<TumRow>& rows) {
  Path path;
  for (const TumRow& row : rows) {
    path.t.push_back(slam::seconds(row.t));
    path.x.push_back(row.X.translation().x());
    path.y.push_back(row.X.translation().y());
    path.z.push_back(row.X.translation().z());
    path.yaw.push_back(score::yaw(row.X.linear()));
  }
  return path;
}

Path read_path(const fs::path& file) { return path_of(files::read_tum(file)); }

/// The estimate's rows with a NaN before each one that does not follow at the next true stamp: a line breaks
/// there.
std::vector<TumRow> broken_at_gaps(const std::vector<TumRow>& estimate, const std::vector<TumRow>& truth) {
  std::vector<TumRow> rows;
  auto next = truth.begin();
  for (const TumRow& row : estimate) {
    const auto at = std::lower_bound(next, truth.end(), row.t,
                                     [](const TumRow& pose, slam::Stamp t) { return pose.t < t; });
    if (!rows.empty() && at != next) {
      rows.push_back({{next->t, Eigen::Isometry3d::Identity()}, std::nullopt});
      rows.back().X.matrix().topRows<3>().setConstant(NAN);
    }
    rows.push_back(row);
    next = at != truth.end() && at->t == row.t ? std::next(at) : at;
  }
  return rows;
}

std::vector<TumRow> tum_if_there(const fs::path& file) {
  return fs::exists(file) ? files::read_tum(file) : std::vector<TumRow>{};
}

std::optional<Table> table_if_there(const fs::path& file) {
  if (!fs::exists(file)) return std::nullopt;
  return Table(file);
}

// Without a covariance there is neither envelope nor NEES: figures leave out NaNs.
void add(Errors& errors, const score::PosePair& pair, const std::optional<score::Matrix6d>& estimated) {
  const score::Matrix6d covariance = estimated.value_or(score::Matrix6d::Constant(NAN));
  const Eigen::Vector3d e = pair.X_estimate.translation() - pair.X_true.translation();
  const auto nees = score::pose_nees(pair.X_true, pair.X_estimate, covariance);
  errors.t.push_back(slam::seconds(pair.t));
  errors.x.push_back(e.x());
  errors.y.push_back(e.y());
  errors.z.push_back(e.z());
  errors.distance.push_back(e.norm());
  errors.yaw.push_back(score::yaw(pair.X_estimate.linear() * pair.X_true.linear().transpose()));
  errors.sigma_x.push_back(std::sqrt(covariance(3, 3)));
  errors.sigma_y.push_back(std::sqrt(covariance(4, 4)));
  errors.sigma_z.push_back(std::sqrt(covariance(5, 5)));
  errors.sigma_yaw.push_back(sigma_yaw(pair.X_estimate, covariance));
  errors.nees_position.push_back(nees ? nees->position : NAN);
  errors.nees_orientation.push_back(nees ? nees->orientation : NAN);
}

score::Trajectory trajectory(const std::vector<TumRow>& rows) {
  score::Trajectory all;
  for (const TumRow& row : rows) all.push_back({row.t, row.X});
  return all;
}

Errors errors_of(const std::vector<TumRow>& truth, const std::vector<TumRow>& estimate) {
  Errors errors;
  std::size_t row = 0;
  for (const score::PosePair& pair : score::pair_by_stamp(trajectory(truth), trajectory(estimate))) {
    while (estimate[row].t != pair.t) ++row;
    add(errors, pair, estimate[row].covariance);
  }
  return errors;
}

// The estimated waist, assuming the planned distance of the camera at the start.
std::optional<Path> waist_of_estimate(const fs::path& folder, const std::vector<TumRow>& truth) {
  if (!fs::exists(folder / "estimate.tum")) return std::nullopt;
  const auto waist = files::read_tum(folder / "waist_plan.tum"),
             camera = files::read_tum(folder / "plan.tum");
  auto estimate = broken_at_gaps(files::read_tum(folder / "estimate.tum"), truth);
  if (waist.empty() || camera.empty()) return std::nullopt;
  const Eigen::Isometry3d X_CB = camera.front().X.inverse() * waist.front().X;
  for (TumRow& row : estimate) row.X = row.X * X_CB;
  return path_of(estimate);
}

void read_score(RunData& run, const Json& score) {
  run.scenario = score.at("scenario").text();
  run.seed = score.at("seed").whole();
  run.ending = score.at("ending").text();
  if (const auto estimator = score.find("estimator")) run.estimator = estimator->text();
  const auto number = [](const std::optional<Json>& value) {
    return value ? value->number_or_null() : std::nullopt;
  };
  for (const auto& [name, metric] : score.at("metrics").entries()) {
    const auto unit = metric.find("unit"), reason = metric.find("reason");
    run.metrics.push_back(
        {name, unit ? unit->text() : "", reason ? reason->text() : "", number(metric.find("value"))});
  }
  for (const Json& limit : score.at("limits").items()) {
    const auto passed = limit.find("passed");
    run.limits.push_back({limit.at("metric").text(), number(limit.find("at_most")),
                          number(limit.find("at_least")), number(limit.find("value")),
                          passed ? std::optional(passed->flag()) : std::nullopt});
  }
  const auto tracking = score.find("tracking");
  for (const char* const kind : {"lost", "suspect"})
    if (const auto list = tracking ? tracking->find(kind) : std::nullopt)
      for (const Json& one : list->items())
        run.faults.push_back({kind, one.at("cause").text(), one.at("from_s").number()});
}

/// The frames of a result by their stamps.
class Timeline {
 public:
  explicit Timeline(std::vector<Frame>& frames) : frames_(frames) {}

  Frame* at(slam::Stamp t) {
    const auto found = std::lower_bound(frames_.begin(), frames_.end(), t,
                                        [](const Frame& f, slam::Stamp s) { return f.t < s; });
    return found != frames_.end() && found->t == t ? &*found : nullptr;
  }
  /// The frame at a stamp of a file in nanoseconds.
  Frame* at(const std::string& field, const fs::path& file) {
    const auto ns = files::parse_number<std::int64_t>(field);
    if (!ns) throw files::FileError(file, fmt::format("'{}' is not a time stamp", field));
    return at(slam::Stamp(*ns));
  }

 private:
  std::vector<Frame>& frames_;
};

slam::Health health_of(const std::string& name) {
  return name == "lost" ? slam::Health::lost : name == "diverged" ? slam::Health::diverged : slam::Health::ok;
}

void add_reports(Timeline& frames, const fs::path& file, const Table& table) {
  const auto &t = table.text("timestamp"), &health = table.text("health"), &cause = table.text("cause"),
             &refused = table.text("refused");
  const auto landmarks = table.numbers("landmarks");
  for (std::size_t i = 0; i < table.rows(); ++i) {
    Frame* const frame = frames.at(t[i], file);
    if (!frame) continue;
    slam::FrameReport& report = frame->report.emplace();
    report.t = frame->t;
    report.landmarks = landmarks[i] >= 0 && landmarks[i] < 1e6 ? static_cast<int>(landmarks[i]) : 0;
    report.health = health_of(health[i]);
    report.cause = cause[i], report.refused = refused[i];
    if (table.has("suspect")) report.suspect = table.text("suspect")[i];
  }
}

// Results of earlier versions lack the positions of rejected matches.
Column numbers_if_there(const Table& table, const char* column) {
  return table.has(column) ? table.numbers(column) : Column(table.rows(), NAN);
}

void add_searches(Timeline& frames, const fs::path& file) {
  if (!fs::exists(file)) return;
  const Table table(file);
  const auto& t = table.text("timestamp");
  const Column landmark = table.numbers("landmark"), u = table.numbers("u"), v = table.numbers("v"),
               uu = table.numbers("S_uu"), uv = table.numbers("S_uv"), vv = table.numbers("S_vv"),
               found_u = table.numbers("found_u"), found_v = table.numbers("found_v"),
               rejected_u = numbers_if_there(table, "refused_u"),
               rejected_v = numbers_if_there(table, "refused_v");
  for (std::size_t i = 0; i < table.rows(); ++i) {
    Frame* const frame = frames.at(t[i], file);
    if (!frame || !frame->report || !(std::abs(landmark[i]) < 1e9)) continue;
    slam::Search search{static_cast<int>(landmark[i]), {u[i], v[i]}, Eigen::Matrix2d::Zero()};
    search.S << uu[i], uv[i], uv[i], vv[i];
    if (!search.S.allFinite() || !search.pixel.allFinite()) continue;
    search.used = std::isfinite(found_u[i]);
    if (search.used) search.match = {found_u[i], found_v[i]};
    if (std::isfinite(rejected_u[i])) search.match = {rejected_u[i], rejected_v[i]};
    frame->report->searched.push_back(search);
  }
}

void add_new_landmarks(Timeline& frames, const fs::path& file) {
  if (!fs::exists(file)) return;
  const Table table(file);
  const auto& t = table.text("begun");
  const Column u = table.numbers("u"), v = table.numbers("v");
  for (std::size_t i = 0; i < table.rows(); ++i)
    if (Frame* const frame = frames.at(t[i], file); frame && frame->report && std::isfinite(u[i] + v[i]))
      frame->report->initialized.push_back({0, {u[i], v[i]}});
}

// Rows of map_over_time.csv by their stamps, or of map.csv, which has none, in the last frame.
void add_maps(std::vector<Frame>& all, const fs::path& file) {
  if (!fs::exists(file) || all.empty()) return;
  constexpr std::array kColumns{"p_W_x", "p_W_y", "p_W_z", "P_xx", "P_xy", "P_xz", "P_yy", "P_yz", "P_zz"};
  const Table table(file);
  Timeline frames(all);
  if (!table.has("timestamp")) all.back().map.reset();
  const Column id = table.numbers("id");
  std::vector<Column> c;
  for (const char* const column : kColumns) c.push_back(table.numbers(column));
  for (std::size_t i = 0; i < table.rows(); ++i) {
    Frame* const frame = table.has("timestamp") ? frames.at(table.text("timestamp")[i], file) : &all.back();
    if (!frame || !(std::abs(id[i]) < 1e9)) continue;
    slam::MapPoint point;
    point.id = static_cast<int>(id[i]);
    point.p_W = {c[0][i], c[1][i], c[2][i]};
    point.covariance << c[3][i], c[4][i], c[5][i], c[4][i], c[6][i], c[7][i], c[5][i], c[7][i], c[8][i];
    if (!point.p_W.allFinite() || !point.covariance.allFinite()) continue;
    if (!frame->map) frame->map.emplace();
    frame->map->push_back(point);
  }
}

std::vector<Frame> frames_of(const RunData& run, const std::vector<TumRow>& truth,
                             const std::vector<TumRow>& plan, const std::vector<TumRow>& estimate) {
  std::vector<Frame> all(truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) all[i].t = truth[i].t, all[i].truth = truth[i].X;
  Timeline frames(all);
  for (const TumRow& row : plan)
    if (Frame* const frame = frames.at(row.t)) frame->plan = row.X;
  for (const TumRow& row : estimate)
    if (Frame* const frame = frames.at(row.t)) frame->estimate = row.X, frame->covariance = row.covariance;
  if (run.filter_frames) add_reports(frames, run.folder / "frames.csv", *run.filter_frames);
  add_searches(frames, run.folder / "searches.csv");
  add_new_landmarks(frames, run.folder / "landmarks.csv");
  add_maps(all, run.folder / "map_over_time.csv");
  add_maps(all, run.folder / "map.csv");
  return all;
}

}  // namespace

Table::Table(const fs::path& file) : file_(file) {
  files::CsvReader csv(file);
  std::vector<std::vector<std::string>*> columns;
  for (const std::string& title : csv.titles()) {
    const auto [column, is_new] = columns_.try_emplace(column_name(title));
    if (!is_new) throw files::FileError(file_, 1, fmt::format("has the column '{}' twice", column->first));
    columns.push_back(&column->second);
  }
  for (; csv.next(); ++rows_)
    for (std::size_t i = 0; i < columns.size(); ++i) columns[i]->emplace_back(csv.text(i));
}

const std::vector<std::string>& Table::text(std::string_view column) const {
  const auto found = columns_.find(column);
  if (found == columns_.end()) throw files::FileError(file_, fmt::format("no column '{}'", column));
  return found->second;
}

Column Table::numbers(std::string_view column) const {
  Column values;
  for (const std::string& field : text(column))
    values.push_back(files::parse_number<double>(field).value_or(std::numeric_limits<double>::quiet_NaN()));
  return values;
}

Column Table::seconds(std::string_view column) const {
  Column values = numbers(column);
  for (double& value : values) value *= 1e-9;
  return values;
}

std::string RunData::label() const {
  return fmt::format("{}, seed {}{}{}", scenario, seed, estimator == "filter" ? "" : ", " + estimator,
                     alignment == "none" ? "" : " after " + alignment);
}

std::optional<double> RunData::metric(std::string_view name) const {
  for (const RunMetric& metric : metrics)
    if (metric.name == name) return metric.value;
  return std::nullopt;
}

std::string alignment_of(const result::About& about) {
  const bool is_name =
      about.alignment.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789") == std::string::npos;
  return about.alignment.empty() ? "none" : is_name ? about.alignment : "unknown";
}

std::string column_of(const std::string& metric, const std::string& alignment) {
  constexpr std::array kAligned{"rmse_m", "rotation_rmse_deg", "end_",     "drift_",
                                "nees_",  "loop_error_",       "landmark_"};
  const bool depends = std::any_of(kAligned.begin(), kAligned.end(),
                                   [&](const char* prefix) { return metric.starts_with(prefix); });
  return depends && alignment != "none" ? metric + "_after_" + alignment : metric;
}

RunData read_run(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw files::FileError(folder, "no such result folder");
  RunData run;
  run.folder = folder;
  if (fs::exists(folder / "recording/manifest.csv")) {
    run.recording = folder / "recording";
    recording::RecordingReader checked(run.recording);
    recording::read_truth(run.recording);
  }
  read_score(run, result::read_whole_score(folder / "score.json"));
  run.about = result::read_about(folder / "about.json");
  run.alignment = alignment_of(run.about);
  const Json timing = files::read_json(folder / "timing.json");
  for (const auto& [key, member] : {std::pair{"frame_cpu_ms_mean", &RunData::frame_cpu_ms_mean},
                                    {"frame_cpu_ms_median", &RunData::frame_cpu_ms_median},
                                    {"frame_cpu_ms_p99", &RunData::frame_cpu_ms_p99}})
    if (const auto value = timing.find(key)) run.*member = value->number();
  const auto truth = files::read_tum(folder / "truth.tum"), plan = files::read_tum(folder / "plan.tum"),
             estimate = tum_if_there(folder / "estimate_cov.txt");
  run.truth = path_of(truth);
  run.plan = path_of(plan);
  run.waist_truth = read_path(folder / "waist_truth.tum");
  run.waist_plan = read_path(folder / "waist_plan.tum");
  if (fs::exists(folder / "estimate_cov.txt")) {
    const std::vector<TumRow> rows = broken_at_gaps(estimate, truth);
    run.estimate = path_of(rows);
    run.errors = errors_of(truth, rows);
  }
  if (fs::exists(folder / "waist_desired.tum")) {
    run.waist_desired = read_path(folder / "waist_desired.tum");
    run.waist_estimate = waist_of_estimate(folder, truth);
    run.corrected_steps = table_if_there(folder / "corrected_steps.csv");
  }
  run.filter_frames = table_if_there(folder / "frames.csv");
  run.feet = table_if_there(folder / "feet.csv");
  run.frame_times = table_if_there(folder / "timing.csv");
  run.frames = frames_of(run, truth, plan, estimate);
  return run;
}

}  // namespace sim::pages
