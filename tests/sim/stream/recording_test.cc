#include "sim/stream/recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <malloc.h>

#include <cstring>
#include <fstream>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "sim/stream/csv.h"
#include "sim/stream/manifest.h"
#include "sim/stream/random.h"
#include "tests/sim/stream/temporary_folder.h"

namespace sim::stream {
namespace {

namespace fs = std::filesystem;
using namespace std::string_literals;
using slam::Stamp;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr int kWidth = 32, kHeight = 24;

Eigen::Vector3d vector3(Random& random) { return {random.normal(), random.normal(), random.normal()}; }

Eigen::Isometry3d pose(Random& random) {
  Eigen::Isometry3d X(
      Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal()).normalized());
  X.translation() = vector3(random);
  return X;
}

cv::Mat image(Random& random) {
  cv::Mat pixels(kHeight, kWidth, CV_8UC1);
  for (int row = 0; row < kHeight; ++row)
    for (int column = 0; column < kWidth; ++column)
      pixels.at<unsigned char>(row, column) = random.bits() & 255;
  return pixels;
}

slam::PlannedMotion plan(Random& random) {
  return {pose(random), vector3(random), vector3(random), vector3(random),
          static_cast<slam::Support>(random.bits() % 3)};
}

RecordingSetup setup_of(Random& random) {
  RecordingSetup setup;
  setup.calibration.camera = {kWidth, kHeight, 19.7 + random.uniform(),          19.5,
                              15.7,   12.7,    slam::OneParameterRadial{7.37e-4}};
  setup.calibration.X_CG = pose(random);
  setup.X_WC_start = pose(random);
  setup.joints = {"HIP", "KNEE", "ANKLE"};
  return setup;
}

// Observations as a run gives them: readings every 5 ms, split at the frames; some frames without image or
// plan.
std::vector<slam::Observation> observations(Random& random, int count, bool accelerometer) {
  std::vector<slam::Observation> all;
  Stamp begin{-2'000'000};
  for (int k = 0; k < count; ++k) {
    slam::Observation o;
    o.t = Stamp(33'000'000ll * k);
    while (begin < o.t) {
      const Stamp tick{(begin.count() / 5'000'000 + 1) * 5'000'000},
          end = std::min(o.t, begin.count() < 0 ? Stamp{0} : tick);
      o.gyro.push_back({begin, end, vector3(random)});
      if (accelerometer) o.accelerometer.push_back({begin, end, vector3(random)});
      begin = end;
    }
    if (k % 5 != 3) o.image = image(random);
    if (k % 7 != 4) o.plan = plan(random);
    all.push_back(o);
  }
  return all;
}

template <typename Eigen1, typename Eigen2>
bool same_bits(const Eigen1& a, const Eigen2& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

void expect_same(const std::vector<slam::InertialSample>& a, const std::vector<slam::InertialSample>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].begin, b[i].begin);
    EXPECT_EQ(a[i].end, b[i].end);
    EXPECT_TRUE(same_bits(a[i].value, b[i].value));
  }
}

void expect_same(const slam::Observation& a, const slam::Observation& b) {
  EXPECT_EQ(a.t, b.t);
  expect_same(a.gyro, b.gyro);
  expect_same(a.accelerometer, b.accelerometer);
  ASSERT_EQ(a.image.empty(), b.image.empty());
  if (!a.image.empty()) {
    ASSERT_EQ(a.image.size(), b.image.size());
    ASSERT_EQ(a.image.type(), b.image.type());
    EXPECT_EQ(cv::norm(a.image, b.image, cv::NORM_INF), 0);
  }
  ASSERT_EQ(a.plan.has_value(), b.plan.has_value());
  if (!a.plan) return;
  EXPECT_TRUE(same_bits(a.plan->X_PC.matrix(), b.plan->X_PC.matrix()));
  EXPECT_TRUE(same_bits(a.plan->v_PC_C, b.plan->v_PC_C));
  EXPECT_TRUE(same_bits(a.plan->w_PC_C, b.plan->w_PC_C));
  EXPECT_TRUE(same_bits(a.plan->p_CF, b.plan->p_CF));
  EXPECT_EQ(a.plan->support, b.plan->support);
}

