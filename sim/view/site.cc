#include "sim/view/site.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <future>
#include <nlohmann/json.hpp>
#include <regex>

#include "sim/export/export.h"
#include "sim/files/json.h"
#include "sim/files/text.h"
#include "sim/pages/pages.h"
#include "sim/recording/cache.h"
#include "sim/recording/manifest.h"
#include "sim/recording/recording_format.h"
#include "sim/score/metrics.h"

// The page, and the files that esbuild generates from web/.
GAITSLAM_EMBED(gaitslam_view_page, GAITSLAM_VIEW_PAGE)
GAITSLAM_EMBED(gaitslam_view_script, GAITSLAM_VIEW_BUNDLE "/view.js")
GAITSLAM_EMBED(gaitslam_view_style, GAITSLAM_VIEW_BUNDLE "/view.css")

namespace sim::view {
namespace {

using nlohmann::ordered_json;
namespace recording_format = recording::recording_format;

Resource resource(std::string type, std::string_view bytes) {
  return {std::move(type), std::make_shared<const std::string>(bytes)};
}

constexpr const char* kJson = "application/json";
// Niceness of painting, because a page's first picture, drawn without textures, has priority.
constexpr int kPaintingNice = 5;
constexpr std::string_view kIcon =
    "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 16 16'><circle cx='8' cy='8' r='6' "
    "fill='#0069b0'/></svg>";

ordered_json json_of(const slam::CameraIntrinsics& camera) {
  return {{"width", camera.width_px}, {"height", camera.height_px}, {"fu", camera.fu_px},
          {"fv", camera.fv_px},       {"u0", camera.u0_px},         {"v0", camera.v0_px}};
}

ordered_json json_of(const ShownRun& run) {
  ordered_json moments = ordered_json::array();
  for (const Moment& moment : run.moments)
    moments.push_back({{"t", moment.t_s}, {"kind", moment.kind}, {"text", moment.text}});
  ordered_json rig = ordered_json::array();
  for (const rig::RigSensor& sensor : run.rig)
    rig.push_back({{"name", sensor.name},
                   {"kind", rig::kKinds.at(static_cast<std::size_t>(sensor.kind))},
                   {"range", {sensor.nearest_m, sensor.furthest_m}}});
  const cv::Mat3b& palette = view::palette();
  const std::vector<unsigned char> colors(palette.ptr(), palette.ptr() + palette.total() * 3);
  return {{"label", run.label},
          {"scenario", run.scenario},
          {"seed", run.seed},
          {"variant", run.variant},
          {"recording", run.recording},
          {"seen", run.seen ? ordered_json(*run.seen) : ordered_json(nullptr)},
          {"pieces", run.pieces},
          {"duration", run.duration_s},
          {"sole", run.sole ? ordered_json{run.sole->min().x(), run.sole->min().y(), run.sole->max().x(),
                                           run.sole->max().y()}
                            : ordered_json(nullptr)},
          {"missing", run.missing},
          {"has_model", run.model.has_value()},
          {"camera", run.camera ? json_of(*run.camera) : ordered_json(nullptr)},
          {"moments", moments},
          {"rig", rig},
          {"palette", run.rig.empty() ? ordered_json(nullptr) : ordered_json(colors)}};
}

/// Adds feet, the zero-moment point and the robot's bodies from a recording to frames, in chronological
/// order.
class RecordedMotion {
 public:
  explicit RecordedMotion(const recording::Manifest& manifest)
      : feet_(manifest, recording_format::kFeet.file),
        forces_(manifest, recording_format::sensor_rows("forces0")),
        waist_(manifest, recording_format::kTrueWaist.file),
        encoders_(manifest, recording_format::sensor_rows("encoders0")) {
    for (exports::RecordedRows* rows : {&feet_, &forces_, &waist_, &encoders_}) rows->first();
  }

  bool has_joints() const { return !encoders_.newest.empty(); }

