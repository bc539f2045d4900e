#include "sim/pages/run_data.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "sim/files/csv.h"
#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/recording/image_file.h"
#include "sim/recording/recording_format.h"
#include "sim/scenario/keys.h"
#include "sim/scenario/scenario.h"
#include "sim/score/run.h"

namespace sim::pages {
namespace {

using nlohmann::ordered_json;
constexpr double kSigmas = 3;     // for every ellipse and ellipsoid
constexpr double kLongest_m = 4;  // longest half axis drawn: a new landmark's depth is unbounded

/// Returns numbers as a list, rounded to 0.01 mm or 0.00001 rad.
ordered_json list(const auto& numbers) {
  ordered_json all = ordered_json::array();
  for (const double x : numbers) all.push_back(std::round(1e5 * x) / 1e5);
  return all;
}

ordered_json pose(const Eigen::Isometry3d& X) {
  const Eigen::Quaterniond q(X.linear());
  const Eigen::Vector3d p = X.translation();
  return list(std::array{p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()});
}

/// Returns the rows of the matrix that maps the unit sphere to the kSigmas ellipsoid.
ordered_json ellipsoid(const Eigen::Matrix3d& P) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(P);
  const Eigen::Vector3d half = (kSigmas * solver.eigenvalues().cwiseMax(0).cwiseSqrt()).cwiseMin(kLongest_m);
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> axes = solver.eigenvectors() * half.asDiagonal();
  return list(axes.reshaped<Eigen::RowMajor>());
}

std::string state_in_words(const slam::FrameReport& report) {
  constexpr std::array kHealth{"tracking", "lost", "diverged"};
  std::string words = kHealth[static_cast<std::size_t>(report.health)];
  if (report.cause) words += ": " + *report.cause;
  if (report.health == slam::Health::ok && report.searched.empty()) words += ", no landmark searched for";
  if (report.relocalized) words += "; recognized its map";
  if (report.suspect) words += "; " + *report.suspect;
  if (report.refused) words += "; rejected: " + report.refused.text();
  return files::sanitize(words);
}

/// [landmark, u, v, half axes, angle of the longer one, outcome, place of the match]
ordered_json to_json(const slam::Search& search) {
  const Eigen::Vector3d shape = ellipse(search.S);
  ordered_json all = list(std::array{search.pixel.x(), search.pixel.y(), shape(0), shape(1), shape(2)});
  all.insert(all.begin(), search.landmark);
  all.push_back(search.used ? "found" : search.match ? "rejected" : "missed");
  if (search.match)
    for (const ordered_json& x : list(*search.match)) all.push_back(x);
  return all;
}

void add_report(ordered_json& to, const slam::FrameReport& report) {
  to["landmarks"] = report.landmarks;
  to["health"] = static_cast<int>(report.health);
  to["state"] = state_in_words(report);
  ordered_json searches = ordered_json::array(), initialized = ordered_json::array();
  for (const slam::Search& search : report.searched) searches.push_back(to_json(search));
  for (const slam::Sighting& first : report.initialized) initialized.push_back(list(first.pixel));
  to["searches"] = std::move(searches), to["new"] = std::move(initialized);
}

ordered_json to_json(const FootPlace& foot) {
  ordered_json all{{"plan", list(foot.plan)}, {"planned_down", foot.planned_down}};
  if (foot.landed) all["landed"] = list(*foot.landed);
  return all;
}

using files::Json;
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

void add_new_landmarks(std::vector<Frame>& frames, const Table& table) {
  const Column u = table.numbers("u"), v = table.numbers("v");
  for_rows(frames, table.stamps("begun"), [&](Frame& frame, std::size_t i) {
    if (frame.report && std::isfinite(u[i] + v[i])) frame.report->initialized.push_back({0, {u[i], v[i]}});
  });
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
       {std::pair{"searches.csv", &add_searches}, std::pair{"landmarks.csv", &add_new_landmarks},
        std::pair{"map_over_time.csv", &add_maps}, std::pair{"map.csv", &add_maps}})
    if (fs::exists(run.folder / file)) add(frames, Table(run.folder / file));
}

}  // namespace

