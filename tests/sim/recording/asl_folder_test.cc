#include "sim/recording/asl_folder.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <numbers>
#include <opencv2/imgcodecs.hpp>

#include "tests/sim/files/temporary_folder.h"
#include "tests/sim/recording/random_readings.h"

namespace sim::recording {
namespace {

namespace fs = std::filesystem;
using slam::Stamp;
using testing::HasSubstr;

// As EuRoC's own files: CR LF, no line feed after the last line, stamps of the year 2014.
class RecordedElsewhere : public testing::Test {
 protected:
  RecordedElsewhere() {
    fs::copy(GAITSLAM_SOURCE_DIR "/tests/sim/recording/euroc", folder_.path(), fs::copy_options::recursive);
    image("1403636579763555584.png", 64);
    image("second.png", 64);
  }

  void write(const std::string& name, const std::string& text) const {
    fs::create_directories((folder_ / "mav0" / name).parent_path());
    files::write_text(folder_ / "mav0" / name, text);
  }
  void image(const std::string& name, int width) const {
    fs::create_directories(folder_ / "mav0/cam0/data");
    cv::imwrite((folder_ / "mav0/cam0/data" / name).string(), cv::Mat(48, width, CV_8UC1, cv::Scalar(77)));
  }
  void edit(const std::string& name, const std::string& from, const std::string& to) const {
    std::string text = files::read_text(folder_ / "mav0" / name);
    ASSERT_NE(text.find(from), text.npos) << from;
    write(name, text.replace(text.find(from), from.size(), to));
  }
  /// Returns the error of reading the whole folder.
  std::string complaint() const {
    return files::error_of([&] {
      AslFolder reader(folder_.path());
      while (reader.next()) continue;
      read_asl_truth(folder_.path(), reader.sensors(), {Stamp{0}, Stamp{49999872}});
    });
  }

