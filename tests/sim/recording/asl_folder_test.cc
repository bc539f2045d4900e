#include "sim/recording/asl_folder.h"

#include <fmt/ranges.h>

#include "tests/sim/recording/random_readings.h"

namespace sim::recording {
namespace {

using slam::Stamp, testing::Contains, testing::ContainsRegex, testing::HasSubstr, testing::Not;

// A folder like EuRoC's own: CR LF, no line feed after the last line, stamps of the year 2014.
class RecordedElsewhere : public testing::Test {
 protected:
  RecordedElsewhere() {
    const std::string all = files::read_text(GAITSLAM_SOURCE_DIR "/tests/sim/recording/euroc.txt");
    for (const std::string name : {"cam0/data.csv", "cam0/sensor.yaml", "imu0/data.csv", "imu0/sensor.yaml",
                                   "state_groundtruth_estimate0/data.csv"}) {
      std::string text = *files::titled_lines(all, name);
      if (name == "cam0/data.csv" || name == "imu0/data.csv")
        text = tests::replaced(text.substr(0, text.size() - 1), "\n", "\r\n");
      write(name, text);
    }
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
    });
  }
  /// Returns the error of opening the folder, before the first frame.
  std::string rejection() const {
    return files::error_of([&] { AslFolder reader(folder_.path()); });
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
  EXPECT_FALSE(sensors.has_motion);
  // Then the accelerometer's first readings define the vertical.
  const Eigen::Vector3d up =
      sensors.setup.X_WC_start.linear() * sensors.setup.calibration.X_CG.linear() * Eigen::Vector3d::UnitX();
  EXPECT_LT((up - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
}

TEST_F(RecordedElsewhere, APlanMayHaveExtraColumnsOfAnotherProgram) {
  write("plan0/sensor.yaml", motion_source_yaml(motion_sources()[0], {}));
  const std::string pose = ",1,2,3,1,0,0,0,1,0,0,0,1", vectors = ",0,0,0,0,0,0,left,0,0,0";
  write("plan0/data.csv", recording_format::kPlanHeader + "\n33000000" + pose + vectors + "\n");
  EXPECT_THAT(complaint(), HasSubstr("plan0/data.csv: none of its stamps matches an image"));
  write("plan0/data.csv",
        recording_format::kPlanHeader + ",battery [V]\n1403636579763555584" + pose + vectors + ",48\n");
  AslFolder own_column(folder_.path());
  const auto first = own_column.next();
  EXPECT_TRUE(first && first->plan && !first->legs);
  fs::remove(folder_ / "mav0/plan0/sensor.yaml");  // then the accelerometer defines the start
  EXPECT_EQ(complaint(), "");
}

TEST_F(RecordedElsewhere, LegOdometryDefinesTheStartIfThereIsNoPlan) {
  const std::string pose = ",1,2,3,0,-1,0,1,0,0,0,0,1", zeros = ",0,0,0,0,0,0,0,0,0,0,0,0,0,0,0";
  write("legs0/data.csv", recording_format::kLegHeader + "\n1403636579763555584" + pose + zeros + "\n");
  const AslFolder reader(folder_.path());
  const Eigen::Isometry3d start = reader.sensors().setup.X_WC_start;
  EXPECT_EQ(start.translation(), Eigen::Vector3d(1, 2, 3)) << "heights are taken from legs0";
  EXPECT_EQ(start.linear().col(0), Eigen::Vector3d::UnitY());
  EXPECT_TRUE(reader.truth().camera[0].X.isApprox(start, 1e-12));
}

TEST_F(RecordedElsewhere, AReadingCoversTheTimeHalfwayToItsNeighborsAndIsSplitAtAFrame) {
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
    EXPECT_EQ(double(second->gyro[i].end.count()), ends[i]);
    EXPECT_EQ(second->gyro[i].value.x(), values[i]);
  }
  EXPECT_EQ(second->accelerometer.size(), 3u);
  EXPECT_EQ(second->image.at<unsigned char>(10, 10), 77);
}

TEST_F(RecordedElsewhere, TruthIsInterpolatedAtTheFramesAndAlignedWithTheStart) {
  const AslFolder reader(folder_.path());
  const auto& truth = reader.truth().camera;
  ASSERT_EQ(truth.size(), 2u);
  EXPECT_TRUE(truth[0].X.isApprox(reader.sensors().setup.X_WC_start, 1e-12));
  EXPECT_EQ(truth[1].t, Stamp{49999872});
  // from (2, 0, 0) halfway between the first two to (3, 4, 0), four fifths between the others
  EXPECT_NEAR((truth[1].X.translation() - truth[0].X.translation()).norm(), std::hypot(1, 4), 1e-4);
  const std::string pose = ",1,0,0,1,0,0,0\n";  // stamped 0.044 ms after the first image, by rounding
  write("state_groundtruth_estimate0/data.csv",
        "t[ns],x,y,z,qw,qx,qy,qz\n1403636579763600000" + pose + "1403636579813555456" + pose);
  EXPECT_EQ(AslFolder(folder_.path()).truth().camera.at(0).t, Stamp{0});
  fs::remove_all(folder_ / "mav0/state_groundtruth_estimate0");
  const AslFolder without(folder_.path());
  EXPECT_TRUE(without.truth().camera.empty());
  EXPECT_THAT(without.sensors().remarks, Contains(HasSubstr(": no truth: ")));
}

TEST_F(RecordedElsewhere, APositionOnlyTruthRefersToItsOwnPointAndWorld) {
  fs::remove_all(folder_ / "mav0/state_groundtruth_estimate0");
  for (const char* header :
       {"#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m]\n", "t[ns],x,y,z\n"}) {
    write("leica0/data.csv", header + std::string("1403636579763555584,2,0,0\n1403636579813555456,3,4,0\n"));
    write("leica0/sensor.yaml", "T_BS: [1, 0, 0, 0.1, 0, 1, 0, 0.2, 0, 0, 1, 0.3, 0, 0, 0, 1]\n");
    const AslFolder reader(folder_.path());
    const Truth& truth = reader.truth();
    ASSERT_EQ(truth.camera.size(), 2u) << header;
    EXPECT_EQ(truth.camera[1].X.translation(), Eigen::Vector3d(3, 4, 0));
    EXPECT_TRUE(
        (reader.sensors().X_BC * truth.positions_of.value()).isApprox(Eigen::Vector3d(.1, .2, .3), 1e-12));
  }
}

TEST_F(RecordedElsewhere, ErrorsInAFileAreReportedWithTheirPlace) {
  for (const auto& [name, from, to, words] : tests::bad_files("folders")) {
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

TEST_F(RecordedElsewhere, AnImuOrTruthOnAnotherClockIsReportedBeforeTheFirstFrame) {
  write("imu0/data.csv", "#timestamp [ns],wx,wy,wz\n11900000000,1,0,0\n11920000000,2,0,0\n");
  EXPECT_THAT(rejection(),
              HasSubstr("imu0/data.csv: none of its readings is between the images: they are from 11.900 s "
                        "to 11.920 s, the images from 1403636579.764 s to 1403636579.814 s"));
  write("imu0/data.csv", "#timestamp [ns],wx,wy,wz\n1403636579758555392,1,0,0\n1403636579778555392,2,0,0\n");
  EXPECT_EQ(complaint(), "");
  const std::string header = "t[ns],x,y,z,qw,qx,qy,qz\n";
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
           {"1403636579{}8555392", "timestamp[ns],a_x,a_y,a_z,omega_x,omega_y,omega_z", "1,2,3,0.1,0.2,0.3"},
           {"1403636579.{}8555392",
            "time[s],gyro_x[deg/s],gyro_y[deg/s],gyro_z[deg/s],acc_x[m/s^2],acc_y[m/s^2],acc_z[m/s^2]",
            "5.729577951308232,11.459155902616464,17.188733853924695,1,2,3"},
           {"1.403636579{}8555392e+18",
            "#timestamp,w_RS_S_x [deg s^-1],w_RS_S_y [deg s^-1],w_RS_S_z [deg s^-1],ax [g],ay [g],az [g]",
            "5.729577951308232,11.459155902616464,17.188733853924695,0.10197162129779283,0.20394324259558566,"
            "0.3059148638933785"}}) {
    const slam::Observation o = first(header, values, stamp);
    EXPECT_EQ(o.gyro.at(0).begin, Stamp{-15000192}) << stamp;
    EXPECT_LT((o.gyro.at(0).value - Eigen::Vector3d(0.1, 0.2, 0.3)).norm(), 1e-12) << header;
    EXPECT_LT((o.accelerometer.at(0).value - Eigen::Vector3d(1, 2, 3)).norm(), 1e-12) << header;
  }
  EXPECT_TRUE(first("#timestamp [ns],wx,wy,wz,mag_x,mag_y,mag_z", "1,2,3,4,5,6").accelerometer.empty())
      << "a magnetometer measures no acceleration";
  const std::string kept = files::read_text(folder_ / "mav0/imu0/data.csv");
  std::string decimal_commas = tests::replaced(kept, ",", ";");
  decimal_commas = tests::replaced(decimal_commas, "1;2;3", "0,5;2;3");
  write("imu0/data.csv", decimal_commas);
  EXPECT_EQ(AslFolder(folder_.path()).next().value().gyro.at(0).value, Eigen::Vector3d(0.5, 2, 3));
}

TEST_F(RecordedElsewhere, StampsInTwoColumnsAreReadByTheirNames) {
  write("cam0/data.csv",
        "sec;nanosec;filename\n1403636579;763555584;second.png\n1403636579;813555456;second.png\n");
  write("imu0/data.csv",
        "header.stamp.secs,header.stamp.nsecs,angular_velocity.x,angular_velocity.y,angular_velocity.z\n"
        "1403636579,758555392,1,0,0\n1403636579,778555392,2,0,0\n");
  AslFolder reader(folder_.path());
  EXPECT_EQ(reader.times().back(), Stamp{49999872});
  EXPECT_EQ(reader.next().value().gyro.at(0).begin, Stamp{-15000192});
  edit("imu0/data.csv", "header.stamp.secs,header.stamp.nsecs", "a,b");
  EXPECT_THAT(complaint(),
              HasSubstr("imu0/data.csv:2: no column contains the stamp; the first row has 5 columns: "));
}

TEST_F(RecordedElsewhere, AGyroWhoseClockUnitOrAxesDifferFromTheTruthIsReportedBeforeTheFirstFrame) {
  const std::string camera = "#timestamp [ns],filename\n";
  write("cam0/data.csv", camera + "10000000000,second.png\n10050000000,second.png\n");
  std::vector<std::string> remarks;
  const auto rotating = [&](double late_s, double factor, int from = 0) {
    std::string imu = "#timestamp [ns],w_x,w_y,w_z\n", truth = "#timestamp [ns],x,y,z,q_w,q_x,q_y,q_z\n";
    double angle = 0;
    for (int i = 0; i < 400; ++i) {  // at 50 Hz
      const auto rate = [](double t) { return 0.3 * std::sin(t * t); };
      const double t = 8 + 0.02 * i;
      imu += fmt::format("{:.0f},{},0,0\n", 1e9 * (t + (i < from ? 0 : late_s)), factor * rate(t));
      truth += fmt::format("{:.0f},0,0,0,{},{},0,0\n", 1e9 * t, std::cos(angle / 2), std::sin(angle / 2));
      angle += 0.02 * rate(t + 0.01);
    }
    write("imu0/data.csv", imu);
    write("state_groundtruth_estimate0/data.csv", truth);
    return files::error_of([&] { remarks = AslFolder(folder_.path()).sensors().remarks; });
  };
  const auto of_truth = Contains(HasSubstr("the truth is"));
  EXPECT_EQ(rotating(0, 1), "");
  EXPECT_THAT(remarks, Not(of_truth));
  EXPECT_EQ(rotating(0.05, 1.5), "");
  EXPECT_THAT(remarks, Contains(HasSubstr("data.csv: the truth is 0.05 s earlier than ")));
  EXPECT_THAT(remarks, Contains(HasSubstr("state timeshift_cam_imu: 0.0")));
  EXPECT_EQ(rotating(-0.03, 1), "");
  EXPECT_THAT(remarks, Contains(HasSubstr("data.csv: the truth is 0.03 s later than ")));
  EXPECT_EQ(rotating(0, 1e-9), "");
  EXPECT_THAT(remarks, Contains(HasSubstr("clock of its gyro cannot be checked: it turns too little")));
  EXPECT_THAT(rotating(0.5, 1), HasSubstr("data.csv: its stamps are 0.50 s earlier than "));
  EXPECT_THAT(rotating(-1.5, 1), HasSubstr("data.csv: its stamps are 1.50 s later than "));
  EXPECT_THAT(rotating(0.5, 1, 20), HasSubstr("imu0/data.csv:22: its clock leaps by 0.52 s"));
  EXPECT_EQ(rotating(0, 1.3), "");
  EXPECT_THAT(remarks, Contains(HasSubstr("its scale is wrong")));
  EXPECT_THAT(rotating(0, 57.3), HasSubstr("imu0/data.csv: its rotation speeds are 5"));
  edit("cam0/sensor.yaml", "rate_hz: 20", "rate_hz: 20\ntimeshift_cam_imu: 0.5");
  EXPECT_EQ(rotating(0.5, 1), "");
}

TEST_F(RecordedElsewhere, AClockJumpBetweenRowsIsReportedWithItsLine) {
  for (const auto& [name, values, step_s] :
       {std::tuple("cam0/data.csv", ",second.png", 0.05),
        {"imu0/data.csv", ",0,0,0,9.81,0,0", 0.02},
        {"state_groundtruth_estimate0/data.csv", ",0,0,0,1,0,0,0", 0.05}}) {
    const std::string kept = files::read_text(folder_ / "mav0" / name);
    const auto said = [&, name = name, values = values, step_s = step_s](double leap_s) {
      std::string rows = kept.substr(0, kept.find('\n') + 1);
      for (int i = 0; i < 9; ++i)
        rows += fmt::format("{:.0f}{}\n", 1e9 * (1403636579.7 + step_s * i + (i > 5 ? leap_s : 0)), values);
      write(name, rows);
      std::vector<std::string> remarks;
      const std::string error =
          files::error_of([&] { remarks = AslFolder(folder_.path()).sensors().remarks; });
      return error + fmt::format("{}", fmt::join(remarks, "\n"));
    };
    EXPECT_THAT(said(2), HasSubstr(fmt::format("{}:8: its clock leaps by {:.6g} s from", name, 2 + step_s)));
    EXPECT_THAT(said(2.5 * step_s), HasSubstr("leaps"));
    EXPECT_THAT(said(1.5 * step_s), Not(HasSubstr("leaps")));
    write(name, kept);
  }
}

TEST_F(RecordedElsewhere, ABadImageIsRejectedWhenItIsRead) {
  const fs::path file = folder_ / "mav0/cam0/data/second.png";
  const std::string png = files::read_text(file);
  const auto complaint_of = [&](const std::string& bytes) {
    files::write_text(file, bytes);
    return files::error_of([&] {
      for (AslFolder folder(folder_.path()); folder.next();) continue;
    });
  };
  EXPECT_EQ(complaint_of(png), "");
  EXPECT_EQ(complaint_of(png + "a trailer"), "");
  EXPECT_THAT(complaint_of(""), HasSubstr("second.png: cannot be read as an image: expected PNG or JPEG"));
  EXPECT_THAT(complaint_of(png.substr(0, png.size() - 20)),
              HasSubstr("second.png: cannot be read as an image"));
  const std::string jpeg = tests::encoded(".jpg", cv::Mat(48, 64, CV_8UC1, cv::Scalar(77)));
  EXPECT_EQ(complaint_of(jpeg), "");
  EXPECT_THAT(complaint_of(jpeg.substr(0, jpeg.size() - 2)), HasSubstr("second.png: is cut off"));
  EXPECT_THAT(complaint_of(tests::encoded(".png", cv::Mat(48, 65, CV_8UC1))),
              HasSubstr("second.png: is an image of 65x48, the camera's sensor.yaml has 64x48"));
}

TEST_F(RecordedElsewhere, LensesAreReadUnderTheNamesOfOtherPrograms) {
  const std::string kept = files::read_text(folder_ / "mav0/cam0/sensor.yaml");
  const auto lens = [&](const std::string& model, const std::string& coefficients) {
    write("cam0/sensor.yaml", kept.substr(0, kept.find("camera_model")) + "intrinsics: [45, 45, 36, 24]\n" +
                                  model + "\ndistortion_coefficients: " + coefficients + "\n");
    return AslFolder(folder_.path()).sensors().setup.calibration.camera.lens;
  };
  const auto words = [](const slam::Lens& found) {
    return fmt::format("{} {}", found.index(), fmt::join(rig::coefficients(found), " "));
  };
  for (const auto& row : tests::rows_of("sim/recording/lenses.txt")) {
    std::string found;
    const std::string error =
        files::error_of([&] { found = words(lens(tests::replaced(row[0], "\\n", "\n"), row[1])); });
    EXPECT_THAT(error.empty() ? found : error, HasSubstr(row.at(2))) << row[0];
  }
}

TEST_F(RecordedElsewhere, KeysThatContradictEachOtherAreRejected) {
  const std::string kept = files::read_text(folder_ / "mav0/cam0/sensor.yaml"),
                    inverse =
                        "T_SB:\n- [0.0149, 0.9996, -0.0258, 0.0652]\n- [-0.9999, 0.0150, 0.0038, -0.0207]\n"
                        "- [0.0041, 0.0257, 0.9997, -0.0081]\n- [0, 0, 0, 1]\n";
  const auto said = [&](const std::string& more) {
    write("cam0/sensor.yaml", kept + "\n" + more);
    return rejection();
  };
  EXPECT_EQ(said(inverse), "") << "four digits suffice";
  const auto renamed = [](std::string text) { return text.replace(text.find("T_SB"), 4, "T_cam_imu"); };
  EXPECT_EQ(said(renamed(inverse)), "") << "the IMU is the body";
  std::string edited = inverse;
  edited.replace(edited.find("0.0652"), 6, "0.0752");
  EXPECT_THAT(said(edited),
              ContainsRegex("cam0/sensor.yaml:6:3: T_BS: is not the inverse of T_SB on line [0-9]+: the "
                            "rotations differ by .* deg, the positions by 0.01 m"));
  EXPECT_THAT(said(renamed(edited)), HasSubstr("cam0/sensor.yaml: T_cam_imu contradicts T_BS here and in "));
  EXPECT_THAT(said("distortion_coeffs: [0, 0, 0, 0]"),
              HasSubstr("contradicts distortion_coefficients on line 17"));
  EXPECT_THAT(said("T_imu_cam: [1]"), HasSubstr("T_imu_cam: expected 16 numbers"));
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
    EXPECT_THAT(reader.sensors().remarks, Contains(HasSubstr("cam0/sensor.yaml: ignored keys: exposure_ms")));
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

/// Compares a truth at 100 Hz with 40 s of a gyro at 200 Hz with late stamps.
std::optional<GyroComparison> compared(const Rate& rate, double late_s, double noise_rad_s,
                                       int readings = 8000) {
  std::vector<TimedRotation> gyro;
  std::vector<files::TumRow> truth;
  sensor_errors::Random random(1, "gyro");
  const auto stamp = [](double t) { return slam::Stamp(std::llround(1e9 * t)); };
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  for (int i = 0; i < readings; ++i) {
    const double t = 0.005 * i;
    const Eigen::Vector3d w = rate(t);
    gyro.push_back({stamp(t + late_s), w + noise_rad_s * tests::random_vector(random)});
    files::TumRow row;
    row.t = stamp(t);
    row.X.linear() = q.toRotationMatrix();
    if (i % 2 == 0) truth.push_back(row);
    q = (q * Eigen::Quaterniond(Eigen::AngleAxisd(0.005 * w.norm(), w.stableNormalized()))).normalized();
  }
  return compare_gyro(gyro, truth);
}

constexpr double kStep = 2 * std::numbers::pi / 0.8;  // rad/s: steps of 0.8 s

Eigen::Vector3d walk(double t) {
  return {0.1 * std::sin(kStep * t), 0.05 * std::cos(2 * kStep * t), 0.2 * std::sin(0.3 * t)};
}
Eigen::Vector3d even_walk(double t) { return {0.1 * std::sin(kStep * t), 0.05 * std::cos(kStep * t), 0.3}; }
Eigen::Vector3d turn_of_yaw(double t) { return {0, 0, 0.2 * std::sin(0.3 * t * t)}; }

TEST(CompareGyro, FindsNothingOnGoodDataAndWithoutEvidence) {
  for (const double noise : {0.0, 0.05, 1.0}) {
    for (const Rate& rate : {Rate(walk), Rate(even_walk), Rate(turn_of_yaw)})
      for (const double late_s : {0.0, 0.004})
        for (const int readings : {100, 400, 8000}) {
          const auto found = compared(
              [&](double t) -> Eigen::Vector3d { return rate(t) + Eigen::Vector3d(0.02, -0.03, 0.01); },
              late_s, noise, readings);
          if (!found) continue;
          EXPECT_LE(std::abs(found->late_s), 0.01) << noise << " " << late_s;
        }
    EXPECT_FALSE(compared([](double) -> Eigen::Vector3d { return Eigen::Vector3d::Zero(); }, 1, noise));
    EXPECT_FALSE(compared([](double) -> Eigen::Vector3d { return {0, 0, 0.3}; }, 1, noise));
  }
  EXPECT_FALSE(compared(walk, 1, 5.0)) << "noise hides the motion";
  EXPECT_FALSE(compared(walk, 100, 0)) << "the spans are disjoint";
}

}  // namespace
}  // namespace sim::recording
