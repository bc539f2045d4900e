// A short run for the tests of exports, with and without a rig, its expected contents in files that need no
// reader of this project, and commands of readers that are not from this project.
#pragma once

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <map>

#include "sim/export/export_context.h"
#include "sim/files/csv.h"
#include "sim/files/text.h"
#include "sim/sensor_errors/random.h"
#include "tests/sim/files/temporary_folder.h"
#include "tests/sim/recording/random_readings.h"

namespace sim::exports {

namespace fs = std::filesystem;
using slam::Stamp, testing::HasSubstr;
using tests::random_image, tests::random_pose, tests::random_vector;

/// The default camera at a fifth of its size.
inline slam::CameraIntrinsics head_camera() {
  return {64, 48, 39.4, 39.0, 31.4, 25.4, slam::OneParameterRadial{7.37e-6 * 25}};
}

/// The sensors of the rig.
enum Sensor { kEye, kColor, kDepth, kLidar, kImu };

/// Writes the input of the filter to files that need no reader of this project, images as bare bytes.
class Expected {
 public:
  explicit Expected(const fs::path& folder) : folder_(folder) { fs::create_directories(folder); }

  void add(const slam::Observation& input) {
    for (std::size_t i = 0; i < input.gyro.size(); ++i) {  // every 5 ms their mean, at their middle
      const slam::InertialSample& gyro = input.gyro[i];
      const double part = static_cast<double>((gyro.end - gyro.begin).count()) / 5e6;
      gyro_ += part * gyro.value, accelerometer_ += part * input.accelerometer[i].value;
      if (gyro.end.count() % 5'000'000 != 0) continue;
      add("imu.csv", gyro.end - Stamp(2'500'000), gyro_, accelerometer_);
      gyro_.setZero(), accelerometer_.setZero();
    }
    if (input.plan) add("plan.csv", input.t, input.plan->X_PC);
    if (input.image.empty()) return;
    add("images.csv", input.t);
    files::write_text(folder_ / fmt::format("{}.grey", recording::file_stamp(input.t)),
                      {reinterpret_cast<const char*>(input.image.data), input.image.total()});
  }
  /// A row of a time with vectors or poses.
  void add(const std::string& file, Stamp t, const auto&... values) const {
    line(file, (fmt::format("{}", recording::file_stamp(t)) + ... + ("," + files::csv_fields(values))));
  }
  void line(const std::string& file, const std::string& text) const {
    std::ofstream(folder_ / file, std::ios::app) << text << '\n';
  }

 private:
  fs::path folder_;
  Eigen::Vector3d gyro_ = Eigen::Vector3d::Zero(), accelerometer_ = Eigen::Vector3d::Zero();
};

/// A run of 12 frames with noise, and the expected content of its exports.
class Exported : public testing::Test {
 protected:
  explicit Exported(bool with_rig = false) {
    sensor_errors::Random random(1, "export test");
    recording::RecordingSetup setup;
    setup.calibration = {head_camera(), random_pose(random)};
    setup.joints = {"hip", "knee"};
    std::vector<slam::Observation> given = tests::observations(random, 12, {64, 48}, Stamp{0});
    if (with_rig) {
      tests::add_rig(given, random, {64, 48});
      setup.rig = rig_ = calibrated(tests::rig_of(random, {64, 48}));
    }
    X_GC_ = setup.calibration.X_CG.inverse();
    recording::RecordingWriter writer(run_.result / "recording", setup);
    Expected expected(expected_);
    sensor_errors::SensorErrors errors(run_.errors, run_.seed, setup.rig);
    for (const slam::Observation& ideal : given) {
      for (const slam::RigReading& reading : ideal.rig) readings_[reading.sensor].push_back(reading);
      writer.add(ideal);
      for (const slam::Observation& input : errors.process(ideal)) expected.add(input);
      const recording::TruePoses truth{ideal.t, random_pose(random), random_pose(random),
                                       random_pose(random)};
      const recording::TrueMotion motion{ideal.t, random_pose(random), random_vector(random)};
      writer.add(truth), writer.add(motion);
      add_body(writer, expected, ideal.t, random);
      expected.add("waist.csv", truth.t, truth.X_WB);
      X_WC_ = truth.X_WC;
      expected.add("truth.csv", truth.t, truth.X_WC), expected.add("motion.csv", motion.t, motion.X_WG);
    }
    writer.finish();
    expected.add("X_CG.csv", Stamp{0}, setup.calibration.X_CG);
    add_estimate(expected, random);
    const std::string map =
        "#timestamp [ns],id,x,y,z\n0,7,1.5,-2.25,0.5\n0,9,3,4,5\n99000000,7,1.25,-2.5,0.75\n";
    files::write_text(run_.result / "map_over_time.csv", map);
    files::write_text(expected_ / "map.csv", map.substr(map.find('\n') + 1));
  }

  // The gray eye 60 mm to the right of the head camera, a color camera without distortion.
  static std::vector<rig::RigSensor> calibrated(std::vector<rig::RigSensor> rig) {
    rig[kEye].name = "right_eye", rig[kImu].name = "chest", rig[kImu].rate_hz = 100;
    rig[kEye].X_CS = Eigen::Translation3d(0.06, 0, 0);
    rig[kEye].camera = head_camera();
    rig[kColor].camera = rig[kDepth].camera = {64, 48, 30, 30, 31.5, 23.5, slam::OneParameterRadial{0}};
    rig[kDepth].X_CS = rig[kColor].X_CS;
    return rig;
  }