std::optional<FrameError> error_of(const Frame& frame) {
  if (!frame.truth || !frame.estimate) return std::nullopt;
  const Eigen::Vector3d e = frame.estimate->translation() - frame.truth->translation();
  FrameError all;
  all.error << e, score::yaw(frame.estimate->linear() * frame.truth->linear().transpose());
  if (!frame.covariance) return all;
  const files::Matrix6d& P = *frame.covariance;
  const Eigen::Vector3d vertical_C = frame.estimate->linear().transpose() * Eigen::Vector3d::UnitZ();
  const double yaw_variance = vertical_C.dot(P.topLeftCorner<3, 3>() * vertical_C);
  all.sigma << P.diagonal().tail<3>().cwiseSqrt(), yaw_variance < 0 ? 0 : std::sqrt(yaw_variance);
  if (const auto nees = score::pose_nees(*frame.truth, *frame.estimate, P)) all.nees = *nees;
  return all;
}

Eigen::Vector3d ellipse(const Eigen::Matrix2d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(covariance);
  const Eigen::Vector2d half = kSigmas * solver.eigenvalues().cwiseMax(0).cwiseSqrt(),
                        along = solver.eigenvectors().col(1);
  return {half(1), half(0), std::atan2(along.y(), along.x())};
}

ordered_json to_json(const Frame& frame) {
  ordered_json all{{"t", slam::seconds(frame.t)}};
  if (!frame.image.empty()) all["image"] = {frame.image.cols, frame.image.rows};
  if (!frame.bodies.empty()) all["bodies"] = list(frame.bodies);
  for (const auto& [name, X] : {std::pair{"truth", &frame.truth}, std::pair{"plan", &frame.plan},
                                std::pair{"estimate", &frame.estimate}})
    if (*X) all[name] = pose(**X);
  if (frame.feet) all["feet"] = {to_json((*frame.feet)[0]), to_json((*frame.feet)[1])};
  if (frame.zmp) all["zmp"] = list(*frame.zmp);
  for (const cv::Point2f& corner : frame.support)
    all["support"].push_back(list(std::array{corner.x, corner.y}));
  if (frame.estimate && frame.covariance)
    all["ellipsoid"] = ellipsoid(frame.covariance->bottomRightCorner<3, 3>());
  if (frame.report) add_report(all, *frame.report);
  if (frame.rig) all["rig"] = *frame.rig;
  if (!frame.map) return all;
  all["map"] = ordered_json::array();
  for (const slam::MapPoint& point : *frame.map)
    all["map"].push_back({point.id, list(point.p_W), ellipsoid(point.covariance)});
  return all;
}

std::string with_length(std::string json) {
  json.append(3 - (json.size() + 3) % 4, ' ');
  const auto length = static_cast<std::uint32_t>(json.size());
  return std::string(reinterpret_cast<const char*>(&length), sizeof length) + json;
}

std::string to_message(const Frame& frame) {
  std::string message = with_length(files::json_text(to_json(frame)));
  for (int row = 0; row < frame.image.rows; ++row)
    message.append(reinterpret_cast<const char*>(frame.image.ptr(row)),
                   static_cast<std::size_t>(frame.image.cols));
  return message;
}

std::string sent(const slam::RigReading& reading, const rig::RigSensor& sensor) {
  std::string bytes;
  if (sensor.kind == rig::Kind::depth) {
    const std::array size{reading.image.cols, reading.image.rows};
    bytes.assign(reinterpret_cast<const char*>(size.data()), sizeof size);
    for (int row = 0; row < reading.image.rows; ++row)
      bytes.append(reinterpret_cast<const char*>(reading.image.ptr(row)),
                   reading.image.elemSize() * static_cast<std::size_t>(reading.image.cols));
    return bytes;
  }
  if (rig::is_camera(sensor)) return recording::encode_png(reading.image);
  const Eigen::Isometry3f X_CS = sensor.X_CS.cast<float>();
  for (const slam::LidarPoint& point : reading.points) {
    const Eigen::Vector3f p_C = X_CS * Eigen::Vector3f(point.x_m, point.y_m, point.z_m);
    bytes.append(reinterpret_cast<const char*>(p_C.data()), sizeof(p_C));
    bytes.append(reinterpret_cast<const char*>(&point.intensity), sizeof(point.intensity));
  }
  return bytes;
}