  /// robot: may be absent.
  void add(Frame& frame, const std::optional<RobotModel>& robot) {
    for (exports::RecordedRows* rows : {&feet_, &forces_, &waist_, &encoders_}) rows->until(frame.t);
    if (feet_.newest.size() >= 22) frame.feet = {foot(&feet_.newest[0]), foot(&feet_.newest[11])};
    if (forces_.newest.size() == 12 && frame.feet)
      frame.zmp = zero_moment_point({sole(frame, 0), sole(frame, 1)});
    const std::vector<double>&q = encoders_.newest, &X = waist_.newest;
    if (!robot || q.empty() || X.size() != 12) return;
    Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
    X_WB.translation() = Eigen::Vector3d(&X[0]);
    X_WB.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&X[3]);
    frame.bodies = robot->poses(Eigen::Map<const Eigen::VectorXd>(q.data(), std::ssize(q)), X_WB,
                                slam::seconds(frame.t));
  }

 private:
  static FootPlace foot(const double* v) {
    return {{Eigen::Vector3d(v), Eigen::Vector3d(v + 3), v[6] == 1, v[7], Eigen::Vector3d(v + 8)}};
  }
  SoleForce sole(const Frame& frame, std::size_t foot) const {
    const double* const f = &forces_.newest[6 * foot];
    return {(*frame.feet)[foot].truth, Eigen::Vector3d(f), Eigen::Vector3d(f + 3)};
  }