  // Feet at the frame; two readings of joints and forces since the previous one. The links are at the last.
  static void add_body(recording::RecordingWriter& writer, const Expected& expected, Stamp t,
                       sensor_errors::Random& random) {
    recording::TrueFeet feet;
    feet.t = t;
    feet.left.truth = random_vector(random), feet.right.truth = random_vector(random);
    writer.add(feet);
    expected.add("left_foot.csv", t, on_ground(feet.left.truth));
    expected.add("right_foot.csv", t, on_ground(feet.right.truth));
    for (const Stamp before : {Stamp{7'000'000}, Stamp{2'000'000}}) {
      if (t < before) continue;
      recording::BodyReading reading{t - before, random_vector(random).head(2), {}, {}};
      for (recording::BodyReading::Wrench* wrench : {&reading.left, &reading.right})
        wrench->force = random_vector(random), wrench->torque = random_vector(random);
      writer.add(reading);
      const std::string joints =
          fmt::format("{},{},{}", recording::file_stamp(reading.t), reading.q[0], reading.q[1]);
      expected.line("joints.csv", joints);
      if (before == Stamp{2'000'000}) expected.line("links.csv", joints);
      expected.add("left_wrench.csv", reading.t, reading.left.force, reading.left.torque);
      expected.add("right_wrench.csv", reading.t, reading.right.force, reading.right.torque);
    }
  }
  static Eigen::Isometry3d on_ground(const Eigen::Vector3d& foot) {
    const double c = std::cos(foot.z()), s = std::sin(foot.z());
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.linear() << c, -s, 0, s, c, 0, 0, 0, 1;
    X.translation() << foot.x(), foot.y(), 0;
    return X;
  }

  // Two frames; the orientation is equally uncertain about each axis, the position is not.
  void add_estimate(const Expected& expected, sensor_errors::Random& random) const {
    std::ofstream out(run_.result / "estimate_cov.txt");
    const files::Matrix6d P = Eigen::Vector<double, 6>(2e-6, 2e-6, 2e-6, 1e-6, 4e-6, 9e-6).asDiagonal();
    for (const Stamp t : {Stamp{0}, Stamp{33'000'000}}) {
      const Eigen::Isometry3d X = random_pose(random);
      out << files::tum_row(t, X, P);
      expected.add("slam.csv", t, X);
    }
  }

  fs::path made(const std::string& format) const {
    const fs::path out = folder_ / format;
    export_run(run_, format, out, files::Existing::replace);
    return out;
  }

  /// Runs a command. Returns what it printed, with its exit code if that is not 0.
  std::string run_command(const std::string& command) const {
    const fs::path output = folder_ / "output";
    const int status = std::system((command + " > '" + output.string() + "' 2>&1").c_str());
    return files::read_text(output) + (status ? "exit " + std::to_string(WEXITSTATUS(status)) : "");
  }

  /// The messages of a bag as JSON, read by npm's readers, or their complaint.
  std::string messages(const fs::path& mcap) const {
    return run_command(fmt::format("node '{0}/tests/interop/dump_mcap.cjs' '{0}/build/interop' '{1}'",
                                   GAITSLAM_SOURCE_DIR, mcap.string()));
  }

  /// Makes an export and compares it with the expected contents by numpy. Returns what differs.
  std::string difference(const std::string& format) const {
    const fs::path out = made(format), bag = out / (format == "mcap" ? "" : "bag") / "run.mcap";
    if (fs::exists(bag)) files::write_text(expected_ / "messages.json", messages(bag));
    return run_command(fmt::format("/usr/bin/python3 '{}/tests/interop/read_exports.py' {} '{}' '{}'",
                                   GAITSLAM_SOURCE_DIR, format, out.string(), expected_.string()));
  }

  /// Empty if the reader of MCAP files from npm is installed, otherwise the reason.
  static std::string reader_missing() {
    const bool installed =
        fs::exists(fs::path(GAITSLAM_SOURCE_DIR) / "build/interop/node_modules/.installed");
    return installed || std::getenv("CI") != nullptr ? ""
                                                     : "tools/test.sh could not install the reader from npm";
  }

  static std::shared_ptr<const RobotDescription> robot() {
    const auto poses = [](const Eigen::VectorXd& q) {
      return std::vector{Eigen::Isometry3d(Eigen::Translation3d(q[0], 0, 0)),
                         Eigen::Isometry3d(Eigen::Translation3d(0, q[1], 0))};
    };
    return std::make_shared<RobotDescription>(RobotDescription{"<robot/>", {"thigh", "shin"}, poses});
  }

  files::TemporaryFolder folder_;
  ExportedRun run_{folder_ / "result", "a walk", 7, {}, true, false, robot()};
  fs::path expected_ = folder_ / "expected";
  Eigen::Isometry3d X_GC_, X_WC_;  // X_WC_: of the last frame
  std::vector<rig::RigSensor> rig_;
  std::map<int, std::vector<slam::RigReading>> readings_;  // of the rig, by sensor
};

}  // namespace sim::exports
