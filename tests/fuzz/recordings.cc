// Recordings; folders and trajectories of other programs. Of several files the first byte selects one.
#include <opencv2/imgcodecs.hpp>

#include "sim/recording/asl_folder.h"
#include "sim/recording/image_file.h"
#include "tests/fuzz/fuzz_input.h"

namespace fuzz {

namespace recordings = sim::recording;

using File = std::pair<const char*, const char*>;
inline constexpr const char* kPose =
    "T_BS:\n  cols: 4\n  rows: 4\n  data: [0, -1, 0, 0.1, 1, 0, 0, 0.2, 0, 0, 1, 0.3, 0, 0, 0, 1]\n";
inline constexpr std::array kFiles{
    File{"cam0/sensor.yaml",
         "rate_hz: 20\nresolution: [48, 36]\nintrinsics: [30, 30, 23, 17]\ndistortion_model: radtan\n"
         "distortion_coefficients: [0, 0, 0, 0]\n"},
    File{"imu0/sensor.yaml", "rate_hz: 20\ngyroscope_noise_density: 1e-4\n"},
    File{"gt/sensor.yaml", ""},
    File{"cam0/data.csv", "#timestamp [ns],filename\n50000000,a.png\n100000000,a.png\n"},
    File{"imu0/data.csv", "#t,wx,wy,wz,ax,ay,az\n45000000,1,2,3,4,5,6\n95000000,1,2,3,4,5,6\n"},
    File{"gt/data.csv", "#t,px,py,pz,qw,qx,qy,qz\n40000000,1,2,3,1,0,0,0\n110000000,1,2,3,1,0,0,0\n"}};

inline void restore(const File& one) {
  const std::string name = one.first, pose = name.ends_with("sensor.yaml") ? kPose : "";
  file("mav0/" + name, pose + one.second);
}

inline bool make_asl_folder() {
  for (const File& one : kFiles) restore(one);
  std::vector<unsigned char> png;
  cv::imencode(".png", cv::Mat(36, 48, CV_8UC1, cv::Scalar(7)), png);
  file("mav0/cam0/data/a.png", {reinterpret_cast<const char*>(png.data()), png.size()});
  return true;
}

inline void asl_folder(std::string_view text) {
  static const bool made = make_asl_folder();
  if (!made || text.empty()) return;
  const File& changed = kFiles[static_cast<unsigned char>(text[0]) % kFiles.size()];
  file(std::string("mav0/") + changed.first, text.substr(1));
  read_or_reject([] {
    recordings::AslFolder reader(folder());
    while (reader.next()) continue;
  });
  restore(changed);
}

/// A decoded image has the requested size.
inline void image(std::string_view text) {
  const cv::Size asked{48, 36};
  read_or_reject([&] {
    const cv::Mat decoded = recordings::decode_image("image.png", text, asked);
    require(decoded.size() == asked && decoded.type() == CV_8UC1);
  });
}

inline std::filesystem::path root() { return folder() / "recording"; }

/// Records; returns the content of every listed file by its relative path.
inline std::map<std::string, std::string> contents() {
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
  std::map<std::string, std::string> all;
  sim::files::CsvReader rows(root() / "manifest.csv", {"#xxh3_128,bytes,path"});
  while (rows.next()) all[std::string(rows.text(2))] = sim::files::read_text(root() / rows.text(2));
  return all;
}

/// Only files that are parsed can be selected. Each is listed in the manifest.
inline void recording(std::string_view text) {
  using namespace recordings::recording_format;
  static std::map<std::string, std::string> files = contents();
  static const std::vector<std::string> parsed = [] {
    std::vector<std::string> all{kFrames};
    for (const char* sensor : {"cam0", "imu0", "plan0"})
      all.insert(all.end(), {sensor_file(sensor), sensor_rows(sensor)});
    for (const Table* table :
         {&kTrueCamera, &kTrueWaist, &kPlannedWaist, &kDesiredWaist, &kFeet, &kCorrectedSteps, &kSurfaces})
      all.push_back(table->file);
    all.push_back(kBody);
    for (const auto& [name, content] : files)
      if ((name.starts_with("mav0/rig_") && !name.ends_with(".png")) || name.starts_with("mav0/encoders0") ||
          name.starts_with("mav0/forces0"))
        all.push_back(name);
    return all;
  }();
  if (text.empty()) return;
  const std::string& changed = parsed[static_cast<unsigned char>(text[0]) % parsed.size()];
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

/// The sensor.yaml of cameras, IMUs, plans and mountings, written by this and by other programs.
inline void sensor_yaml(std::string_view input) {
  const std::string text(input);
  recordings::RecordingSetup setup;
  const std::string camera = read_or_reject([&] {
    recordings::read_camera_yaml({"sensor.yaml", text}, setup);
  });
  const std::string imu = read_or_reject([&] { recordings::read_imu_yaml({"sensor.yaml", text}); });
  // Both messages are the parser's, which the other readers share.
  if (!camera.empty() && camera == imu) return;
  read_or_reject([&] { recordings::read_pose({"sensor.yaml", text}, "T_BS", "T_SB"); });
  read_or_reject([&] { recordings::read_pose({"sensor.yaml", text}, "T_WC_start"); });
}

/// TUM with and without covariance, EuRoC, KITTI.
inline void trajectory(std::string_view text) {
  const auto poses = file("trajectory.txt", text);
  read_or_reject([&] { sim::files::read_trajectory(poses); });
  read_or_reject([&] { sim::files::read_tum(poses); });
}

}  // namespace fuzz
GAITSLAM_FUZZ_ENTRY
