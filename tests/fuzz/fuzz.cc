// Fuzz targets, one for each reader of external input: fuzz TARGET [CORPUS or INPUT, options of libFuzzer].
// A reader may accept an input or throw one of its exceptions, nothing else.
#include <stdlib.h>

#include <opencv2/imgcodecs.hpp>
#include <set>

#include "sim/estimators/messages.h"
#include "sim/files/hash.h"
#include "sim/files/text.h"
#include "sim/model_file/model_file.h"
#include "sim/recording/asl_folder.h"
#include "sim/recording/image_file.h"
#include "sim/recording/map_file.h"
#include "sim/regression/suite.h"
#include "sim/scenario/scenario.h"
#include "sim/trials/sweep.h"
#include "sim/trials/tuning.h"
#include "sim/view/live_view.h"

namespace {

namespace fs = std::filesystem;
namespace recordings = sim::recording;
namespace scenarios = sim::scenario;
using Inputs = std::vector<std::string>;
using File = std::pair<std::string, std::string>;

/// A folder in the temporary folder, which tools/fuzz.sh removes.
const fs::path& folder() {
  static const fs::path made = [] {
    std::string pattern = (fs::temp_directory_path() / "gaitslam-fuzz-XXXXXX").string();
    return fs::path(::mkdtemp(pattern.data()));
  }();
  return made;
}

/// Writes a file of that folder and returns its path.
fs::path file(const std::string& name, std::string_view text) {
  static std::set<std::string> made;  // files whose folders exist
  const fs::path path = folder() / name;
  if (made.insert(name).second) fs::create_directories(path.parent_path());
  sim::files::write_text(path, text);
  return path;
}

/// Calls `read`, which may throw FileError or a Rejection. Returns their message, empty on success.
template <class Rejection = scenarios::ConfigError>
std::string read_or_reject(const auto& read) {
  try {
    read();
    return "";
  } catch (const Rejection& error) {
    return error.what();
  } catch (const sim::files::FileError& error) {
    return error.what();
  }
}

/// Ends the target if a property is violated.
void require(bool property) {
  if (!property) abort();
}

/// The first byte of an input selects one of several.
std::size_t selected(std::string_view text, std::size_t count) {
  return static_cast<unsigned char>(text[0]) % count;
}
Inputs one_of_each(const auto& files) {
  Inputs all;
  for (const auto& [name, content] : files) all.push_back(char(all.size()) + content);
  return all;
}

// Messages of estimators: the first byte selects the question, the next 16 are the header.

void answer(std::string_view text) {
  namespace estimators = sim::estimators;
  namespace programs = sim::programs;
  if (text.size() < 1 + programs::kHeaderBytes) return;
  read_or_reject<estimators::EstimatorFailed>([&] {
    const bool start = text[0] % 2 == 0;
    const std::size_t bytes = programs::payload_bytes(
        text.substr(1, programs::kHeaderBytes), start ? programs::Message::ready : programs::Message::answer,
        estimators::kMostBytes);
    const std::string_view payload = text.substr(1 + programs::kHeaderBytes);
    require(bytes < 20'000'000);
    if (start) {
      estimators::read_ready(payload);
      return;
    }
    const estimators::Answer answer = estimators::read_answer(payload);
    require((answer.map ? answer.map->size() : 0) * sizeof(gaitslam_landmark) <= payload.size());
    estimators::require_valid(answer, slam::Stamp(0), slam::Stamp(0), slam::Stamp(1'000'000'000));
    require(!answer.estimate || answer.estimate->X_WC.matrix().allFinite());
  });
}

std::string message(std::uint32_t type, const auto&... parts) {
  const gaitslam_header header{{'G', 'S', 'L', 'M'}, type, (sizeof(parts) + ...)};
  const auto bytes = [](const auto& part) {
    return std::string(reinterpret_cast<const char*>(&part), sizeof part);
  };
  return bytes(header) + (bytes(parts) + ...);
}

Inputs answers() {
  gaitslam_answer answer{};
  for (const int diagonal : {0, 4, 8}) answer.X_WC.rotation[diagonal] = 1;
  answer.landmark_count = 1;
  const gaitslam_ready ready{GAITSLAM_ESTIMATOR_VERSION, 0};
  return one_of_each(std::array{File{"", message(GAITSLAM_MESSAGE_READY, ready)},
                                File{"", message(GAITSLAM_MESSAGE_ANSWER, answer, gaitslam_landmark{})}});
}

// Messages of a client of the view.

void client_message(std::string_view text) {
  namespace view = sim::view;
  read_or_reject<std::invalid_argument>([&] {
    const view::ClientMessage message = view::read_client_message(text);
    require(message.factor == 0 || (message.factor >= 0.01 && message.factor <= 100));
  });
}

// Folders of other programs: the first byte selects the file.

const std::string kPose =
    "T_BS:\n  cols: 4\n  rows: 4\n  data: [0, -1, 0, 0.1, 1, 0, 0, 0.2, 0, 0, 1, 0.3, 0, 0, 0, 1]\n";
const std::array kAslFiles{
    File{"cam0/sensor.yaml",
         kPose + "rate_hz: 20\nresolution: [48, 36]\ncamera_model: pinhole\nintrinsics: [30, 30, 23, 17]\n"
                 "distortion_model: equidistant\ndistortion_coefficients: [0.1, 0, 0, 0]\n"},
    File{"imu0/sensor.yaml", kPose + "rate_hz: 20\ngyroscope_noise_density: 1e-4\n"},
    File{"gt/sensor.yaml", kPose},
    File{"cam0/data.csv", "#timestamp [ns],filename\n50000000,a.png\n100000000,a.png\n"},
    File{"imu0/data.csv", "#t,wx,wy,wz,ax,ay,az\n45000000,1,2,3,4,5,6\n95000000,1,2,3,4,5,6\n"},
    File{"gt/data.csv", "#t,px,py,pz,qw,qx,qy,qz\n40000000,1,2,3,1,0,0,0\n110000000,1,2,3,1,0,0,0\n"}};

std::string encoded(const char* format) {
  std::vector<unsigned char> bytes;
  cv::imencode(format, cv::Mat(36, 48, CV_8UC1, cv::Scalar(7)), bytes);
  return {bytes.begin(), bytes.end()};
}

void asl_folder(std::string_view text) {
  static const bool made = [] {
    for (const auto& [name, content] : kAslFiles) file("mav0/" + name, content);
    file("mav0/cam0/data/a.png", encoded(".png"));
    return true;
  }();
  if (!made || text.empty()) return;
  const auto& [name, content] = kAslFiles[selected(text, kAslFiles.size())];
  const std::string changed = "mav0/" + name;
  file(changed, text.substr(1));
  read_or_reject([] {
    recordings::AslFolder reader(folder());
    while (reader.next()) continue;
  });
  file(changed, content);
}

/// A decoded image has the requested size.
void image(std::string_view text) {
  const cv::Size asked{48, 36};
  read_or_reject([&] {
    const cv::Mat decoded = recordings::decode_image("image.png", text, asked);
    require(decoded.size() == asked && decoded.type() == CV_8UC1);
  });
}

/// The sensor.yaml of cameras, IMUs, plans and mountings, as this program and other programs write it.
void sensor_yaml(std::string_view input) {
  const std::string text(input);
  recordings::RecordingSetup setup;
  const std::string camera = read_or_reject([&] {
    recordings::read_camera_yaml({"sensor.yaml", text}, setup);
  });
  const std::string imu = read_or_reject([&] { recordings::read_imu_yaml({"sensor.yaml", text}); });
  // Both messages come from the parser, which the other readers share.
  if (!camera.empty() && camera == imu) return;
  read_or_reject([&] { recordings::read_pose({"sensor.yaml", text}, "T_BS", "T_SB"); });
  read_or_reject([&] { recordings::read_pose({"sensor.yaml", text}, "T_WC_start"); });
}

/// TUM with and without covariance, EuRoC, KITTI, declared columns.
void trajectory(std::string_view text) {
  const auto poses = file("trajectory.txt", text);
  read_or_reject([&] { sim::files::read_trajectory(poses); });
  read_or_reject([&] { sim::files::read_trajectory(poses, "t[ns] x[mm] -y z qw qx qy qz"); });
  read_or_reject([&] { sim::files::read_tum(poses); });
}

// Recordings: the first byte selects one of the files that are parsed.

fs::path root() { return folder() / "recording"; }

/// Makes a recording. Returns the content of every listed file by its relative path.
const std::map<std::string, std::string>& recorded() {
  static std::map<std::string, std::string> all;
  if (!all.empty()) return all;
  recordings::RecordingSetup setup;
  setup.calibration.camera = {48, 36, 30, 30, 24, 18, slam::OneParameterRadial{1e-4}};
  setup.joints = {"KNEE"};
  for (const char* name : {"rig_color", "rig_depth", "rig_lidar", "rig_imu"}) {
    sim::rig::RigSensor& sensor = setup.rig.emplace_back();
    sensor.name = name, sensor.kind = static_cast<sim::rig::Kind>(setup.rig.size());
    sensor.camera = setup.calibration.camera, sensor.aligned_with = "cam0", sensor.baseline_m = 0.05;
  }
  recordings::RecordingWriter writer(root(), setup);
  slam::Observation o;
  o.image = cv::Mat(36, 48, CV_8UC1, cv::Scalar(7));
  o.gyro = {{slam::Stamp{-5'000'000}, slam::Stamp{0}, {1, 2, 3}}};
  o.accelerometer = o.gyro;
  o.plan.emplace();
  for (int i = 0; i < 4; ++i) o.rig.emplace_back().sensor = i;
  o.rig[0].image = cv::Mat(36, 48, CV_8UC3, cv::Scalar(7, 8, 9));
  o.rig[1].image = cv::Mat(36, 48, CV_16UC1, cv::Scalar(700));
  o.rig[2].points = {{1, 2, 3, 0.5, 6}};
  o.rig[3].begin = slam::Stamp{-5'000'000};
  writer.add(o);
  writer.add(recordings::BodyReading{slam::Stamp{-1}, Eigen::VectorXd::Ones(1), {}, {}});
  recordings::TruePoses poses;
  poses.X_WB_desired = poses.X_WB;
  writer.add(poses);
  writer.add(recordings::TrueFeet{});
  writer.add(std::vector{sim::score::StepCorrection{}});
  writer.add(sim::score::Surface{});
  writer.finish();
  sim::files::CsvReader rows(root() / "manifest.csv", {"#xxh3_128,bytes,path"});
  while (rows.next()) all[std::string(rows.text(2))] = sim::files::read_text(root() / rows.text(2));
  return all;
}

/// The files that are parsed: all except images.
std::vector<File> parsed_files() {
  std::vector<File> all;
  std::ranges::copy_if(recorded(), std::back_inserter(all),
                       [](const auto& one) { return !one.first.ends_with(".png"); });
  return all;
}

void recording(std::string_view text) {
  static std::map<std::string, std::string> files = recorded();
  static const std::vector<File> parsed = parsed_files();
  if (text.empty()) return;
  const std::string& changed = parsed[selected(text, parsed.size())].first;
  const std::string whole = std::exchange(files[changed], std::string(text.substr(1)));
  std::string manifest = "#xxh3_128,bytes,path\n";
  for (const auto& [name, content] : files) {
    sim::files::Hash hash;
    hash.add(content);
    manifest += hash.hex() + "," + std::to_string(content.size()) + "," + name + "\n";
  }
  file("recording/manifest.csv", manifest);
  file("recording/" + changed, files[changed]);
  read_or_reject([&] {
    if (changed.starts_with("truth/")) {
      recordings::read_truth(root());
    } else {
      recordings::RecordingReader reader(root());
      while (reader.next()) continue;
    }
  });
  file("recording/" + changed, files[changed] = whole);
}

// Models of robots: MJCF or URDF.

constexpr const char* kRobots[]{
    "<mujoco><compiler angle='degree' eulerseq='zyx'/><default><joint damping='1'/></default><worldbody>\n"
    "<body name='base'><freejoint/><inertial mass='1' diaginertia='1 1 1'/><frame pos='1 0 0' euler='1 2 3'>"
    "<geom fromto='0 0 0 1 1 1'/></frame></body></worldbody><actuator><motor joint='a'/></actuator></mujoco>",
    "<robot name='r'><link name='a'/><link name='b'><visual><geometry><box size='1 1 1'/></geometry></visual>"
    "</link><joint name='j' type='fixed'><parent link='a'/><child link='b'/><origin rpy='1 2 "
    "3'/></joint></robot>"};

/// A model that is printed and read back is the same.
void model(std::string_view text) {
  namespace models = sim::model_file;
  static const models::Schema schema(
      "mujoco (!)   model \n   compiler (*)   angle eulerseq autolimits \n   default (R)   class \n      "
      "joint (?)   "
      "damping \n   actuator (*)   \n      motor (*)   joint \n   asset (*)   \n      mesh (*)   name file \n"
      "   (world)body (R)   name pos quat euler \n      inertial (?)   mass pos diaginertia fullinertia \n"
      "      freejoint (*)   name \n      joint (*)   name type range damping axis \n"
      "      geom (*)   name type fromto size pos quat mass contype conaffinity mesh \n");
  read_or_reject([&] {
    const std::string printed = to_xml(models::read_model(file("robot.xml", text), schema).root);
    require(to_xml(models::read_xml(file("printed.xml", printed))) == printed);
  });
}

// YAML: scenarios, suites, sweeps and tunings, and arguments of the command line.

const fs::path& walk() {
  static const auto made =
      file("walk.yaml", "walk: {commands: [{stand: {duration_s: 1}}]}\ncamera: {}\nslam: {}\n");
  return made;
}

/// One argument per line: an override, seeds, and the values of a sweep.
void arguments(std::string_view input) {
  const std::string text(input);
  const std::size_t end = text.find('\n');
  const std::string first = text.substr(0, end), second = end == text.npos ? "" : text.substr(end + 1);
  read_or_reject([&] { scenarios::read_scenario(walk(), {{first, second}, {}, {}}); });
  read_or_reject([&] { sim::trials::read_sweep(walk(), {first, second}); });
  read_or_reject<std::invalid_argument>([&] { scenarios::parse_seeds(first); });
}

/// A scenario that is printed and read back is the same.
void scenario(std::string_view text) {
  const std::string error = read_or_reject([&] {
    const auto read = scenarios::read_scenario_text(text, "fuzz.yaml");
    const std::string printed = scenarios::to_yaml(read.scenario);
    const auto again = scenarios::read_scenario_text(printed, "fuzz.yaml");
    require(scenarios::to_yaml(again.scenario) == printed);
  });
  require(error.empty() || (error.starts_with("fuzz.yaml:") && error.find('\n') == error.npos));
}

/// Suites, sweeps and tunings; the first byte of an input selects the reader.
void specs(std::string_view text) {
  walk();
  if (text.empty()) return;
  const auto spec = file("spec.yaml", text.substr(1));
  read_or_reject([&] {
    const std::size_t reader = selected(text, 3);
    if (reader == 0) sim::regression::read_suite(spec);
    if (reader == 1) sim::trials::read_sweep(spec, {});
    if (reader == 2) sim::trials::read_spec(spec);
  });
}

constexpr slam::CameraIntrinsics kMapCamera{};

/// A map file without the hash at its end, which is added, as otherwise each mutation would be rejected for
/// it.
void map(std::string_view text) {
  sim::files::Hash hash;
  hash.add(text);
  const fs::path made = file("map.bin", std::string(text) + hash.hex());
  read_or_reject([&] { recordings::read_map(made, kMapCamera); });
}

Inputs maps() {
  slam::SavedMap map{1, kMapCamera, {slam::Landmark{}}, slam::Vector6d::Ones(), slam::Matrix6d::Identity()};
  const std::string bytes = recordings::map_bytes(map);
  return {bytes.substr(0, bytes.size() - 32)};
}

struct Target {
  std::string_view name;
  void (*read)(std::string_view);
  Inputs (*initial)();  ///< inputs that mutations start from
};
const std::array kTargets{
    Target{"answer", answer, answers},
    Target{"arguments", arguments,
           [] {
             return Inputs{
                 "slam.gyro.sigma_rad_s=0.01\n"
                 "errors.faults=[{frames_lost: {from_s: 1, duration_s: 2}}]"};
           }},
    Target{"asl_folder", asl_folder, [] { return one_of_each(kAslFiles); }},
    Target{"client_message", client_message, [] { return Inputs{R"({"op":"speed","factor":0.25})"}; }},
    Target{"image", image,
           [] {
             return Inputs{encoded(".png"), encoded(".pgm")};
           }},
    Target{"map", map, maps},
    Target{"model", model, [] { return Inputs(std::begin(kRobots), std::end(kRobots)); }},
    Target{"recording", recording, [] { return one_of_each(parsed_files()); }},
    Target{"scenario", scenario, [] { return Inputs{}; }},  // tools/fuzz.sh: the files of scenarios/
    Target{"sensor_yaml", sensor_yaml,
           [] {
             return Inputs{kAslFiles[0].second, "%YAML:1.0\nrate_hz: 30\nfirst_interval_begins_ns: 1\n" +
                                                    std::string(kPose).replace(0, 4, "T_WC_start")};
           }},
    Target{"specs", specs,
           [] {
             const std::string suite =
                 "seeds: 1..3\nscenarios: [{scenario: walk.yaml, set: [seed=2, name=other], without: [slam], "
                 "gate: {rmse_m: {percent: 10, absolute: 0.001}}}]\n";
             const std::string sweep =
                 "scenario: walk.yaml\nseeds: 1..5,7\nparameters: {slam.vision.sigma_px: [1, 2], "
                 "slam.gyro.sigma_rad_s: {from: 0.001, to: 0.1, points: 3}}\n";
             const std::string tuning =
                 "parameters: {slam.gyro.sigma_rad_s: {from: 0.001, to: 0.1, start: 0.01, scale: log, also: "
                 "[slam.vision.sigma_px]}}\ntraining: [{scenario: walk.yaml, seeds: 1..4, set: [seed=2]}]\n"
                 "holdout: [{scenario: walk.yaml, seeds: 9}]\nobjective: pose_nll\ntrials: 60\n"
                 "population: 8\nseed: 5\n";
             return one_of_each(std::array{File{"", suite}, File{"", sweep}, File{"", tuning}});
           }},
    Target{"trajectory", trajectory, [] {
             return Inputs{"1 0 0 1 0 1 0 2 0 0 1 3\n", "# a\n1.5 1 2 3 0 0 0 1\n2.5 1 2 3 0 0 0 1\n"};
           }}};
const Target* target = nullptr;

}  // namespace

/// Takes the target from the command line and writes its initial inputs into the first folder that follows.
/// Without a target, prints their names.
extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  for (const Target& one : kTargets)
    if (*argc > 1 && one.name == (*argv)[1]) target = &one;
  if (!target) {
    for (const Target& one : kTargets) std::printf("%s\n", one.name.data());
    std::exit(*argc > 1 ? 2 : 0);
  }
  std::rotate(*argv + 1, *argv + 2, *argv + *argc);
  --*argc;
  const fs::path corpus = *argc > 1 ? (*argv)[1] : "";
  if (fs::is_directory(corpus))
    for (std::size_t i = 0; const std::string& input : target->initial())
      sim::files::write_text(corpus / ("initial-" + std::to_string(i++)), input);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  target->read(std::string_view(reinterpret_cast<const char*>(data), size));
  return 0;
}
