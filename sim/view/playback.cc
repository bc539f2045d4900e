#include "sim/view/playback.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "sim/files/csv.h"
#include "sim/files/inner_file.h"
#include "sim/files/number.h"
#include "sim/files/text.h"
#include "sim/recording/image_size.h"
#include "sim/recording/manifest.h"
#include "sim/recording/recording.h"
#include "sim/report/run_data.h"

namespace sim::view {
namespace {

namespace fs = std::filesystem;
using report::Table;

constexpr std::uint64_t kMostImageBytes = 64 << 20;

slam::Stamp from_file(std::int64_t stamp) { return slam::Stamp(stamp) - recording::kEpoch; }

slam::Stamp stamp_of(const std::string& field, const fs::path& file) {
  const auto ns = files::parse_number<std::int64_t>(field);
  if (!ns) throw files::FileError(file, fmt::format("'{}' is no time stamp", field));
  return slam::Stamp(*ns);
}

/// The frames by their stamps.
class Timeline {
 public:
  explicit Timeline(std::vector<Frame>& frames) : frames_(frames) {}

  Frame* at(slam::Stamp t) {
    const auto found = std::lower_bound(frames_.begin(), frames_.end(), t,
                                        [](const Frame& f, slam::Stamp s) { return f.t < s; });
    return found != frames_.end() && found->t == t ? &*found : nullptr;
  }

 private:
  std::vector<Frame>& frames_;
};

/// The last row of a CSV file of the recording's at or before a time. Times are asked for in order.
class RowsOverTime {
 public:
  RowsOverTime(const fs::path& file, std::size_t fields) : reader_(file), row_(fields) {
    more_ = reader_.next();
    if (more_ && reader_.fields() != fields + 1)
      throw files::FileError(file, 1,
                             fmt::format("has {} columns, expected {}", reader_.fields(), fields + 1));
  }
  const std::vector<double>* at(slam::Stamp t) {
    for (; more_ && from_file(reader_.integer(0)) <= t; more_ = reader_.next()) {
      any_ = true;
      for (std::size_t i = 0; i < row_.size(); ++i) row_[i] = reader_.number(1 + i);
    }
    return any_ ? &row_ : nullptr;
  }

