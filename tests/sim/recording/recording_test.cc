#include "sim/recording/recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <malloc.h>
#include <sys/stat.h>

#include <cstring>
#include <fstream>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "sim/files/csv.h"
#include "sim/files/hash.h"
#include "sim/files/text.h"
#include "sim/recording/sensor_yaml.h"
#include "sim/sensor_errors/random.h"
#include "tests/sim/files/temporary_folder.h"
#include "tests/sim/recording/random_readings.h"

namespace sim::recording {
namespace {

namespace fs = std::filesystem;
using slam::Stamp;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;
using tests::random_image, tests::random_pose, tests::random_vector;

constexpr int kWidth = 32, kHeight = 40;

slam::PlannedMotion plan(sensor_errors::Random& random) {
  return {random_pose(random), random_vector(random), random_vector(random), random_vector(random),
          static_cast<slam::Support>(random.bits() % 3)};
}

RecordingSetup setup_of(sensor_errors::Random& random) {
  RecordingSetup setup;
  setup.calibration.camera = {kWidth, kHeight, 19.7 + random.uniform(),          19.5,
                              15.7,   12.7,    slam::OneParameterRadial{7.37e-4}};
  setup.calibration.X_CG = random_pose(random);
  setup.X_WC_start = random_pose(random);
  setup.joints = {"HIP", "KNEE", "ANKLE"};
  return setup;
}

// Observations as a run gives them: readings every 5 ms, split at the frames; some frames without image or
// plan.
std::vector<slam::Observation> observations(sensor_errors::Random& random, int count, bool accelerometer,
                                            bool legs = false) {
  std::vector<slam::Observation> all;
  Stamp begin{-2'000'000};
  for (int k = 0; k < count; ++k) {
    slam::Observation o;
    o.t = Stamp(33'000'000ll * k);
    while (begin < o.t) {
      const Stamp tick{(begin.count() / 5'000'000 + 1) * 5'000'000},
          end = std::min(o.t, begin.count() < 0 ? Stamp{0} : tick);
      o.gyro.push_back({begin, end, random_vector(random)});
      if (accelerometer) o.accelerometer.push_back({begin, end, random_vector(random)});
      begin = end;
    }
    if (k % 5 != 3) o.image = random_image({kWidth, kHeight}, random);
    if (k % 7 != 4) o.plan = plan(random);
    if (o.plan && legs) o.plan->legs = slam::LegMotion{random_pose(random), random_vector(random)};
    all.push_back(o);
  }
  return all;
}

template <typename Eigen1, typename Eigen2>
bool same_bits(const Eigen1& a, const Eigen2& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

void append(std::vector<double>& all, const auto& values) {
  all.insert(all.end(), values.data(), values.data() + values.size());
}

// All that an observation has besides its image.
std::vector<double> numbers_of(const slam::Observation& o) {
  const auto ns = [](Stamp t) { return static_cast<double>(t.count()); };
  std::vector<double> all{ns(o.t), static_cast<double>(o.gyro.size()), o.plan ? 1.0 : 0.0};
  for (const auto* readings : {&o.gyro, &o.accelerometer})
    for (const slam::InertialSample& reading : *readings) {
      all.insert(all.end(), {ns(reading.begin), ns(reading.end)});
      append(all, reading.value);
    }
  if (!o.plan) return all;
  append(all, o.plan->X_PC.matrix());
  for (const auto& v : {o.plan->v_PC_C, o.plan->w_PC_C, o.plan->p_CF}) append(all, v);
  all.push_back(static_cast<double>(o.plan->support));
  if (!o.plan->legs) return all;
  append(all, o.plan->legs->X_OC.matrix());
  append(all, o.plan->legs->p_CS);
  return all;
}

void expect_same(const slam::Observation& a, const slam::Observation& b) {
  EXPECT_TRUE(same_bits(numbers_of(a), numbers_of(b)));
  ASSERT_EQ(a.image.size(), b.image.size());
  ASSERT_EQ(a.image.type(), b.image.type());
  EXPECT_TRUE(a.image.empty() || cv::norm(a.image, b.image, cv::NORM_INF) == 0);
}

// A finished recording of a few frames with truth and one surface.
struct Recorded {
  explicit Recorded(const fs::path& folder_, std::uint64_t seed = 1, bool accelerometer = true)
      : folder(folder_) {
    sensor_errors::Random random(seed, "test");
    setup = setup_of(random);
    given = observations(random, 12, accelerometer, accelerometer);
    RecordingWriter writer(folder, setup);
    for (const slam::Observation& o : given) {
      writer.add(o);
      poses.push_back({o.t, random_pose(random), random_pose(random), random_pose(random)});
      writer.add(poses.back());
      bodies.push_back({o.t,
                        random_vector(random),
                        {random_vector(random), random_vector(random)},
                        {random_vector(random), random_vector(random)}});
      writer.add(bodies.back());
      writer.add(TrueMotion{o.t, random_pose(random), random_vector(random)});
    }
    writer.add(surface = {score::Surface::Kind::box, random_pose(random), {0.5, 1, 0.25}});
    writer.finish();
  }
  fs::path folder;
  RecordingSetup setup;
  std::vector<slam::Observation> given;
  std::vector<TruePoses> poses;
  std::vector<BodyReading> bodies;
  score::Surface surface;
};

std::vector<slam::Observation> read_all(const fs::path& folder) {
  std::vector<slam::Observation> all;
  RecordingReader reader(folder);
  while (auto observation = reader.next()) all.push_back(*observation);
  return all;
}

TEST(Recording, ObservationsComeBackBitForBit) {
  const files::TemporaryFolder folder;
  for (const bool accelerometer : {true, false})
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const Recorded recorded(folder / (std::to_string(seed) + (accelerometer ? "a" : "b")), seed,
                              accelerometer);
      const std::vector<slam::Observation> read = read_all(recorded.folder);
      ASSERT_EQ(read.size(), recorded.given.size());
      for (std::size_t i = 0; i < read.size(); ++i) expect_same(read[i], recorded.given[i]);
    }
}

TEST(Recording, ThePartThatWasReadRisesToOne) {
  const files::TemporaryFolder folder;
  RecordingReader reader(Recorded(folder / "r").folder);
  double before = reader.part();
  EXPECT_LT(before, 0.5);
  while (reader.next()) {
    EXPECT_GE(reader.part(), before);
    before = reader.part();
  }
  EXPECT_EQ(reader.part(), 1);
}

TEST(Recording, CalibrationAndStartComeBackBitForBit) {
  const files::TemporaryFolder folder;
  const Recorded recorded(folder / "r");
  const RecordingReader reader(recorded.folder);
  EXPECT_EQ(camera_yaml(reader.setup()), camera_yaml(recorded.setup));  // numbers in it round-trip
  EXPECT_TRUE(same_bits(reader.setup().X_WC_start.matrix(), recorded.setup.X_WC_start.matrix()));
  EXPECT_EQ(reader.setup().camera_rate_hz, 30);
  EXPECT_EQ(reader.setup().imu_rate_hz, 200);
}

TEST(Recording, KeepsTheReadingsOfTheBodySensorsBitForBit) {
  const files::TemporaryFolder folder;
  const Recorded recorded(folder / "r");
  files::CsvReader encoders(recorded.folder / "mav0/encoders0/data.csv",
                            {"#timestamp [ns],HIP [rad],KNEE [rad],ANKLE [rad]"});
  files::CsvReader forces(
      recorded.folder / "mav0/forces0/data.csv",
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
  EXPECT_THAT(files::read_text(recorded.folder / "mav0/encoders0/sensor.yaml"),
              HasSubstr("joints: [HIP, KNEE, ANKLE]"));
}

TEST(Recording, TruthComesBackBitForBit) {
  const files::TemporaryFolder folder;
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
  EXPECT_EQ(truth.surfaces[0].kind, score::Surface::Kind::box);
  EXPECT_TRUE(same_bits(truth.surfaces[0].X_WS.matrix(), recorded.surface.X_WS.matrix()));
  EXPECT_EQ(truth.surfaces[0].size, recorded.surface.size);
}

TEST(Recording, SameInputGivesTheSameBytes) {
  const files::TemporaryFolder folder;
  const Recorded a(folder / "a"), b(folder / "b");
  EXPECT_EQ(files::read_text(a.folder / "manifest.csv"), files::read_text(b.folder / "manifest.csv"));
  EXPECT_EQ(RecordingReader(a.folder).hash(), RecordingReader(b.folder).hash());
  EXPECT_NE(RecordingReader(a.folder).hash(), RecordingReader(Recorded(folder / "c", 2).folder).hash());
}

TEST(Recording, HasTheLayoutThatOtherReadersExpect) {
  const files::TemporaryFolder folder;
  const Recorded recorded(folder / "r");
  const std::string camera = files::read_text(recorded.folder / "mav0/cam0/data.csv");
  EXPECT_EQ(camera.substr(0, camera.find("\n1000000000033")),
            "#timestamp [ns],filename\n1000000000000000000,1000000000000000000.png");
  const cv::Mat image =
      cv::imread(recorded.folder / "mav0/cam0/data/1000000000033000000.png", cv::IMREAD_UNCHANGED);
  EXPECT_EQ(cv::norm(image, recorded.given[1].image, cv::NORM_INF), 0);
  EXPECT_THAT(
      files::read_text(recorded.folder / "mav0/imu0/data.csv"),
      testing::StartsWith("#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
                          "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n1000000000000000000,"));
  std::istringstream motion(files::read_text(recorded.folder / "mav0/state_groundtruth_estimate0/data.csv"));
  for (std::string line; std::getline(motion, line);)
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), 16);
  cv::FileStorage sensor((recorded.folder / "mav0/cam0/sensor.yaml").string(), cv::FileStorage::READ);
  EXPECT_EQ(static_cast<int>(sensor["resolution"][0]), kWidth);
  const Eigen::Matrix4d expected = recorded.setup.calibration.X_CG.inverse().matrix();
  for (int i = 0; i < 16; ++i)  // T_BS of body G is X_GC
    EXPECT_EQ(static_cast<double>(sensor["T_BS"]["data"][i]), expected(i / 4, i % 4));
}

TEST(Recording, AnUnfinishedOneIsRejected) {
  const files::TemporaryFolder folder;
  sensor_errors::Random random(1, "test");
  {
    RecordingWriter writer(folder / "r", setup_of(random));
    for (const slam::Observation& o : observations(random, 3, true)) writer.add(o);
  }
  EXPECT_THAT([&] { RecordingReader reader(folder / "r"); },
              ThrowsMessage<files::FileError>(HasSubstr("never finished")));
  EXPECT_THAT([&] { RecordingReader reader(folder / "none"); },
              ThrowsMessage<files::FileError>(HasSubstr("none: no such folder")));
}

std::vector<fs::path> files_of(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && entry.path().filename() != "manifest.csv") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

// Reads observations, then truth, as a replay does.
void read_everything(const fs::path& folder) {
  read_all(folder);
  read_truth(folder);
}

// Each file of a recording, after `spoil` changed it on the disk, is named with these words.
void expect_named(const std::function<void(const fs::path& file, const std::string& bytes)>& spoil,
                  const std::string& words, bool with_manifest = false) {
  const files::TemporaryFolder folder;
  const Recorded recorded(folder / "r");
  std::vector<fs::path> all = files_of(recorded.folder);
  if (with_manifest) all.push_back(recorded.folder / "manifest.csv");
  for (const fs::path& file : all) {
    const std::string bytes = files::read_text(file);
    spoil(file, bytes);
    EXPECT_THAT([&] { read_everything(recorded.folder); },
                ThrowsMessage<files::FileError>(HasSubstr(file.string() + words)));
    fs::remove(file);
    files::write_text(file, bytes);
  }
  EXPECT_NO_THROW(read_everything(recorded.folder));
}

TEST(Recording, AnyMissingFileIsNamed) {
  expect_named([](const fs::path& file, const std::string&) { fs::remove(file); }, ": is missing", true);
}

TEST(Recording, APipeInPlaceOfAnyFileIsNamed) {
  const auto pipe = [](const fs::path& file, const std::string&) {
    fs::remove(file);
    ASSERT_EQ(mkfifo(file.c_str(), 0600), 0);
  };
  expect_named(pipe, ": is not a regular file", true);
}

TEST(Recording, AnyTruncatedFileIsNamed) {
  sensor_errors::Random random(9, "cut");
  const auto cut = [&](const fs::path& file, const std::string& bytes) {
    fs::resize_file(file, random.bits() % bytes.size());
  };
  expect_named(cut, ": truncated");
}

TEST(Recording, AnyEditedFileOfTheSameSizeIsNamed) {
  sensor_errors::Random random(9, "edit");
  const auto edit = [&](const fs::path& file, std::string bytes) {
    bytes[random.bits() % bytes.size()] ^= static_cast<char>(1 << random.bits() % 8);
    files::write_text(file, bytes);
  };
  for (int trial = 0; trial < 5; ++trial) expect_named(edit, ": edited");
}

// Sparse files, listed with their sizes.
TEST(Recording, ASettingsFileOrAnImageThatIsTooLargeIsNamedBeforeItIsRead) {
  const files::TemporaryFolder folder;
  for (const std::string name : {"mav0/cam0/sensor.yaml", "mav0/cam0/data/1000000000033000000.png"}) {
    const Recorded recorded(folder / fs::path(name).filename());
    const fs::path manifest = recorded.folder / "manifest.csv", file = recorded.folder / name;
    std::string rows = files::read_text(manifest);
    const std::string listed = "," + std::to_string(fs::file_size(file)) + "," + name;
    ASSERT_NE(rows.find(listed), rows.npos);
    files::write_text(manifest, rows.replace(rows.find(listed), listed.size(), ",3221225472," + name));
    fs::resize_file(file, 3221225472);
    EXPECT_THAT([&] { read_everything(recorded.folder); },
                ThrowsMessage<files::FileError>(
                    HasSubstr(file.string() + ": has 3221225472 bytes, expected at most")));
  }
}

// Brings the manifest up to date with an edited file, so that only its content can reveal the edit.
void sign_again(const fs::path& folder, const std::string& name) {
  const fs::path manifest = folder / "manifest.csv";
  files::Hash hash;
  hash.add(files::read_text(folder / name));
  std::istringstream lines(files::read_text(manifest));
  std::string signed_again;
  for (std::string line; std::getline(lines, line); signed_again += "\n")
    signed_again +=
        line.ends_with("," + name) ? hash.hex() + "," + std::to_string(hash.bytes()) + "," + name : line;
  files::write_text(manifest, signed_again);
}

// Returns the error of reading a recording after replacing the first `from` in file `name` by `to`, with an
// updated manifest.
std::string complaint(const fs::path& folder, const std::string& name, const std::string& from,
                      const std::string& to) {
  fs::remove_all(folder);
  const Recorded recorded(folder);
  std::string text = files::read_text(folder / name);
  EXPECT_NE(text.find(from), text.npos) << from;
  files::write_text(folder / name, text.replace(text.find(from), from.size(), to));
  sign_again(folder, name);
  try {
    read_everything(folder);
  } catch (const files::FileError& error) {
    const std::string what = error.what(), start = (folder / name).string();
    return what.starts_with(start) ? what.substr(start.size()) : "of another file: " + what;
  }
  return "";
}

TEST(Recording, ErrorsInAFileNameLineAndColumn) {
  const files::TemporaryFolder folder;
  const auto says = [&](const std::string& name, const std::string& from, const std::string& to) {
    return complaint(folder / "r", name, from, to);
  };
  EXPECT_EQ(says("frames.csv", "1000000000033000000", "1000000000033000000"), "");  // as it was
  EXPECT_EQ(says("frames.csv", "#timestamp", "#time"),
            ":1: expected the header \"#timestamp [ns]\", found \"#time [ns]\"");
  EXPECT_EQ(says("frames.csv", "1000000000033000000", "soon"), ":3:1: expected an integer, found \"soon\"");
  EXPECT_EQ(says("frames.csv", "1000000000033000000", "-5"),
            ":3:1: expected a stamp from 0 to 9000000000000000000 ns");
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
              HasSubstr(":3: expected 38 fields, found 39"));
  EXPECT_THAT(says("truth/surfaces.csv", "0.5,1,0.25", "0.5,inf,0.25"),
              HasSubstr("expected a finite number, found \"inf\""));
  EXPECT_THAT(says("mav0/cam0/data.csv", "033000000.png", "034000000.png"), HasSubstr("of another file"));
  EXPECT_EQ(says("mav0/cam0/sensor.yaml", "resolution: [32", "resolution: [0"),
            ":19:13: expected whole numbers from 32 to 8192");
  EXPECT_EQ(says("mav0/cam0/sensor.yaml", "intrinsics: [", "intrinsics: [1, "), ":21:13: expected 4 numbers");
  EXPECT_EQ(says("mav0/cam0/sensor.yaml", "rate_hz", "rate"), ": has no key rate_hz");
  EXPECT_THAT(says("mav0/cam0/sensor.yaml", "resolution: [", "resolution: {"), HasSubstr(":19:"));
  EXPECT_EQ(says("mav0/plan0/sensor.yaml", "0, 0, 0, 1]", "0, 0, 0, 2]"),
            ":6:3: not a pose: expected a rotation and a translation above the row 0 0 0 1");
  EXPECT_EQ(says("mav0/imu0/sensor.yaml", "first_interval_begins_ns: ", "first_interval_began: "),
            ": has no key first_interval_begins_ns");
  EXPECT_THAT(says("mav0/imu0/sensor.yaml", "first_interval_begins_ns: ", "first_interval_begins_ns: 9"),
              HasSubstr("expected an integer"));
  EXPECT_THAT(says("mav0/imu0/sensor.yaml", "first_interval_begins_ns: 9", "first_interval_begins_ns: 19"),
              HasSubstr("of another file"));
  EXPECT_EQ(says("mav0/imu0/sensor.yaml", "rate_hz: 200", "rate_hz: -1e308"),
            ":11:10: rate_hz: expected a number of Hz from 0.001 to 1000000, found \"-1e308\"");
  EXPECT_EQ(says("mav0/cam0/sensor.yaml", "camera_model: pinhole", "rate_hz: 20"),
            ":20:1: rate_hz: given twice, first in line 18, expected once");
  EXPECT_EQ(says("mav0/plan0/sensor.yaml", "rate_hz", "comment"),
            ":4:1: comment: given twice, first in line 3, expected once");
  EXPECT_THAT(says("mav0/imu0/data.csv", "1000000000005000000,-0.", "1000000000005000000,-90000000."),
              testing::EndsWith("rad/s, expected from -10000000 to 10000000 rad/s"));
}