// A finished recording of a few frames with truth and one surface.
struct Recorded {
  explicit Recorded(const fs::path& folder_, std::uint64_t seed = 1, bool accelerometer = true)
      : folder(folder_) {
    Random random(seed, "test");
    setup = setup_of(random);
    given = observations(random, 12, accelerometer);
    RecordingWriter writer(folder, setup);
    for (const slam::Observation& o : given) {
      writer.add(o);
      poses.push_back({o.t, pose(random), pose(random), pose(random)});
      writer.add(poses.back());
      bodies.push_back(
          {o.t, vector3(random), {vector3(random), vector3(random)}, {vector3(random), vector3(random)}});
      writer.add(bodies.back());
      writer.add(TrueMotion{o.t, pose(random), vector3(random)});
    }
    writer.add(surface = {"box", pose(random), {0.5, 1, 0.25}});
    writer.finish();
  }
  fs::path folder;
  RecordingSetup setup;
  std::vector<slam::Observation> given;
  std::vector<TruePoses> poses;
  std::vector<BodyReading> bodies;
  RecordedSurface surface;
};

std::vector<slam::Observation> read_all(const fs::path& folder) {
  std::vector<slam::Observation> all;
  RecordingReader reader(folder);
  while (auto observation = reader.next()) all.push_back(*observation);
  return all;
}

std::string content(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

TEST(Recording, ObservationsComeBackBitForBit) {
  const TemporaryFolder folder;
  for (const bool accelerometer : {true, false})
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const Recorded recorded(folder / (std::to_string(seed) + (accelerometer ? "a" : "b")), seed,
                              accelerometer);
      const std::vector<slam::Observation> read = read_all(recorded.folder);
      ASSERT_EQ(read.size(), recorded.given.size());
      for (std::size_t i = 0; i < read.size(); ++i) expect_same(read[i], recorded.given[i]);
    }
}

TEST(Recording, CalibrationAndStartComeBackBitForBit) {
  const TemporaryFolder folder;
  const Recorded recorded(folder / "r");
  const RecordingReader reader(recorded.folder);
  const slam::CameraIntrinsics &given = recorded.setup.calibration.camera,
                               &read = reader.setup().calibration.camera;
  EXPECT_EQ(read.width_px, given.width_px);
  EXPECT_EQ(read.height_px, given.height_px);
  EXPECT_EQ(read.fu_px, given.fu_px);
  EXPECT_EQ(read.fv_px, given.fv_px);
  EXPECT_EQ(read.u0_px, given.u0_px);
  EXPECT_EQ(read.v0_px, given.v0_px);
  EXPECT_EQ(std::get<slam::OneParameterRadial>(read.lens).k1_px2,
            std::get<slam::OneParameterRadial>(given.lens).k1_px2);
  EXPECT_TRUE(same_bits(reader.setup().calibration.X_CG.matrix(), recorded.setup.calibration.X_CG.matrix()));
  EXPECT_TRUE(same_bits(reader.setup().X_WC_start.matrix(), recorded.setup.X_WC_start.matrix()));
  EXPECT_EQ(reader.setup().camera_rate_hz, 30);
  EXPECT_EQ(reader.setup().imu_rate_hz, 200);
}

TEST(Recording, KeepsWhatTheBodyFeelsBitForBit) {
  const TemporaryFolder folder;
  const Recorded recorded(folder / "r");
  CsvReader encoders(recorded.folder / "mav0/encoders0/data.csv",
                     {"#timestamp [ns],HIP [rad],KNEE [rad],ANKLE [rad]"});
  CsvReader forces(recorded.folder / "mav0/forces0/data.csv",
                   {"#timestamp [ns],f_L_x [N],f_L_y [N],f_L_z [N],m_L_x [N m],m_L_y [N m],m_L_z [N m],"
                    "f_R_x [N],f_R_y [N],f_R_z [N],m_R_x [N m],m_R_y [N m],m_R_z [N m]"});
  for (const BodyReading& reading : recorded.bodies) {
    ASSERT_TRUE(encoders.next() && forces.next());
    EXPECT_EQ(encoders.integer(0), (kEpoch + reading.t).count());
    EXPECT_EQ(forces.integer(0), encoders.integer(0));
    EXPECT_TRUE(same_bits(encoders.vector(1), reading.q));
    EXPECT_TRUE(same_bits(forces.vector(1), reading.left.force));
    EXPECT_TRUE(same_bits(forces.vector(4), reading.left.torque));
    EXPECT_TRUE(same_bits(forces.vector(7), reading.right.force));
    EXPECT_TRUE(same_bits(forces.vector(10), reading.right.torque));
  }
  EXPECT_FALSE(encoders.next());
  EXPECT_THAT(content(recorded.folder / "mav0/encoders0/sensor.yaml"),
              HasSubstr("joints: [HIP, KNEE, ANKLE]"));
}