  exports::RecordedRows feet_, forces_, waist_, encoders_;
};

constexpr std::size_t kMostCandidates = 2000;  // folders that are searched for a recording

bool has_recording(const fs::path& result, const std::string& hash) try {
  files::Hash own;
  own.add(files::read_text(result / "recording/manifest.csv", files::kMostOfRows));
  return own.hex() == hash;
} catch (const files::FileError&) {
  return false;
}

/// Returns the recording of a result: its own, or the one with this hash in the enclosing folder, in the
/// given results, in the cache, or up to two levels below one of the two folders above it. Empty if not
/// found.
fs::path recording_of(const fs::path& result, const std::string& hash, const std::vector<fs::path>& given) {
  if (fs::exists(result / "recording/manifest.csv")) return result / "recording";
  if (hash.empty()) return {};
  const fs::path above = fs::absolute(result).lexically_normal().parent_path();
  std::vector<fs::path> candidates{above};
  candidates.insert(candidates.end(), given.begin(), given.end());
  try {
    const recording::Cache cache(recording::cache_place());
    for (const auto& entry : cache.list()) candidates.push_back(cache.place().folder / entry.key);
  } catch (const std::exception&) {
    // An unreadable cache has no recordings.
  }
  for (const fs::path& beside : {above, above.parent_path()}) {
    std::error_code fault;
    fs::recursive_directory_iterator at(beside, fs::directory_options::skip_permission_denied, fault);
    for (const fs::recursive_directory_iterator end; !fault && at != end; at.increment(fault)) {
      if (at.depth() > 0) at.disable_recursion_pending();
      if (at->is_directory(fault) && candidates.size() < kMostCandidates) candidates.push_back(at->path());
    }
  }
  for (const fs::path& candidate : candidates)
    if (has_recording(candidate, hash)) return candidate / "recording";
  return {};
}

std::vector<Moment> moments_of(const pages::RunData& data, const scenario::Scenario& scenario, double end_s) {
  std::vector<Moment> all = faults_of(scenario);
  if (const auto closed = data.value("loop_time_s")) all.push_back({*closed, "closure", "loop closed"});
  for (const result::ScoredFault& fault : data.faults)
    all.push_back({fault.from_s, fault.kind, fmt::format("{}: {}", fault.kind, fault.cause)});
  if (data.ending != scenario::Ending::completed)
    all.push_back({end_s, "end",
                   fmt::format("{}{}{}", name_of(data.ending), data.about.cause.empty() ? "" : ": ",
                               data.about.cause)});
  std::ranges::stable_sort(all, {}, &Moment::t_s);
  return all;
}

void add_missing(Playback& playback, const fs::path& result, const std::string& hash, bool has_joints) {
  const auto none = [&](const auto& has) { return std::ranges::none_of(playback.frames, has); };
  std::vector<std::string>& missing = playback.run.missing;
  if (!playback.pictures)
    missing.push_back(
        hash.empty() ? "Head images, feet and joint angles are not shown: this result has no recording."
                     : fmt::format("Head images, feet and joint angles are not shown: recording {} is not in "
                                   "{}, nor in neighboring results, nor in the recording cache. View the "
                                   "result together with the result of its walk.",
                                   hash.substr(0, 12), (result / "recording").string()));
  else if (playback.run.model && !has_joints)
    missing.emplace_back("The robot is not shown: the recording has no joint angles.");
  if (none([](const Frame& frame) { return frame.estimate.has_value(); }))
    missing.emplace_back("No estimate: the run had no filter, or the filter gave no estimate.");
}

/// Returns the index of the first frame of each piece, followed by the number of frames.
std::vector<std::size_t> pieces_of(const std::vector<Frame>& frames) {
  std::vector<std::size_t> begins{0};
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (frames[i].t >= frames[begins.back()].t + (begins.size() == 1 ? kFirstPiece : kPiece))
      begins.push_back(i);
  begins.push_back(frames.size());
  return begins;
}

void add_frames(Site& site, std::size_t run, const std::shared_ptr<Playback>& playback) {
  Series series;
  for (const Frame& frame : playback->frames) series.add(frame);
  site.add(fmt::format("/series/{}", run), bytes_resource(series.bytes()));
  const std::vector<std::size_t> begins = pieces_of(playback->frames);
  site.add_list(
      fmt::format("/frames/{}", run),
      [playback, begins, done = std::size_t{0}](std::size_t piece) mutable -> std::optional<Resource> {
        if (piece + 1 >= begins.size()) return std::nullopt;
        for (; done < begins[piece + 1]; ++done) playback->complete(playback->frames[done]);
        ordered_json frames = ordered_json::array();
        for (std::size_t i = begins[piece]; i < begins[piece + 1]; ++i) {
          frames.push_back(to_json(playback->frames[i]));
          if (!playback->images[i].empty()) frames.back()["stored_image"] = true;
          if (playback->sources[i]) frames.back()["source"] = *playback->sources[i];
          if (!playback->rig.empty()) frames.back()["rig"] = i;
        }
        return resource(kJson, files::json_text(frames));
      });
}

/// Sets which frame's image reached the estimator with each frame, and its errors.
void add_image_errors(Playback& playback, const scenario::Scenario& scenario) {
  playback.sources.resize(playback.frames.size());
  if (!scenario.slam || !playback.pictures) return;
  playback.errors.emplace(scenario.errors.image, scenario.seed, scenario.errors.faults);
  sensor_errors::ImageSources sources(scenario.errors, scenario.seed);
  for (std::size_t i = 0; i < playback.frames.size(); ++i)
    if (const auto t = sources.at(playback.frames[i].t, !playback.images[i].empty()))
      playback.sources[i] =
          std::ranges::lower_bound(playback.frames, *t, {}, &Frame::t) - playback.frames.begin();
}

/// Serves the images as they reached the estimator, row by row, by the number of their source.
void add_seen(Site& site, std::size_t run, const std::shared_ptr<const Playback>& playback) {
  const rig::RigSensor camera = recording::head_camera(playback->pictures->setup());
  site.add_list(fmt::format("/seen/{}", run), [=](std::size_t k) -> std::optional<Resource> {
    if (k >= playback->images.size() || playback->images[k].empty()) return std::nullopt;
    const cv::Mat ideal = playback->pictures->read(camera, playback->images[k]).image;
    const cv::Mat image = playback->errors->apply(ideal, playback->frames[k].t);
    return bytes_resource(std::string(image.begin<char>(), image.end<char>()));
  });
}

bool tracks(const Frame& frame) {
  return error_of(frame) && (!frame.report || frame.report->health == slam::Health::ok);
}

/// Returns the errors of two runs over the frames that both track, as rows of the table of changes; none if
/// both track until the same time.
ordered_json common_rows(const Playback& a, const Playback& b, const std::vector<std::string>& titles) {
  std::array<slam::Stamp, 2> ends{};
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();  // position and heading; a and b
  double count = 0;
  auto other = b.frames.begin();
  for (const Frame& frame : a.frames) {
    while (other != b.frames.end() && other->t < frame.t) ++other;
    const bool of_a = tracks(frame), of_b = other != b.frames.end() && other->t == frame.t && tracks(*other);
    if (of_a) ends[0] = frame.t;
    if (of_b) ends[1] = frame.t;
    if (!of_a || !of_b) continue;
    ++count;
    for (const int run : {0, 1}) {
      const Eigen::Vector4d e = error_of(run == 0 ? frame : *other)->error;
      squares.col(run) += Eigen::Vector2d(e.head<3>().squaredNorm(), e(3) * e(3));
    }
  }
  ordered_json rows = ordered_json::array();
  if (ends[0] == ends[1] || count == 0) return rows;
  const double end_s = slam::seconds(std::min(ends[0], ends[1]));
  const auto change = std::ranges::find(titles, "change from A to B") - titles.begin();
  for (const auto& [name, unit, factor, i] :
       {std::tuple{"position", "mm", pages::kMm, 0}, {"heading", "deg", pages::kDeg, 1}}) {
    const Eigen::RowVector2d rms = factor * (squares.row(i) / count).cwiseSqrt();
    std::vector<std::string> cells(titles.size());
    cells[0] = fmt::format("RMS error of {} while both track, to {:.1f} s [{}]", name, end_s, unit);
    cells[1] = fmt::format("{:.4g}", rms(0)), cells[2] = fmt::format("{:.4g}", rms(1));
    cells[static_cast<std::size_t>(change)] = fmt::format("{:+.3g}", rms(1) - rms(0));
    rows.push_back(
        {{"key", false}, {"cells", cells}, {"remark", "over the common tracked time"}, {"t", end_s}});
  }
  return rows;
}

/// Returns the table of changes; t: the time at which the worse of the first two runs is worst in a metric.
/// Other seeds are paired if both runs have the same seed.
ordered_json changes_of(const std::vector<std::shared_ptr<Playback>>& results) {
  std::vector<const pages::RunData*> runs;
  for (const auto& result : results) runs.push_back(&result->data);
  const pages::RunData &a = *runs[0], &b = *runs[1];
  std::vector<result::SeedScore> of_a{a}, of_b{b};
  if (a.seed == b.seed) of_a = pages::seeds_beside(a), of_b = pages::seeds_beside(b);
  of_b.front().seed = of_a.front().seed;
  const pages::ChangeTable table = pages::changes(runs, of_a, of_b);
  ordered_json rows = common_rows(*results[0], *results[1], table.titles);
  for (const auto& row : table.rows) {
    const auto loss = [&](const pages::RunData& run) {
      const auto value = run.value(row.metric);
      return value ? score::loss(*value, score::direction_of(row.metric)) : -INFINITY;
    };
    const auto t =
        row.metric.empty() ? std::nullopt : pages::worst_instant(loss(a) > loss(b) ? a : b, row.metric);
    rows.push_back({{"key", row.metric.empty()},
                    {"cells", row.cells},
                    {"remark", row.remark},
                    {"t", t ? ordered_json(*t) : ordered_json(nullptr)}});
  }
  return {{"titles", table.titles}, {"rows", rows}};
}

/// Readers of a recording; absent without one.
struct Recorded {
  explicit Recorded(const fs::path& recording) {
    if (recording.empty()) return;
    pictures = std::make_shared<const pages::Pictures>(recording);
    motion = std::make_shared<RecordedMotion>(pictures->manifest());
  }
  std::shared_ptr<const pages::Pictures> pictures;
  std::shared_ptr<RecordedMotion> motion;
};

}  // namespace