TEST(Recording, TheWriterRejectsWhatIdealSensorsCannotGive) {
  const files::TemporaryFolder folder;
  const auto writing = [&](const std::function<void(std::vector<slam::Observation>&)>& spoil) {
    return [&folder, spoil] {
      fs::remove_all(folder / "r");
      sensor_errors::Random random(1, "test");
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
  EXPECT_THAT(writing([](auto& all) { all[2].plan->legs.emplace(); }),
              ThrowsMessage<std::logic_error>(HasSubstr("leg odometry comes and goes")));
  EXPECT_THAT(writing([](auto& all) { all[2].accelerometer.pop_back(); }),
              ThrowsMessage<std::logic_error>(HasSubstr("number")));
  EXPECT_THAT(writing([](auto& all) { all[2].accelerometer[1].begin += Stamp(1); }),
              ThrowsMessage<std::logic_error>(HasSubstr("differ in time")));
  EXPECT_THAT(writing([](auto& all) { all[1].image = cv::Mat(4, 4, CV_8UC1); }),
              ThrowsMessage<std::logic_error>(HasSubstr("size")));
  EXPECT_THAT(writing([](auto& all) { all[0].t -= Stamp(1); }),
              ThrowsMessage<std::logic_error>(HasSubstr("of its frame")));
}

// Names, sizes and hashes of 2000 images need 200 kB.
TEST(Recording, TheWriterNeedsNoMoreMemoryForALongerRun) {
  const files::TemporaryFolder folder;
  sensor_errors::Random random(1, "test");
  RecordingWriter writer(folder / "r", setup_of(random));
  Stamp t{0};
  const auto write = [&](int frames) {
    for (int k = 0; k < frames; ++k, t += Stamp(33'000'000)) {
      writer.add(slam::Observation{t, random_image({kWidth, kHeight}, random), {}, {}, plan(random)});
      writer.add(TruePoses{t, random_pose(random), random_pose(random), random_pose(random)});
      writer.add(BodyReading{t, random_vector(random), {}, {}});
      writer.add(TrueMotion{t, random_pose(random), random_vector(random)});
      writer.add(TrueFeet{t, {}, {}});
    }
    return mallinfo2().uordblks;  // bytes that the process has asked for and not given back
  };
  const std::size_t early = write(100), late = write(2000);
  EXPECT_LT(late, early + 50'000);
}

TEST(Recording, TheWriterRejectsAFolderThatExists) {
  const files::TemporaryFolder folder;
  sensor_errors::Random random(1, "test");
  EXPECT_THAT([&] { RecordingWriter writer(folder.path(), setup_of(random)); },
              ThrowsMessage<files::FileError>(HasSubstr("exists already")));
}

}  // namespace
}  // namespace sim::recording