TEST(Recording, TruthComesBackBitForBit) {
  const TemporaryFolder folder;
  const Recorded recorded(folder / "r");
  const Truth truth = read_truth(recorded.folder);
  ASSERT_EQ(truth.camera.size(), recorded.poses.size());
  ASSERT_EQ(truth.waist.size(), recorded.poses.size());
  ASSERT_EQ(truth.waist_plan.size(), recorded.poses.size());
  for (std::size_t i = 0; i < recorded.poses.size(); ++i) {
    EXPECT_EQ(truth.camera[i].t, recorded.poses[i].t);
    EXPECT_TRUE(same_bits(truth.camera[i].X.matrix(), recorded.poses[i].X_WC.matrix()));
    EXPECT_TRUE(same_bits(truth.waist[i].X.matrix(), recorded.poses[i].X_WB.matrix()));
    EXPECT_TRUE(same_bits(truth.waist_plan[i].X.matrix(), recorded.poses[i].X_PB.matrix()));
  }
  ASSERT_EQ(truth.surfaces.size(), 1u);
  EXPECT_EQ(truth.surfaces[0].kind, "box");
  EXPECT_TRUE(same_bits(truth.surfaces[0].X_WS.matrix(), recorded.surface.X_WS.matrix()));
  EXPECT_EQ(truth.surfaces[0].size, recorded.surface.size);
}

TEST(Recording, SameInputGivesTheSameBytes) {
  const TemporaryFolder folder;
  const Recorded a(folder / "a"), b(folder / "b");
  EXPECT_EQ(content(a.folder / "manifest.csv"), content(b.folder / "manifest.csv"));
  EXPECT_EQ(RecordingReader(a.folder).hash(), RecordingReader(b.folder).hash());
  EXPECT_NE(RecordingReader(a.folder).hash(), RecordingReader(Recorded(folder / "c", 2).folder).hash());
}

TEST(Recording, HasTheLayoutThatOtherReadersExpect) {
  const TemporaryFolder folder;
  const Recorded recorded(folder / "r");
  const std::string camera = content(recorded.folder / "mav0/cam0/data.csv");
  EXPECT_EQ(camera.substr(0, camera.find("\n1000000000033")),
            "#timestamp [ns],filename\n1000000000000000000,1000000000000000000.png");
  const cv::Mat image =
      cv::imread(recorded.folder / "mav0/cam0/data/1000000000033000000.png", cv::IMREAD_UNCHANGED);
  EXPECT_EQ(cv::norm(image, recorded.given[1].image, cv::NORM_INF), 0);
  EXPECT_THAT(
      content(recorded.folder / "mav0/imu0/data.csv"),
      testing::StartsWith("#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
                          "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n1000000000000000000,"));
  std::istringstream motion(content(recorded.folder / "mav0/state_groundtruth_estimate0/data.csv"));
  for (std::string line; std::getline(motion, line);)
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), 16);
  cv::FileStorage sensor((recorded.folder / "mav0/cam0/sensor.yaml").string(), cv::FileStorage::READ);
  EXPECT_EQ(static_cast<int>(sensor["resolution"][0]), kWidth);
  const Eigen::Matrix4d expected = recorded.setup.calibration.X_CG.inverse().matrix();
  for (int i = 0; i < 16; ++i)  // T_BS of body G is X_GC
    EXPECT_EQ(static_cast<double>(sensor["T_BS"]["data"][i]), expected(i / 4, i % 4));
}

TEST(Recording, UnfinishedIsRefused) {
  const TemporaryFolder folder;
  Random random(1, "test");
  {
    RecordingWriter writer(folder / "r", setup_of(random));
    for (const slam::Observation& o : observations(random, 3, true)) writer.add(o);
  }
  EXPECT_THAT([&] { RecordingReader reader(folder / "r"); },
              ThrowsMessage<FileError>(HasSubstr("never finished")));
  EXPECT_THAT([&] { RecordingReader reader(folder / "none"); },
              ThrowsMessage<FileError>(HasSubstr("none: no such folder")));
}

