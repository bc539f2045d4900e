// A run as shown by the page: its description, time series, the frames of finished results and of
// recordings, and the fixed list of files that the server offers.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <mutex>
#include <nlohmann/json_fwd.hpp>

#include "sim/pages/html.h"
#include "sim/pages/pictures.h"
#include "sim/pages/run_data.h"
#include "sim/recording/recording.h"
#include "sim/scenario/scenario.h"
#include "sim/view/messages.h"
#include "sim/view/server.h"
#include "slam/options.h"

namespace sim::view {

namespace fs = std::filesystem;

/// Robot and room. pieces: triangles of one body and picture: with_length() of {body, picture, alpha,
/// vertices, indices} of each (body: index of the pose in Frame::bodies, -1: the room; picture: index in the
/// pictures, -1: plain color; alpha: below 1 for glass); then for each piece, in the axes of its body,
/// positions (m), normals and RGB (0 to 1) of its vertices, with a picture, their places in it from the
/// upper left (all float32), and the indices of its triangles (uint32).
struct Model {
  std::string pieces;
  /// Paints the pictures; returns each as PNG. Called once, from any thread.
  std::function<std::vector<std::string>()> pictures = [] { return std::vector<std::string>(); };
};

/// An event to jump to. kind: "closure", "fault", "lost", "suspect" or "end".
struct Moment {
  double t_s = 0;
  std::string kind, text;
};

struct ShownRun {
  std::string label;                                        ///< "tangent_circle, seed 1"
  std::string scenario = {}, variant = {}, recording = {};  ///< for a finished run; recording: its hash
  std::uint64_t seed = 0;
  std::optional<std::size_t> seen = {};  ///< first run with the same images as its estimator got
  std::size_t pieces = 0;                ///< number of pieces in which its frames are served
  std::optional<slam::CameraIntrinsics> camera = std::nullopt;
  double duration_s = 0;  ///< 0: unknown
  std::vector<Moment> moments = {};
  std::vector<std::string> missing = {};  ///< sentences that state what is not shown, and why
  std::optional<Model> model = std::nullopt;
  std::optional<Eigen::AlignedBox2d> sole = std::nullopt;  ///< outline relative to the sole point, m
  std::vector<rig::RigSensor> rig = {};
};

/// Adds a robot and its room or, without the simulator, a sentence stating that they are missing.
void add_robot(ShownRun& run, const std::optional<struct RobotModel>& robot);

/// Returns the start of each fault in the scenario, with the fault's name and duration.
std::vector<Moment> faults_of(const scenario::Scenario& scenario);

/// Paths are compared literally: no path from a client reaches the disk.
class Site {
 public:
  /// The page, its script and style; /about (about: additional keys); and for the first run
  /// /model/0 and /picture/0/k. These are painted in another thread after the first request and are empty
  /// until then.
  Site(const std::vector<ShownRun>& runs, nlohmann::ordered_json about);

  void add(const std::string& path, Resource resource);
  /// Adds a list as <folder>/<number>; `element` returns nullopt past the end.
  void add_list(const std::string& folder, std::function<std::optional<Resource>(std::size_t)> element);

  std::optional<Resource> at(std::string_view path, std::string_view token);

 private:
  std::string page_;
  std::map<std::string, Resource, std::less<>> files_;
  std::map<std::string, std::function<std::optional<Resource>(std::size_t)>, std::less<>> lists_;
};

/// A site that may be replaced while it is served.
class ServedSite {
 public:
  explicit ServedSite(Site site) : site_(std::move(site)) {}
  void replace(Site site) {
    const std::lock_guard lock(mutex_);
    site_ = std::move(site);
  }
  std::optional<Resource> at(std::string_view path, std::string_view token) {
    const std::lock_guard lock(mutex_);
    return site_.at(path, token);
  }