 private:
  files::CsvReader reader_;
  std::vector<double> row_;
  bool more_ = false, any_ = false;
};

FootPlace place_of(const recording::TrueFoot& foot) {
  return {foot.truth, foot.plan, foot.planned_down, foot.load_n};
}

void add_feet(std::vector<Frame>& frames, const std::vector<recording::TrueFeet>& feet) {
  std::size_t row = 0;
  for (Frame& frame : frames) {
    while (row + 1 < feet.size() && feet[row + 1].t <= frame.t) ++row;
    if (row < feet.size()) frame.feet = {place_of(feet[row].left), place_of(feet[row].right)};
  }
}

void add_zmp(std::vector<Frame>& frames, const fs::path& file) {
  if (!fs::exists(file)) return;
  RowsOverTime forces(file, 12);
  for (Frame& frame : frames) {
    const std::vector<double>* const row = forces.at(frame.t);
    if (!row || !frame.feet) continue;
    const auto sole = [&](std::size_t foot) {
      const double* const f = row->data() + 6 * foot;
      return SoleForce{(*frame.feet)[foot].truth, {f[0], f[1], f[2]}, {f[3], f[4], f[5]}};
    };
    frame.zmp = zero_moment_point({sole(0), sole(1)});
  }
}

std::size_t columns_of(const fs::path& file) { return files::CsvReader(file).titles().size(); }

void add_bodies(std::vector<Frame>& frames, const fs::path& file, const std::vector<files::TimedPose>& waist,
                const RobotModel& robot) {
  const std::size_t joints = columns_of(file) - 1;
  RowsOverTime encoders(file, joints);
  std::size_t row = 0;
  for (Frame& frame : frames) {
    while (row < waist.size() && waist[row].t < frame.t) ++row;
    const std::vector<double>* const q = encoders.at(frame.t);
    if (!q || row == waist.size() || waist[row].t != frame.t) continue;
    frame.bodies = robot.poses(
        Eigen::Map<const Eigen::VectorXd>(q->data(), static_cast<Eigen::Index>(joints)), waist[row].X);
  }
}

std::vector<Frame> frames_at(const std::vector<files::TumRow>& truth) {
  std::vector<Frame> frames(truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) frames[i].t = truth[i].t, frames[i].truth = truth[i].X;
  return frames;
}

void add_plan(Timeline& frames, const fs::path& file) {
  if (!fs::exists(file)) return;
  for (const files::TumRow& row : files::read_tum(file))
    if (Frame* const frame = frames.at(row.t)) frame->plan = row.X;
}

void add_estimate(Timeline& frames, const fs::path& file) {
  if (!fs::exists(file)) return;
  for (const files::TumRow& row : files::read_tum(file))
    if (Frame* const frame = frames.at(row.t)) frame->estimate = row.X, frame->covariance = row.covariance;
}

slam::Health health_of(const std::string& name) {
  return name == "lost" ? slam::Health::lost : name == "diverged" ? slam::Health::diverged : slam::Health::ok;
}

void add_reports(Timeline& frames, const fs::path& folder, const Table& table) {
  const auto &t = table.text("timestamp"), &health = table.text("health"), &cause = table.text("cause"),
             &refused = table.text("refused"), &suspect = table.text("suspect");
  const auto landmarks = table.numbers("landmarks");
  for (std::size_t i = 0; i < table.rows(); ++i) {
    Frame* const frame = frames.at(stamp_of(t[i], folder / "frames.csv"));
    if (!frame) continue;
    slam::FrameReport report;
    report.t = frame->t;
    report.landmarks = landmarks[i] >= 0 && landmarks[i] < 1e6 ? static_cast<int>(landmarks[i]) : 0;
    report.health = health_of(health[i]);
    report.cause = cause[i], report.refused = refused[i], report.suspect = suspect[i];
    frame->report = report;
  }
}

// Recordings of earlier versions do not say where a match was refused.
std::vector<double> numbers_if_there(const Table& table, const char* column) {
  return table.has(column) ? table.numbers(column) : std::vector<double>(table.rows(), NAN);
}

void add_searches(Timeline& frames, const fs::path& folder, const Table& table) {
  const auto& t = table.text("timestamp");
  const auto landmark = table.numbers("landmark"), u = table.numbers("u"), v = table.numbers("v"),
             uu = table.numbers("S_uu"), uv = table.numbers("S_uv"), vv = table.numbers("S_vv"),
             found_u = table.numbers("found_u"), found_v = table.numbers("found_v"),
             refused_u = numbers_if_there(table, "refused_u"),
             refused_v = numbers_if_there(table, "refused_v");
  for (std::size_t i = 0; i < table.rows(); ++i) {
    Frame* const frame = frames.at(stamp_of(t[i], folder / "searches.csv"));
    if (!frame || !frame->report || !(std::abs(landmark[i]) < 1e9)) continue;
    slam::Search search{static_cast<int>(landmark[i]), {u[i], v[i]}, Eigen::Matrix2d::Zero()};
    search.S << uu[i], uv[i], uv[i], vv[i];
    if (!search.S.allFinite() || !search.pixel.allFinite()) continue;
    search.used = std::isfinite(found_u[i]);
    if (search.used) search.match = {found_u[i], found_v[i]};
    if (std::isfinite(refused_u[i])) search.match = {refused_u[i], refused_v[i]};
    frame->report->searched.push_back(search);
  }
}

void add_begun(Timeline& frames, const fs::path& file) {
  if (!fs::exists(file)) return;
  const Table table(file);
  const auto& begun = table.text("begun");
  const auto u = table.numbers("u"), v = table.numbers("v");
  for (std::size_t i = 0; i < table.rows(); ++i)
    if (Frame* const frame = frames.at(stamp_of(begun[i], file));
        frame && frame->report && std::isfinite(u[i] + v[i]))
      frame->report->initialised.push_back({0, {u[i], v[i]}});
}

void add_maps(Timeline& frames, const fs::path& folder, const Table& table) {
  constexpr std::array kColumns{"p_W_x", "p_W_y", "p_W_z", "P_xx", "P_xy", "P_xz", "P_yy", "P_yz", "P_zz"};
  const auto& t = table.text("timestamp");
  const auto id = table.numbers("id");
  std::vector<std::vector<double>> c;
  for (const char* const column : kColumns) c.push_back(table.numbers(column));
  for (std::size_t i = 0; i < table.rows(); ++i) {
    Frame* const frame = frames.at(stamp_of(t[i], folder / "map_over_time.csv"));
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

/// The recording that a result was made from; empty where it is not to be found.
fs::path recording_of(const fs::path& result, const std::string& hash) {
  if (fs::exists(result / "recording/manifest.csv")) return result / "recording";
  const fs::path above = fs::absolute(result).lexically_normal().parent_path() / "recording";
  if (!hash.empty() && fs::exists(above / "manifest.csv") && recording::Manifest(above).hash() == hash)
    return above;
  return {};
}

std::vector<fs::path> image_files(const std::vector<Frame>& frames, const fs::path& recording) {
  std::vector<fs::path> images(frames.size());
  const fs::path camera = recording / "mav0/cam0";
  if (!fs::exists(camera / "data.csv")) return images;
  files::CsvReader list(camera / "data.csv");
  std::size_t row = 0;
  while (list.next()) {
    const slam::Stamp t = from_file(list.integer(0));
    while (row < frames.size() && frames[row].t < t) ++row;
    if (row < frames.size() && frames[row].t == t)
      images[row] = files::inner_file(camera / "data", list.text(1));
  }
  return images;
}

void add_recorded(std::vector<Frame>& frames, const fs::path& recording, const RobotModel* robot) {
  const recording::Truth truth = recording::read_truth(recording);
  add_feet(frames, truth.feet);
  add_zmp(frames, recording / "mav0/forces0/data.csv");
  const fs::path encoders = recording / "mav0/encoders0/data.csv";
  if (robot && fs::exists(encoders)) add_bodies(frames, encoders, truth.waist, *robot);
}

bool any_bodies(const std::vector<Frame>& frames) {
  return std::any_of(frames.begin(), frames.end(), [](const Frame& frame) { return !frame.bodies.empty(); });
}

std::vector<Moment> faults_in_score(const nlohmann::ordered_json& score, const char* kind) {
  std::vector<Moment> moments;
  const auto tracking = score.find("tracking");
  if (tracking == score.end() || !tracking->is_object() || !tracking->contains(kind)) return moments;
  for (const auto& one : (*tracking)[kind])
    moments.push_back({one.value("from_s", 0.0), kind, fmt::format("{}: {}", kind, one.value("cause", ""))});
  return moments;
}

std::vector<Moment> moments_of(const report::RunData& data, const scenario::Scenario& scenario,
                               double end_s) {
  std::vector<Moment> all = faults_of(scenario);
  if (const auto closed = data.metric("loop_time_s")) all.push_back({*closed, "closure", "loop closed"});
  for (const char* const kind : {"lost", "suspect"})
    for (const Moment& moment : faults_in_score(data.score, kind)) all.push_back(moment);
  const std::string ending = data.score.value("ending", "");
  if (ending != "completed")
    all.push_back({end_s, "end", data.about.cause.empty() ? ending : ending + ": " + data.about.cause});
  std::stable_sort(all.begin(), all.end(), [](const Moment& a, const Moment& b) { return a.t_s < b.t_s; });
  return all;
}

void name_what_is_missing(Playback& playback, const fs::path& recording, bool simulator) {
  std::vector<std::string>& missing = playback.run.missing;
  if (!simulator)
    missing.emplace_back("Room and robot are not shown: this program was built without the simulator.");
  if (recording.empty())
    missing.emplace_back("Head images, feet and joint angles are not shown: this result has no recording.");
  else if (simulator && !any_bodies(playback.frames))
    missing.emplace_back("The robot is not shown: the recording has no joint angles.");
  if (std::none_of(playback.frames.begin(), playback.frames.end(),
                   [](const Frame& f) { return f.estimate.has_value(); }))
    missing.emplace_back("There is no estimate: no filter ran, or it left none.");
}

Resource png(const fs::path& file) {
  if (fs::file_size(file) > kMostImageBytes) throw files::FileError(file, "is too large for an image");
  auto bytes = std::make_shared<const std::string>(files::read_text(file));
  if (!recording::image_size(*bytes) || !bytes->starts_with("\x89PNG"))
    throw files::FileError(file, "is no PNG image");
  return {"image/png", std::move(bytes)};
}

std::string run_json(const Playback& playback) {
  std::string text = "{\"frames\":[";
  for (std::size_t i = 0; i < playback.frames.size(); ++i) {
    std::string frame = to_json(playback.frames[i]);
    if (!playback.images[i].empty()) frame.insert(1, "\"stored_image\":true,");
    text += (i == 0 ? "" : ",") + frame;
  }
  return text + "]}";
}

std::vector<ShownRun> runs_of(const std::vector<Playback>& results) {
  std::vector<ShownRun> runs;
  for (const Playback& result : results) runs.push_back(result.run);
  return runs;
}

Site site_of(const std::vector<Playback>& results) {
  if (results.size() > 1 && results[0].scenario != results[1].scenario)
    throw std::invalid_argument(
        fmt::format("view: the results are of {} and of {}, expected two of one scenario",
                    results[0].scenario, results[1].scenario));
  Site site(runs_of(results), {{"mode", "playback"}, {"control", false}});
  for (std::size_t i = 0; i < results.size(); ++i) {
    site.add(fmt::format("/run/{}", i), json_resource(run_json(results[i])));
    site.add_list(fmt::format("/image/{}", i),
                  [images = results[i].images](std::size_t k) -> std::optional<Resource> {
                    if (k >= images.size() || images[k].empty()) return std::nullopt;
                    return png(images[k]);
                  });
  }
  return site;
}

}  // namespace

std::vector<Frame> read_recorded_frames(const fs::path& recording, const RobotModel* robot) {
  const recording::Truth truth = recording::read_truth(recording);
  std::vector<Frame> frames(truth.camera.size());
  for (std::size_t i = 0; i < frames.size(); ++i)
    frames[i].t = truth.camera[i].t, frames[i].truth = truth.camera[i].X;
  add_recorded(frames, recording, robot);
  return frames;
}

Playback read_playback(const fs::path& result, const MakeRobot& make_robot) {
  const report::RunData data = report::read_run(result);
  const scenario::Scenario scenario = scenario::read_scenario(result / "scenario.yaml").scenario;
  Playback playback;
  playback.scenario = data.score.value("scenario", "?");
  playback.frames = frames_at(files::read_tum(result / "truth.tum"));
  if (playback.frames.empty())
    throw files::FileError(result / "truth.tum", "has no pose, expected one of each frame");
  Timeline frames(playback.frames);
  add_plan(frames, result / "plan.tum");
  add_estimate(frames, result / "estimate_cov.txt");
  if (data.frames) add_reports(frames, result, *data.frames);
  if (data.searches) add_searches(frames, result, *data.searches);
  add_begun(frames, result / "landmarks.csv");
  if (data.maps) add_maps(frames, result, *data.maps);
  const fs::path recording = recording_of(result, data.about.recording);
  std::optional<RobotModel> robot;
  if (make_robot) robot = make_robot(scenario);
  if (!recording.empty()) {
    add_recorded(playback.frames, recording, robot ? &*robot : nullptr);
    playback.run.camera = recording::RecordingReader(recording).setup().calibration.camera;
  }
  playback.images = recording.empty() ? std::vector<fs::path>(playback.frames.size())
                                      : image_files(playback.frames, recording);
  playback.run.label = data.label;
  playback.run.duration_s = slam::seconds(playback.frames.back().t);
  playback.run.moments = moments_of(data, scenario, playback.run.duration_s);
  if (robot) playback.run.model = robot->model;
  name_what_is_missing(playback, recording, robot.has_value());
  return playback;
}

PlaybackView::PlaybackView(const Access& access, const std::vector<Playback>& results)
    : site_(site_of(results)),
      server_(access, {[this](std::string_view path) { return site_.at(path, server_.access().token); }}) {}

}  // namespace sim::view