  files::TemporaryFolder folder_;
};

TEST_F(RecordedElsewhere, SensorsAreReadAsEurocStatesThem) {
  const AslFolder reader(folder_.path());
  const AslSensors& sensors = reader.sensors();
  const slam::CameraIntrinsics& camera = sensors.setup.calibration.camera;
  EXPECT_EQ(camera.width_px, 64);
  EXPECT_EQ(camera.u0_px, 36.7215);
  EXPECT_EQ(std::get<slam::RadialTangential>(camera.lens).p2, 1.76187114e-05);
  EXPECT_NEAR(sensors.X_BC.translation().y(), -0.064676986768, 1e-12);
  EXPECT_LT((sensors.setup.calibration.X_CG * sensors.X_BC).matrix().diagonal().norm(), 2 + 1e-9);
  EXPECT_EQ(sensors.noise.gyro_density, 1.6968e-04);
  EXPECT_FALSE(sensors.has_plan);
  // Then the accelerometer's first readings define the vertical.
  const Eigen::Vector3d up =
      sensors.setup.X_WC_start.linear() * sensors.setup.calibration.X_CG.linear() * Eigen::Vector3d::UnitX();
  EXPECT_LT((up - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
}

TEST_F(RecordedElsewhere, APlanMayHaveColumnsOfAnotherProgramsOwnAndThenHasNoLegOdometry) {
  write("plan0/sensor.yaml", plan_yaml({}));
  const std::string pose = ",1,2,3,1,0,0,0,1,0,0,0,1", vectors = ",0,0,0,0,0,0,left,0,0,0";
  write("plan0/data.csv", recording_format::kPlanHeader + "\n33000000" + pose + vectors + "\n");
  EXPECT_THAT(complaint(), HasSubstr("plan0/data.csv: none of its stamps is that of an image"));
  write("plan0/data.csv",
        recording_format::kPlanHeader + ",battery [V]\n1403636579763555584" + pose + vectors + ",48\n");
  AslFolder own_column(folder_.path());
  const auto first = own_column.next();
  ASSERT_TRUE(first && first->plan);
  EXPECT_FALSE(first->plan->legs);
  write("plan0/data.csv",
        recording_format::kPlanAndLegsHeader + "\n1403636579763555584" + pose + vectors + pose + ",7,8,9\n");
  AslFolder with_legs(folder_.path());
  const auto again = with_legs.next();
  ASSERT_TRUE(again && again->plan && again->plan->legs);
  EXPECT_EQ(again->plan->legs->p_CS, Eigen::Vector3d(7, 8, 9));
}

TEST_F(RecordedElsewhere, AReadingStandsForTheTimeUntilHalfwayToItsNeighborsAndIsSplitAtAFrame) {
  AslFolder reader(folder_.path());
  const auto first = reader.next(), second = reader.next();
  ASSERT_TRUE(first && second);
  EXPECT_FALSE(reader.next());
  EXPECT_EQ(first->t, Stamp{0});
  EXPECT_EQ(second->t, Stamp{49999872});
  ASSERT_EQ(first->gyro.size(), 2u);
  EXPECT_EQ(first->gyro[0].begin, Stamp{-10000192});
  EXPECT_EQ(first->gyro[0].end, Stamp{-192});
  EXPECT_EQ(first->gyro[1].end, Stamp{0});
  ASSERT_EQ(second->gyro.size(), 3u);
  const std::array<double, 3> ends{14999808, 39999808, 49999872}, values{2, 3, 4};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(second->gyro[i].begin, i ? second->gyro[i - 1].end : Stamp{0});
    EXPECT_EQ(static_cast<double>(second->gyro[i].end.count()), ends[i]);
    EXPECT_EQ(second->gyro[i].value.x(), values[i]);
  }
  EXPECT_EQ(second->accelerometer.size(), 3u);
  EXPECT_EQ(second->image.at<unsigned char>(10, 10), 77);
}

TEST_F(RecordedElsewhere, TruthIsInterpolatedAtTheFramesAndAlignedWithTheStart) {
  const AslFolder reader(folder_.path());
  const auto truth = read_asl_truth(folder_.path(), reader.sensors(), {Stamp{0}, Stamp{49999872}}).camera;
  ASSERT_EQ(truth.size(), 2u);
  EXPECT_TRUE(truth[0].X.isApprox(reader.sensors().setup.X_WC_start, 1e-12));
  EXPECT_EQ(truth[1].t, Stamp{49999872});
  // from (2, 0, 0) halfway between the first two to (3, 4, 0), four fifths between the others
  EXPECT_NEAR((truth[1].X.translation() - truth[0].X.translation()).norm(), std::hypot(1, 4), 1e-4);
  fs::remove_all(folder_ / "mav0/state_groundtruth_estimate0");
  EXPECT_TRUE(read_asl_truth(folder_.path(), reader.sensors(), {Stamp{0}}).camera.empty());
  EXPECT_THAT(AslFolder(folder_.path()).sensors().remarks,
              testing::Contains(testing::HasSubstr(": no truth: ")));
}

TEST_F(RecordedElsewhere, TruthOfPositionsIsThatOfItsPointInItsOwnWorld) {
  fs::remove_all(folder_ / "mav0/state_groundtruth_estimate0");
  const AslFolder reader(folder_.path());
  for (const char* header :
       {"#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m]\n", "t,x,y,z\n", "x,y,z\n", ""}) {
    write("leica0/data.csv", header + std::string("1403636579763555584,2,0,0\n1403636579813555456,3,4,0\n"));
    write("leica0/sensor.yaml", "T_BS: [1, 0, 0, 0.1, 0, 1, 0, 0.2, 0, 0, 1, 0.3, 0, 0, 0, 1]\n");
    const Truth truth = read_asl_truth(folder_.path(), reader.sensors(), {Stamp{0}, Stamp{49999872}});
    ASSERT_EQ(truth.camera.size(), 2u) << header;
    EXPECT_EQ(truth.camera[1].X.translation(), Eigen::Vector3d(3, 4, 0));
    EXPECT_TRUE(
        (reader.sensors().X_BC * truth.positions_of.value()).isApprox(Eigen::Vector3d(.1, .2, .3), 1e-12));
  }
}

TEST_F(RecordedElsewhere, WhatIsWrongInAFileIsSaidWithItsPlace) {
  for (const auto& [name, from, to, words] : tests::bad_files("bad_folders.txt")) {
    const fs::path file = folder_ / "mav0" / name, kept = folder_ / "kept";
    fs::copy_file(file, kept, fs::copy_options::overwrite_existing);
    edit(name, from, to);
    EXPECT_THAT(complaint(), HasSubstr(words)) << to;
    fs::copy_file(kept, file, fs::copy_options::overwrite_existing);
  }
  EXPECT_EQ(complaint(), "");
  for (const char* name : {"cam0/sensor.yaml", "cam0/data.csv", "imu0/sensor.yaml", "imu0/data.csv"}) {
    const fs::path file = folder_ / "mav0" / name, kept = folder_ / "kept";
    fs::rename(file, kept);
    EXPECT_THAT(complaint(), HasSubstr(std::string(name) + ": cannot be read: No such file or directory"));
    fs::rename(kept, file);
  }
}

TEST_F(RecordedElsewhere, AnImuOrATruthOfAnotherClockIsNamedBeforeTheFirstFrame) {
  const auto reading = [&] { AslFolder reader(folder_.path()); };
  write("imu0/data.csv", "#timestamp [ns],x,y,z\n11900000000,1,0,0\n11920000000,2,0,0\n");
  EXPECT_THAT(
      files::error_of(reading),
      HasSubstr("imu0/data.csv: none of its readings is between the images: they are from 11.900 s to "
                "11.920 s, the images from 1403636579.764 s to 1403636579.814 s"));
  write("imu0/data.csv", "#timestamp [ns],x,y,z\n1403636579758555392,1,0,0\n1403636579778555392,2,0,0\n");
  EXPECT_EQ(complaint(), "");
  const std::string header = "#timestamp,x,y,z,w,x,y,z\n";
  write("state_groundtruth_estimate0/data.csv", header + "2403636579753555584,1,0,0,1,0,0,0\n");
  EXPECT_THAT(complaint(),
              HasSubstr("data.csv: none of its poses is near the time of an image: they are from"));
  write("state_groundtruth_estimate0/data.csv",
        header + "1403636579703555584,1,0,0,1,0,0,0\n1403636579903555584,1,0,0,1,0,0,0\n");
  EXPECT_THAT(complaint(), HasSubstr("data.csv: its poses are more than 0.1 s apart around each image"));
}

TEST_F(RecordedElsewhere, ColumnsAndStampsAreReadByTheirNamesAndUnits) {
  const auto first = [&](const std::string& header, const std::string& values,
                         const std::string& stamp = "1403636579{}8555392") {
    const auto row = [&](int s_100) { return "\n" + fmt::format(fmt::runtime(stamp), s_100) + "," + values; };
    write("imu0/data.csv", header + row(75) + row(77) + "\n");
    return AslFolder(folder_.path()).next().value();
  };
  for (const auto& [stamp, header, values] : std::vector<std::array<std::string, 3>>{
           {"1403636579{}8555392", "timestamp,alpha_x,alpha_y,alpha_z,omega_x,omega_y,omega_z",
            "1,2,3,0.1,0.2,0.3"},
           {"1403636579.{}8555392", "time,gyro_x_deg_s,gyro_y_deg_s,gyro_z_deg_s,accx,accy,accz",
            "5.729577951308232,11.459155902616464,17.188733853924695,1,2,3"},
           {"1.403636579{}8555392e+18",
            "#t,angular_velocity.x (deg/s),angular_velocity.y (deg/s),angular_velocity.z (deg/s),ax [g],ay "
            "[g],az [g]",
            "5.729577951308232,11.459155902616464,17.188733853924695,0.10197162129779283,0.20394324259558566,"
            "0.3059148638933785"}}) {
    const slam::Observation o = first(header, values, stamp);
    EXPECT_EQ(o.gyro.at(0).begin, Stamp{-15000192}) << stamp;
    EXPECT_LT((o.gyro.at(0).value - Eigen::Vector3d(0.1, 0.2, 0.3)).norm(), 1e-12) << header;
    EXPECT_LT((o.accelerometer.at(0).value - Eigen::Vector3d(1, 2, 3)).norm(), 1e-12) << header;
  }
  EXPECT_TRUE(first("#timestamp [ns],wx,wy,wz,mag_x,mag_y,mag_z", "1,2,3,4,5,6").accelerometer.empty())
      << "a magnetometer is none";
}

TEST_F(RecordedElsewhere, StampsInTwoColumnsAreReadByTheirNames) {
  write("cam0/data.csv",
        "sec,nanosec,filename\n1403636579,763555584,second.png\n1403636579,813555456,second.png\n");
  write("imu0/data.csv",
        "header.stamp.secs,header.stamp.nsecs,angular_velocity.x,angular_velocity.y,angular_velocity.z\n"
        "1403636579,758555392,1,0,0\n1403636579,778555392,2,0,0\n");
  AslFolder reader(folder_.path());
  EXPECT_EQ(reader.times().back(), Stamp{49999872});
  EXPECT_EQ(reader.next().value().gyro.at(0).begin, Stamp{-15000192});
  edit("imu0/data.csv", "header.stamp.secs,header.stamp.nsecs", "a,b");
  EXPECT_THAT(complaint(),
              HasSubstr("imu0/data.csv:3:1: the stamp is not after the one before; is its rest"));
}

TEST_F(RecordedElsewhere, AGyroOfAnotherClockOrUnitThanTheTruthIsNamedBeforeTheFirstFrame) {
  const std::string camera = "#timestamp [ns],filename\n";
  write("cam0/data.csv", camera + "10000000000,second.png\n10050000000,second.png\n");
  const auto rotating = [&](double late_s, double factor) {
    std::string imu = "#timestamp [ns],w_x,w_y,w_z\n", truth = "#timestamp [ns],x,y,z,q_w,q_x,q_y,q_z\n";
    double angle = 0;
    for (int i = 0; i < 400; ++i) {  // at 50 Hz
      const auto rate = [](double t) { return 0.3 * std::sin(t * t); };
      const double t = 8 + 0.02 * i;
      imu += fmt::format("{:.0f},{},0,0\n", 1e9 * (t + late_s), factor * rate(t));
      truth += fmt::format("{:.0f},0,0,0,{},{},0,0\n", 1e9 * t, std::cos(angle / 2), std::sin(angle / 2));
      angle += 0.02 * rate(t + 0.01);
    }
    write("imu0/data.csv", imu);
    write("state_groundtruth_estimate0/data.csv", truth);
    return complaint();
  };
  EXPECT_EQ(rotating(0, 1), "");
  EXPECT_EQ(rotating(0.05, 1.5), "");
  EXPECT_THAT(rotating(0.5, 1), HasSubstr("data.csv: its stamps are 0.50 s earlier than those of "));
  EXPECT_THAT(rotating(-1.5, 1), HasSubstr("data.csv: its stamps are 1.50 s later than those of "));
  EXPECT_THAT(rotating(0, 57.3), HasSubstr("imu0/data.csv: its speeds of rotation are 5"));
  edit("cam0/sensor.yaml", "rate_hz: 20", "rate_hz: 20\ntimeshift_cam_imu: 0.5");
  EXPECT_EQ(rotating(0.5, 1), "");
}

TEST_F(RecordedElsewhere, TheKeysAndLayoutsOfKalibrAreRead) {
  const std::string rows =
      "- [0.0148655429818, -0.999880929698, 0.00414029679422, -0.0216401454975]\n"
      "- [0.999557249008, 0.0149672133247, 0.025715529948, -0.064676986768]\n"
      "- [-0.0257744366974, 0.00375618835797, 0.999660727178, 0.00981073058949]\n"
      "- [0.0, 0.0, 0.0, 1.0]\n";
  const Eigen::Isometry3d X_BC = AslFolder(folder_.path()).sensors().X_BC;
  const std::string camera = files::read_text(folder_ / "mav0/cam0/sensor.yaml");
  const std::string rest = camera.substr(camera.find("rate_hz"));
  write("cam0/sensor.yaml",
        "\xef\xbb\xbf%YAML:1.0\n" + ("T_BS:\n" + rows) + rest + "timeshift_cam_imu: 0.01\nexposure_ms: 3\n");
  {
    const AslFolder reader(folder_.path());
    EXPECT_TRUE(reader.sensors().X_BC.isApprox(X_BC, 1e-12));
    EXPECT_EQ(reader.sensors().imu_ahead, Stamp{10'000'000});
    EXPECT_THAT(reader.sensors().remarks,
                testing::Contains(HasSubstr("cam0/sensor.yaml: keys that are not read: exposure_ms")));
  }
  AslFolder shifted(folder_.path());
  EXPECT_EQ(shifted.next()->gyro.at(0).begin, Stamp{-20000192}) << "10 ms earlier";

  fs::remove(folder_ / "mav0/cam0/sensor.yaml");
  fs::remove(folder_ / "mav0/imu0/sensor.yaml");
  write("../dso/camchain.yaml",
        "cam0:\n  T_imu_cam:\n" + std::string("  ") + tests::replaced(rows, "\n- ", "\n  - ") +
            "  camera_model: pinhole\n  distortion_coeffs: [-0.28, 0.07, 0.0002, 1.8e-05]\n"
            "  distortion_model: radtan\n  intrinsics: [45.8654, 45.7296, 36.7215, 24.8375]\n"
            "  resolution: [64, 48]\n  rostopic: /cam0/image_raw\n");
  write("../dso/imu_config.yaml", "gyroscope_noise_density: 1.7e-04\nrostopic: /imu0\nupdate_rate: 50.0\n");
  const AslFolder chain(folder_.path());
  EXPECT_TRUE(chain.sensors().X_BC.isApprox(X_BC, 1e-12));
  EXPECT_EQ(chain.sensors().noise.gyro_density, 1.7e-04);
}

using Rate = std::function<Eigen::Vector3d(double)>;

/// Compares 40 s of a gyro at 200 Hz with late stamps and a truth at 100 Hz.
std::optional<ClockOffset> offset_of(const Rate& rate, double late_s, double noise_rad_s) {
  std::vector<TimedRotation> gyro;
  std::vector<files::TumRow> truth;
  sensor_errors::Random random(1, "gyro");
  const auto stamp = [](double t) { return slam::Stamp(std::llround(1e9 * t)); };
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  for (std::uint64_t i = 0; i < 8000; ++i) {
    const double t = 0.005 * static_cast<double>(i);
    const Eigen::Vector3d w = rate(t);
    gyro.push_back({stamp(t + late_s), w + noise_rad_s * tests::random_vector(random)});
    files::TumRow row;
    row.t = stamp(t);
    row.X.linear() = q.toRotationMatrix();
    if (i % 2 == 0) truth.push_back(row);
    q = (q * Eigen::Quaterniond(Eigen::AngleAxisd(0.005 * w.norm(), w.stableNormalized()))).normalized();
  }
  return clock_offset(gyro, truth);
}

constexpr double kStep = 2 * std::numbers::pi / 0.8;  // rad/s: steps of 0.8 s

Eigen::Vector3d walk(double t) {
  return {0.1 * std::sin(kStep * t), 0.05 * std::cos(2 * kStep * t), 0.2 * std::sin(0.3 * t)};
}
Eigen::Vector3d even_walk(double t) { return {0.1 * std::sin(kStep * t), 0.05 * std::cos(kStep * t), 0.3}; }

TEST(ClockOffset, IsMeasuredBySpeedsOfRotation) {
  for (const double late_s : {-2.0, -0.3, 0.06, 0.3, 0.8, 1.5, 2.0, 7.0})
    for (const double noise : {0.0, 0.05}) {
      const auto offset = offset_of(walk, late_s, noise);
      ASSERT_TRUE(offset) << late_s << " " << noise;
      EXPECT_NEAR(offset->late_s, late_s, 0.021);  // the step of the grid
      EXPECT_GT(offset->correlation, offset->as_stamped);
      EXPECT_NEAR(offset->gain, 1, 0.1);
    }
}

TEST(ClockOffset, IsAbsentOnOneClockAndWithoutEvidence) {
  for (const double noise : {0.0, 0.05, 1.0}) {
    for (const Rate& rate : {Rate(walk), Rate(even_walk)})
      for (const double late_s : {0.0, 0.004}) {
        const auto offset = offset_of(rate, late_s, noise);
        EXPECT_LE(offset ? std::abs(offset->late_s) : 0, 0.02) << noise << " " << late_s;
      }
    EXPECT_FALSE(offset_of([](double) -> Eigen::Vector3d { return Eigen::Vector3d::Zero(); }, 1, noise));
    EXPECT_FALSE(offset_of([](double) -> Eigen::Vector3d { return {0, 0, 0.3}; }, 1, noise));
  }
  EXPECT_FALSE(offset_of(walk, 1, 5.0)) << "noise hides the motion";
  EXPECT_FALSE(offset_of(walk, 100, 0)) << "the spans are disjoint";
}

}  // namespace
}  // namespace sim::recording