 private:
  std::mutex mutex_;
  Site site_;
};

/// Returns a text message that must not be lost.
Message json_message(const nlohmann::ordered_json& content);

/// Returns the bytes as application/octet-stream.
Resource bytes_resource(std::string bytes);

/// Adds /rig/<run>/<sensor>/<number> for each sensor: the run's rig, then, for a finished run, the head
/// camera. reading: returns what the page shows, or "".
void add_rig(Site& site, std::size_t sensors, std::size_t run,
             const std::function<std::string(std::size_t sensor, std::size_t number)>& reading);

/// The force on a foot: position (m, W) and yaw of its sole point; force and torque in the sole's axes.
struct SoleForce {
  Eigen::Vector3d place;  ///< x, y (m), yaw (rad)
  Eigen::Vector3d force, torque;
};

/// Returns the zero-moment point of the ground forces on both soles, assumed level; nullopt below 20 N.
std::optional<Eigen::Vector2d> zero_moment_point(const std::array<SoleForce, 2>& soles);

/// The values of frames in chronological order, for the time plots (web/compare.js); NaN: unknown.
class Series {
 public:
  /// Time (s); errors and their standard deviations (mm, deg); NEES; landmarks in the map and found; distance
  /// that the standing soles moved (mm); distance of the zero-moment point inside the support polygon (mm);
  /// NIS by degrees of freedom, by score::kSensors; health as in slam::Health.
  static constexpr std::array kNames{"t",          "x",          "y",
                                     "z",          "heading",    "sigma_x",
                                     "sigma_y",    "sigma_z",    "sigma_heading",
                                     "nees",       "landmarks",  "found",
                                     "slip_left",  "slip_right", "margin",
                                     "nis_vision", "nis_gyro",   "nis_plan_velocity",
                                     "nis_height", "health"};
  using Row = std::array<double, kNames.size()>;

  void add(const Frame& frame);
  const std::vector<Row>& rows() const { return rows_; }
  /// Returns with_length() of the list of names, then the columns as float32.
  std::string bytes() const;

 private:
  std::vector<Row> rows_;
};

/// Completes frames in chronological order with where each foot landed and slipped, and the support polygon.
class Footing {
 public:
  /// sole: the outline of both soles; without it, there is no support polygon.
  explicit Footing(const std::optional<Eigen::AlignedBox2d>& sole) : sole_(sole) {}
  void add(Frame& frame);

 private:
  std::optional<Eigen::AlignedBox2d> sole_;
  std::array<std::optional<Eigen::Vector3d>, 2> landed_;
};

/// The robot of a scenario. poses: returns the poses of its model's bodies, from encoders and the waist pose
/// in W.
struct RobotModel {
  Model model;
  Eigen::AlignedBox2d sole;  ///< outline of the soles
  std::function<std::vector<float>(const Eigen::VectorXd& q, const Eigen::Isometry3d& X_WB, double t_s)>
      poses;
};

/// Loads a scenario's robot; empty without the simulator. Throws std::runtime_error if the models do not
/// load.
using MakeRobot = std::function<RobotModel(const scenario::Scenario&)>;

/// Returns a function that loads robots; empty in a program without the simulator.
MakeRobot robot_maker(const fs::path& models);

/// A result for playback by the page.
struct Playback {
  ShownRun run;
  pages::RunData data;        ///< without its frames, which are below
  std::vector<Frame> frames;  ///< with poses and the filter's state
  /// Adds the rest except the image to each frame, in chronological order, reading the files as far as
  /// needed.
  std::function<void(Frame&)> complete = [](Frame&) {};
  std::vector<std::string> images;  ///< PNG of each frame, or ""
  std::vector<std::optional<std::size_t>>
      sources;  ///< frame whose image reached the estimator with each frame
  std::optional<sensor_errors::ImageErrors> errors;  ///< of these images; absent without an estimator
  std::vector<std::vector<std::string>> rig = {};    ///< the same for each rig sensor
  std::shared_ptr<const pages::Pictures> pictures;   ///< absent without a recording
};

/// Reads a result folder and its recording. A result without its own recording uses the one with the
/// hash in about.json: from the enclosing result, a given one, the cache, or a nearby result. Missing parts
/// are listed in ShownRun::missing. Throws FileError if it is not a result or a file is broken.
Playback read_playback(const fs::path& result, const MakeRobot& make_robot,
                       const std::vector<fs::path>& given = {});

inline constexpr std::size_t kMostRuns = 4;  ///< maximum on a page
/// Durations of the frames in one resource. A page shows its first picture once it has the first resource.
inline constexpr slam::Stamp kFirstPiece = std::chrono::seconds(1), kPiece = std::chrono::seconds(10);

/// Returns the files of one result, or of several results of the same scenario. about: additional keys.
/// Throws std::invalid_argument if there are two scenarios.
Site playback_site(std::vector<Playback> results, nlohmann::ordered_json about);

/// Serves results. Until show(), the page waits.
class PlaybackView {
 public:
  /// Throws whatever Server throws.
  explicit PlaybackView(const Access& access);
  const Access& access() const { return server_.access(); }
  /// Throws as playback_site() does.
  void show(std::vector<Playback> results);

 private:
  ServedSite site_;
  Server server_;
};

}  // namespace sim::view