const cv::Mat3b& palette() {
  static const cv::Mat3b kColors = [] {
    cv::Mat levels(1, 256, CV_8U), colors;
    for (int i = 0; i < 256; ++i) levels.at<unsigned char>(i) = static_cast<unsigned char>(i);
    cv::applyColorMap(levels, colors, cv::COLORMAP_TURBO);
    cv::cvtColor(colors, colors, cv::COLOR_BGR2RGB);
    return cv::Mat3b(colors);
  }();
  return kColors;
}

std::vector<fs::path> image_files(const std::vector<Frame>& frames, const fs::path& recording,
                                  const std::string& sensor) {
  std::vector<fs::path> images(frames.size());
  const fs::path folder = recording / "mav0" / sensor;
  if (recording.empty() || !fs::exists(folder / "data.csv")) return images;
  files::CsvReader list(folder / "data.csv");
  const bool of_rig = list.titles().size() == 3;  // the third column: the reading's frame
  std::size_t row = 0;
  while (list.next()) {
    const slam::Stamp t = slam::Stamp(list.integer(of_rig ? 2 : 0)) - recording::kEpoch;
    while (row < frames.size() && frames[row].t < t) ++row;
    if (row < frames.size() && frames[row].t == t)
      images[row] = files::contained_path(folder / "data", list.text(1));
  }
  for (std::size_t i = 1; of_rig && i < images.size(); ++i)
    if (images[i].empty()) images[i] = images[i - 1];
  return images;
}

Pictures::Pictures(const fs::path& recording)
    : folder_(recording), manifest_(recording), setup_(recording::RecordingReader(recording).setup()) {}

slam::RigReading Pictures::read(const rig::RigSensor& sensor, const fs::path& file) const {
  return recording::read_rig_file(folder_, manifest_, sensor, file.filename().string());
}

Table::Table(const fs::path& file) : file_(file) {
  files::CsvReader csv(file);
  std::vector<std::vector<std::string>*> columns;
  for (std::string title : csv.titles()) {
    if (title.starts_with('#')) title.erase(0, 1);
    const auto [column, is_new] = columns_.try_emplace(title.substr(0, title.find(" [")));
    if (!is_new) throw files::FileError(file_, 1, "has a duplicate column '{}'", column->first);
    columns.push_back(&column->second);
  }
  for (; csv.next(); ++rows_)
    for (std::size_t i = 0; i < columns.size(); ++i) columns[i]->emplace_back(csv.text(i));
}

const std::vector<std::string>& Table::text(std::string_view column) const {
  const auto found = columns_.find(column);
  if (found == columns_.end()) throw files::FileError(file_, "has no column '{}'", column);
  return found->second;
}

Column Table::numbers(std::string_view column) const {
  Column values;
  for (const std::string& field : text(column))
    values.push_back(files::parse_number<double>(field).value_or(NAN));
  return values;
}

Column Table::seconds(std::string_view column) const {
  Column values = numbers(column);
  for (double& value : values) value *= 1e-9;
  return values;
}

std::vector<slam::Stamp> Table::stamps(std::string_view column) const {
  std::vector<slam::Stamp> all;
  for (const std::string& field : text(column)) {
    const auto ns = files::parse_number<std::int64_t>(field);
    if (!ns) throw files::FileError(file_, "'{}' is not a time stamp", field);
    all.emplace_back(*ns);
  }
  return all;
}

std::string RunData::setting(const std::string& key) const {
  const auto found = settings.find(key);
  return found == settings.end() ? "" : in_one_line(found->second);
}

std::string RunData::label() const {
  return fmt::format("{}, seed {}{}{}", scenario, seed, estimator == "filter" ? "" : ", " + estimator,
                     alignment == "none" ? "" : " after " + alignment);
}