std::vector<fs::path> files_of(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && entry.path().filename() != "manifest.csv") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

void replace(const fs::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

// Reads observations, then truth, as a replay does.
void read_everything(const fs::path& folder) {
  read_all(folder);
  read_truth(folder);
}

TEST(Recording, AnyMissingFileIsNamed) {
  const TemporaryFolder folder;
  const Recorded recorded(folder / "r");
  for (const fs::path& file : files_of(recorded.folder)) {
    const std::string bytes = content(file);
    fs::remove(file);
    EXPECT_THAT([&] { RecordingReader reader(recorded.folder); },
                ThrowsMessage<FileError>(HasSubstr(file.string() + ": is missing")));
    replace(file, bytes);
  }
  EXPECT_NO_THROW(read_everything(recorded.folder));
}

TEST(Recording, AnyTruncatedFileIsNamed) {
  const TemporaryFolder folder;
  const Recorded recorded(folder / "r");
  Random random(9, "cut");
  for (const fs::path& file : files_of(recorded.folder)) {
    const std::string bytes = content(file);
    fs::resize_file(file, random.bits() % bytes.size());
    EXPECT_THAT([&] { RecordingReader reader(recorded.folder); },
                ThrowsMessage<FileError>(HasSubstr(file.string() + ": truncated")));
    replace(file, bytes);
  }
}

TEST(Recording, AnyEditedFileIsNamedWhichHasTheSameSize) {
  const TemporaryFolder folder;
  const Recorded recorded(folder / "r");
  Random random(9, "edit");
  for (const fs::path& file : files_of(recorded.folder)) {
    const std::string bytes = content(file);
    for (int trial = 0; trial < 5; ++trial) {
      std::string edited = bytes;
      edited[random.bits() % bytes.size()] ^= static_cast<char>(1 << random.bits() % 8);
      replace(file, edited);
      EXPECT_THAT([&] { read_everything(recorded.folder); },
                  ThrowsMessage<FileError>(HasSubstr(file.string() + ": edited")));
    }
    replace(file, bytes);
  }
}

TEST(Recording, EditedManifestIsRefused) {
  const TemporaryFolder folder;
  const Recorded recorded(folder / "r");
  const fs::path manifest = recorded.folder / "manifest.csv";
  const std::string bytes = content(manifest);
  Random random(10, "edit");
  for (int trial = 0; trial < 200; ++trial) {
    std::string edited = bytes;
    edited[random.bits() % bytes.size()] ^= static_cast<char>(1 << random.bits() % 8);
    replace(manifest, edited);
    try {
      read_everything(recorded.folder);
      // What nothing reads can lose its line's hash unseen; what is read cannot.
      SUCCEED();
    } catch (const FileError& error) {
      EXPECT_THAT(error.what(), HasSubstr(recorded.folder.string()));
    }
  }
  replace(manifest, bytes.substr(0, bytes.size() / 2));
  EXPECT_THROW(read_everything(recorded.folder), FileError);
}

// Brings the manifest up to date with a file that was edited, so that only what the file says can give it
// away.
void sign_again(const fs::path& folder, const std::string& name) {
  const fs::path manifest = folder / "manifest.csv";
  Hash hash;
  hash.add(content(folder / name));
  std::istringstream lines(content(manifest));
  std::string signed_again;
  for (std::string line; std::getline(lines, line); signed_again += "\n")
    signed_again +=
        line.ends_with("," + name) ? hash.hex() + "," + std::to_string(hash.bytes()) + "," + name : line;
  replace(manifest, signed_again);
}

// What reading says of a recording in whose file `name` the first `from` became `to`, hash and all.
std::string complaint(const fs::path& folder, const std::string& name, const std::string& from,
                      const std::string& to) {
  fs::remove_all(folder);
  const Recorded recorded(folder);
  std::string text = content(folder / name);
  EXPECT_NE(text.find(from), text.npos) << from;
  replace(folder / name, text.replace(text.find(from), from.size(), to));
  sign_again(folder, name);
  try {
    read_everything(folder);
  } catch (const FileError& error) {
    const std::string what = error.what(), start = (folder / name).string();
    return what.starts_with(start) ? what.substr(start.size()) : "of another file: " + what;
  }
  return "";
}

TEST(Recording, WhatIsWrongInAFileIsSaidWithLineAndColumn) {
  const TemporaryFolder folder;
  const auto says = [&](const std::string& name, const std::string& from, const std::string& to) {
    return complaint(folder / "r", name, from, to);
  };
  EXPECT_EQ(says("frames.csv", "1000000000033000000", "1000000000033000000"), "");  // as it was
  EXPECT_EQ(says("frames.csv", "#timestamp", "#time"),
            ":1: expected the header \"#timestamp [ns]\", found \"#time [ns]\"");
  EXPECT_EQ(says("frames.csv", "1000000000033000000", "soon"), ":3:1: expected an integer, found \"soon\"");
  EXPECT_EQ(says("frames.csv", "1000000000033000000", "-5"), ":3:1: a stamp below zero");
  EXPECT_EQ(says("frames.csv", "1000000000033000000", "1000000000000000000"),
            ":3:1: the stamp is not after the one before");
  EXPECT_EQ(says("frames.csv", "1000000000033000000\n", "1000000000033000000,\n"),
            ":3: expected 1 fields, found 2");
  EXPECT_EQ(says("frames.csv", "1000000000363000000\n", "1000000000363000000"),
            ":13: the last line is cut off: it does not end with a line feed");
  EXPECT_EQ(says("mav0/cam0/data.csv", "1000000000033000000,", "1000000000034000000,"),
            ":3:1: no frame of frames.csv has this stamp");
  EXPECT_THAT(
      says("mav0/plan0/data.csv", "1000000000033000000,", "1000000000033000000,x"),
      AllOf(testing::StartsWith(":3:21: expected a finite number, found \"x"), testing::EndsWith("\"")));
  EXPECT_THAT(says("mav0/plan0/data.csv", "1000000000033000000,", "1000000000033000000,nan,"),
              HasSubstr(":3: expected 23 fields, found 24"));
  EXPECT_THAT(says("truth/surfaces.csv", "0.5,1,0.25", "0.5,inf,0.25"),
              HasSubstr("expected a finite number, found \"inf\""));
  EXPECT_THAT(says("mav0/cam0/data.csv", "033000000.png", "034000000.png"), HasSubstr("of another file"));
  EXPECT_EQ(says("mav0/cam0/sensor.yaml", "resolution: [32", "resolution: [0"),
            ":19:13: expected whole numbers from 1 to 100000");
  EXPECT_EQ(says("mav0/cam0/sensor.yaml", "intrinsics: [", "intrinsics: [1, "), ":21:13: expected 4 numbers");
  EXPECT_EQ(says("mav0/cam0/sensor.yaml", "rate_hz", "rate"), ": has no key rate_hz");
  EXPECT_THAT(says("mav0/cam0/sensor.yaml", "resolution: [", "resolution: {"), HasSubstr(":19:"));
  EXPECT_EQ(
      says("mav0/plan0/sensor.yaml", "0, 0, 0, 1]", "0, 0, 0, 2]"),
      ":6:3: not a pose: its first three rows and columns are no rotation, or its last row is not 0 0 0 1");
  EXPECT_EQ(says("mav0/imu0/sensor.yaml", "first_interval_begins_ns: ", "first_interval_began: "),
            ": has no key first_interval_begins_ns");
  EXPECT_THAT(says("mav0/imu0/sensor.yaml", "first_interval_begins_ns: ", "first_interval_begins_ns: 9"),
              HasSubstr("expected an integer"));
  EXPECT_THAT(says("mav0/imu0/sensor.yaml", "first_interval_begins_ns: 9", "first_interval_begins_ns: 19"),
              HasSubstr("of another file"));
}

TEST(Recording, NoEditOfAnyTextFileCrashesTheReader) {
  const TemporaryFolder folder;
  const Recorded recorded(folder / "r");
  Random random(11, "edit");
  const std::string alphabet = "0123456789.,-+e\n\r\0\xff[]{}:#\" nai"s;  // with a zero in it
  int refused = 0;
  for (const fs::path& file : files_of(recorded.folder)) {
    if (file.extension() == ".png") continue;
    const std::string bytes = content(file), name = fs::relative(file, recorded.folder).string();
    for (int trial = 0; trial < 25; ++trial) {
      std::string edited = bytes;
      for (std::uint64_t edits = 1 + random.bits() % 3; edits > 0; --edits) {
        const std::size_t at = random.bits() % edited.size(), length = random.bits() % 4;
        edited.replace(at, random.bits() % 3, std::string(length, alphabet[random.bits() % alphabet.size()]));
      }
      replace(file, edited);
      sign_again(recorded.folder, name);
      try {
        read_everything(recorded.folder);
      } catch (const FileError& error) {
        EXPECT_THAT(error.what(), HasSubstr(recorded.folder.string()));
        ++refused;
      }
    }
    replace(file, bytes);
    sign_again(recorded.folder, name);
  }
  EXPECT_GT(refused, 100);
  EXPECT_NO_THROW(read_everything(recorded.folder));
}

TEST(Recording, TheWriterRefusesWhatIdealSensorsCannotGive) {
  const TemporaryFolder folder;
  const auto writing = [&](const std::function<void(std::vector<slam::Observation>&)>& spoil) {
    return [&folder, spoil] {
      fs::remove_all(folder / "r");
      Random random(1, "test");
      RecordingWriter writer(folder / "r", setup_of(random));
      std::vector<slam::Observation> all = observations(random, 4, true);
      spoil(all);
      for (const slam::Observation& o : all) writer.add(o);
    };
  };
  EXPECT_NO_THROW(writing([](auto&) {})());
  EXPECT_THAT(writing([](auto& all) { all[2].t = all[1].t; }),
              ThrowsMessage<std::logic_error>(HasSubstr("frame")));
  EXPECT_THAT(writing([](auto& all) { all[1].gyro.pop_back(), all[1].accelerometer.pop_back(); }),
              ThrowsMessage<std::logic_error>(HasSubstr("chain")));
  EXPECT_THAT(writing([](auto& all) { all[2].accelerometer.clear(); }),
              ThrowsMessage<std::logic_error>(HasSubstr("comes and goes")));
  EXPECT_THAT(writing([](auto& all) { all[2].accelerometer.pop_back(); }),
              ThrowsMessage<std::logic_error>(HasSubstr("number")));
  EXPECT_THAT(writing([](auto& all) { all[2].accelerometer[1].begin += Stamp(1); }),
              ThrowsMessage<std::logic_error>(HasSubstr("differ in time")));
  EXPECT_THAT(writing([](auto& all) { all[1].image = cv::Mat(4, 4, CV_8UC1); }),
              ThrowsMessage<std::logic_error>(HasSubstr("size")));
  EXPECT_THAT(writing([](auto& all) { all[0].t -= Stamp(1); }),
              ThrowsMessage<std::logic_error>(HasSubstr("of its frame")));
}

// Names, sizes and hashes of 2000 pictures alone would be 200 kB.
TEST(Recording, TheWriterNeedsNoMoreMemoryForALongerRun) {
  const TemporaryFolder folder;
  Random random(1, "test");
  RecordingWriter writer(folder / "r", setup_of(random));
  Stamp t{0};
  const auto write = [&](int frames) {
    for (int k = 0; k < frames; ++k, t += Stamp(33'000'000)) {
      writer.add(slam::Observation{t, image(random), {}, {}, plan(random)});
      writer.add(TruePoses{t, pose(random), pose(random), pose(random)});
      writer.add(BodyReading{t, vector3(random), {}, {}});
      writer.add(TrueMotion{t, pose(random), vector3(random)});
      writer.add(TrueFeet{t, {}, {}});
    }
    return mallinfo2().uordblks;  // bytes that the process has asked for and not given back
  };
  const std::size_t early = write(100), late = write(2000);
  EXPECT_LT(late, early + 50'000);
}

TEST(Recording, TheWriterRefusesAFolderThatExists) {
  const TemporaryFolder folder;
  Random random(1, "test");
  EXPECT_THAT([&] { RecordingWriter writer(folder.path(), setup_of(random)); },
              ThrowsMessage<FileError>(HasSubstr("exists already")));
}

}  // namespace
}  // namespace sim::stream