void add_robot(ShownRun& run, const std::optional<RobotModel>& robot) {
  if (robot)
    run.model = robot->model, run.sole = robot->sole;
  else
    run.missing.emplace_back("Room and robot are not shown: this program was built without the simulator.");
}

std::vector<Moment> faults_of(const scenario::Scenario& scenario) {
  std::vector<Moment> moments;
  for (const sensor_errors::Fault& fault : scenario.errors.faults)
    std::visit(
        [&](const auto& one) {
          std::string name = one.kName;
          std::replace(name.begin(), name.end(), '_', ' ');
          moments.push_back({one.from_s, "fault", fmt::format("{} for {} s", name, one.duration_s)});
        },
        fault);
  return moments;
}

Message json_message(const ordered_json& content) {
  return {std::make_shared<const std::string>(files::json_text(content)), false};
}

Resource bytes_resource(std::string bytes) { return resource("application/octet-stream", bytes); }

void add_rig(Site& site, std::size_t sensors, std::size_t run,
             const std::function<std::string(std::size_t, std::size_t)>& reading) {
  for (std::size_t sensor = 0; sensor < sensors; ++sensor)
    site.add_list(fmt::format("/rig/{}/{}", run, sensor),
                  [=](std::size_t number) { return bytes_resource(reading(sensor, number)); });
}