std::map<std::string, std::string> settings_of(const fs::path& result, const result::About& about) {
  std::map<std::string, std::string> settings;
  try {
    const scenario::Scenario read = scenario::read_scenario(result / "scenario.yaml").scenario;
    for (const auto& key : scenario::scenario_keys())
      if (key.name != "seed" && scenario::has_section(read, key.name))
        settings[std::string(key.name)] = key.print(read);
    for (const char* const section : {"camera", "slam"})
      settings[section] = scenario::has_section(read, section) ? "given" : "none";
  } catch (const std::exception&) {
    settings.clear();
  }
  if (!about.revision.empty()) settings["revision"] = about.revision;
  if (!about.estimator_files.empty()) settings["program"] = about.estimator_files.substr(0, 12);
  return settings;
}

std::string in_one_line(const std::string& value) {
  std::string line;
  for (const char c : value) {
    if (static_cast<unsigned char>(c) > ' ')
      line += c;
    else if (!line.empty() && line.back() != ' ' && line.back() != '[' && line.back() != '{')
      line += ' ';
  }
  return line;
}

std::map<std::string, std::vector<std::string>> changed_keys(const std::vector<const RunData*>& runs) {
  std::map<std::string, std::vector<std::string>> all;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    auto settings = runs[i]->settings;
    settings["estimator"] = runs[i]->estimator;
    for (const auto& [key, value] : settings) {
      all.try_emplace(key, runs.size()).first->second[i] = in_one_line(value);
    }
  }
  std::erase_if(all, [](const auto& of_key) {
    std::set<std::string> values(of_key.second.begin(), of_key.second.end());
    values.erase("");
    return values.size() < 2;
  });
  return all;
}

namespace {

/// Returns a text for each run, from what differs within its scenario.
std::vector<std::string> within_scenarios(
    const std::vector<const RunData*>& runs,
    const std::function<std::string(const RunData& run, const std::map<std::string, std::string>& changed)>&
        text) {
  std::map<std::string, std::vector<const RunData*>> scenarios;
  for (const RunData* run : runs) scenarios[run->scenario].push_back(run);
  std::map<const RunData*, std::map<std::string, std::string>> changed;
  for (const auto& [scenario, its_runs] : scenarios)
    for (const auto& [key, values] : changed_keys(its_runs))
      for (std::size_t i = 0; i < its_runs.size(); ++i)
        if (!values[i].empty()) changed[its_runs[i]][key] = values[i];
  std::vector<std::string> texts;
  for (const RunData* run : runs) texts.push_back(text(*run, changed[run]));
  return texts;
}

std::string joined(const std::map<std::string, std::string>& settings, const std::set<std::string>& without) {
  std::vector<std::string> words;
  for (const auto& [key, value] : settings)
    if (!without.contains(key)) words.push_back(key + "=" + value);
  return fmt::format("{}", fmt::join(words, ", "));
}

}  // namespace

std::vector<std::string> variants(const std::vector<const RunData*>& runs) {
  return within_scenarios(runs, [](const RunData& run, const auto& changed) {
    const std::string keys = joined(changed, {"estimator"});
    if (keys.empty()) return run.estimator;
    return changed.contains("estimator") ? run.estimator + ", " + keys : keys;
  });
}

std::vector<std::string> other_settings(const std::vector<const RunData*>& runs) {
  return within_scenarios(runs, [](const RunData&, const auto& changed) {
    return joined(changed, {"estimator", "walk.controller", "world.robot"});
  });
}

std::string alignment_of(const result::About& about) {
  const bool is_name =
      about.alignment.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789") == std::string::npos;
  return about.alignment.empty() ? "none" : is_name ? about.alignment : "unknown";
}

std::string column_of(const std::string& metric, const std::string& alignment) {
  constexpr std::array kAligned{"rmse_m", "rotation_rmse_deg", "end_",     "drift_",
                                "nees_",  "loop_error_",       "landmark_"};
  const bool depends =
      std::ranges::any_of(kAligned, [&](const char* prefix) { return metric.starts_with(prefix); });
  return depends && alignment != "none" ? metric + "_after_" + alignment : metric;
}

RunData read_run(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw files::FileError(folder, "no such result folder");
  RunData run;
  run.folder = folder;
  if (fs::exists(folder / "recording/manifest.csv")) {
    run.recording = folder / "recording";
    recording::RecordingReader checked(run.recording);
    run.recorded = recording::read_truth(run.recording);
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