Site::Site(const std::vector<ShownRun>& runs, ordered_json about) : page_(gaitslam_view_page()) {
  add("/view.js", resource("text/javascript; charset=utf-8", gaitslam_view_script()));
  add("/view.css",
      resource("text/css; charset=utf-8", std::string(gaitslam_view_style()) + pages::figure_style()));
  add("/icon.svg", resource("image/svg+xml", kIcon));
  about["runs"] = ordered_json::array();
  for (std::size_t i = 0; i < runs.size(); ++i) {
    about["runs"].push_back(json_of(runs[i]));
    if (!runs[i].model || i > 0) continue;  // the page shows a single room and robot
    add("/model/0", bytes_resource(runs[i].model->pieces));
    using Pictures = std::vector<std::string>;
    add_list("/picture/0",
             [paint = runs[i].model->pictures,
              painted = std::shared_future<Pictures>()](std::size_t k) mutable -> std::optional<Resource> {
               if (!painted.valid())
                 painted = std::async(std::launch::async, [paint] {
                             setpriority(PRIO_PROCESS, 0, kPaintingNice);  // only of this thread
                             return paint();
                           }).share();
               if (painted.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
                 return bytes_resource("");
               return k < painted.get().size() ? std::optional(resource("image/png", painted.get()[k]))
                                               : std::nullopt;
             });
  }
  add("/about", resource(kJson, files::json_text(about)));
}

void Site::add(const std::string& path, Resource resource) { files_[path] = std::move(resource); }

void Site::add_list(const std::string& folder, std::function<std::optional<Resource>(std::size_t)> element) {
  lists_[folder] = std::move(element);
}

std::optional<Resource> Site::at(std::string_view path, std::string_view token) {
  if (path == "/")  // the page refers to its files with the token
    return resource("text/html; charset=utf-8",
                    std::regex_replace(page_, std::regex("TOKEN"), std::string(token)));
  if (const auto file = files_.find(path); file != files_.end()) return file->second;
  const std::size_t slash = path.rfind('/');
  if (slash == path.npos) return std::nullopt;
  const auto list = lists_.find(path.substr(0, slash));
  const auto number = files::parse_number<std::size_t>(path.substr(slash + 1));
  return list != lists_.end() && number ? list->second(*number) : std::nullopt;
}

Playback read_playback(const fs::path& result, const MakeRobot& make_robot,
                       const std::vector<fs::path>& given) {
  const scenario::Scenario scenario = scenario::read_scenario(result / "scenario.yaml").scenario;
  const fs::path recording = recording_of(result, result::read_about(result / "about.json").recording, given);
  const auto robot = std::async(std::launch::async, [&] {
                       return make_robot ? std::optional(make_robot(scenario)) : std::nullopt;
                     }).share();
  auto recorded_of = std::async(std::launch::async, [&] { return Recorded(recording); });
  pages::RunData data = pages::read_run(result, pages::Reads::poses);
  Playback playback;
  auto parts = pages::frame_parts(data);
  playback.frames = std::move(data.frames);
  if (playback.frames.empty())
    throw files::FileError(result / "truth.tum", "has no poses, expected one per frame");
  add_robot(playback.run, robot.get());
  playback.images.resize(playback.frames.size());
  const auto [pictures, motion] = recorded_of.get();
  if (pictures) {
    playback.pictures = pictures;
    playback.images = pictures->files(playback.frames);
    playback.run.camera = pictures->setup().calibration.camera;
    playback.run.rig = pictures->setup().rig;
    for (const rig::RigSensor& sensor : playback.run.rig)
      playback.rig.push_back(sensor.kind == rig::Kind::imu ? std::vector<std::string>()
                                                           : pictures->files(playback.frames, sensor.name));
  }
  playback.complete = [parts, motion = motion, robot = robot.get(),
                       footing = Footing(playback.run.sole)](Frame& frame) mutable {
    parts(frame);
    if (motion) motion->add(frame, robot);
    footing.add(frame);
  };
  add_image_errors(playback, scenario);
  playback.run.label = data.label();
  playback.run.scenario = data.scenario, playback.run.seed = data.seed;
  playback.run.recording = data.about.recording;
  if (playback.run.recording.empty() && !recording.empty())
    playback.run.recording = pictures->manifest().hash();
  playback.run.duration_s = slam::seconds(playback.frames.back().t);
  playback.run.moments = moments_of(data, scenario, playback.run.duration_s);
  add_missing(playback, result, data.about.recording, motion && motion->has_joints());
  playback.data = std::move(data);
  return playback;
}

Site playback_site(std::vector<Playback> given, ordered_json about) {
  std::vector<const pages::RunData*> data;
  std::vector<std::shared_ptr<Playback>> results;
  for (Playback& one : given) {
    results.push_back(std::make_shared<Playback>(std::move(one)));
    data.push_back(&results.back()->data);
    if (data.back()->scenario != data[0]->scenario)
      throw std::invalid_argument(
          fmt::format("view: the results are from {} and {}, expected a single scenario", data[0]->scenario,
                      data.back()->scenario));
  }
  const std::vector<std::string> variants = pages::variants(data);
  std::vector<ShownRun> runs;
  for (std::size_t i = 0; i < results.size(); ++i) {
    results[i]->run.variant = variants[i];
    const auto same = std::ranges::find_if(results, [&](const auto& other) {
      return other->run.recording == results[i]->run.recording && other->errors == results[i]->errors &&
             other->sources == results[i]->sources;
    });
    if (results[i]->errors) results[i]->run.seen = same - results.begin();
    results[i]->run.pieces = pieces_of(results[i]->frames).size() - 1;
    runs.push_back(results[i]->run);
  }
  about.update({{"mode", "playback"}, {"control", false}});
  if (data.size() > 1) about["changes"] = changes_of(results);
  Site site(runs, about);
  site.at("/picture/0/0", "");  // starts painting early, because the browser takes a while to ask for it
  for (std::size_t i = 0; i < results.size(); ++i) {
    add_frames(site, i, results[i]);
    if (!results[i]->pictures) continue;
    if (results[i]->errors) add_seen(site, i, results[i]);
    std::vector<rig::RigSensor> sensors = results[i]->run.rig;
    sensors.push_back(recording::head_camera(results[i]->pictures->setup()));
    std::vector<std::vector<std::string>> files = results[i]->rig;
    files.push_back(results[i]->images);
    add_rig(
        site, sensors.size(), i,
        [sensors, files, pictures = results[i]->pictures](std::size_t sensor, std::size_t k) -> std::string {
          if (k >= files[sensor].size() || files[sensor][k].empty()) return "";
          return sent(pictures->read(sensors[sensor], files[sensor][k]), sensors[sensor]);
        });
  }
  return site;
}

PlaybackView::PlaybackView(const Access& access)
    : site_(Site({}, {{"mode", "reading"}})),
      server_(access, {[this](std::string_view path) { return site_.at(path, server_.access().token); }}) {}

void PlaybackView::show(std::vector<Playback> results) {
  site_.replace(playback_site(std::move(results), ordered_json::object()));
}

}  // namespace sim::view
