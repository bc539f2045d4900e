#include "sim/recording/recording.h"

#include <sys/stat.h>

#include "sim/recording/image_file.h"
#include "sim/recording/manifest.h"
#include "tests/sim/recording/random_readings.h"

namespace sim::recording {
namespace {

using slam::Stamp, testing::HasSubstr;
using tests::encoded, tests::expect_same, tests::random_image, tests::random_pose, tests::random_vector;

constexpr int kWidth = 32, kHeight = 40;
const cv::Size kSize{kWidth, kHeight};

// One sensor of each kind, with generic numbers.
std::vector<rig::RigSensor> rig_of(std::uint64_t seed) {
  sensor_errors::Random random(seed, "rig");
  std::vector<rig::RigSensor> all = tests::rig_of(random, kSize);
  rig::RigSensor &gray = all[0], &color = all[1], &depth = all[2], &lidar = all[3], &imu = all[4];
  for (rig::RigSensor& s : all) s.time_offset_s = random.normal();
  gray.camera.lens = slam::RadialTangential{0.01, 0.02, 0.003, random.uniform() / 99};
  for (rig::RigSensor* s : {&gray, &color})
    s->readout_s = random.uniform(), s->read_sigma_gray = random.uniform(),
    s->shot_sigma_gray = random.uniform();
  for (rig::RigSensor* s : {&depth, &lidar})
    s->nearest_m = random.uniform(), s->furthest_m = 1 + random.uniform();
  depth.edge_px = 2, depth.baseline_m = random.uniform(), depth.disparity_sigma_px = random.uniform();
  depth.window_px = 1 + random.uniform();
  lidar.lowest_rad = -random.uniform(), lidar.highest_rad = random.uniform();
  lidar.range_sigma_m = random.uniform(), lidar.angle_sigma_rad = random.uniform();
  imu.gyro_sigma_rad_s = random.uniform(), imu.accelerometer_sigma_m_s2 = random.uniform();
  imu.gyro_bias_sigma_rad_s = random.uniform(), imu.accelerometer_bias_sigma_m_s2 = random.uniform();
  return all;
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

std::vector<slam::Observation> observations(sensor_errors::Random& random, int count, bool legs = false) {
  return tests::observations(random, count, kSize, Stamp{-2'000'000}, legs);
}

void add_rig(std::vector<slam::Observation>& all, std::uint64_t seed) {
  sensor_errors::Random random(seed, "rig readings");
  tests::add_rig(all, random, kSize, seed > 1);
}

// A finished recording of a few frames with truth and one surface.
struct Recorded {
  explicit Recorded(const fs::path& folder_, std::uint64_t seed = 1, bool legs = true) : folder(folder_) {
    sensor_errors::Random random(seed, "test");
    setup = setup_of(random);
    setup.rig = rig_of(seed);
    given = observations(random, 12, legs);
    add_rig(given, seed);
    RecordingWriter writer(folder, setup);
    for (slam::Observation& o : given) {
      if (!bodies.empty()) o.body = {bodies.back()};  // from the frame before
      writer.add(o);
      poses.push_back(
          {o.t, random_pose(random), random_pose(random), random_pose(random), random_pose(random)});
      writer.add(poses.back());
      const auto wrench = [&] { return BodyReading::Wrench{random_vector(random), random_vector(random)}; };
      bodies.push_back({o.t, random_vector(random), wrench(), wrench()});
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

TEST(Recording, ObservationsAreReadBackBitForBit) {
  const files::TemporaryFolder folder;
  for (const bool legs : {true, false})
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const Recorded recorded(folder / (std::to_string(seed) + (legs ? "a" : "b")), seed, legs);
      const std::vector<slam::Observation> read = read_all(recorded.folder);
      ASSERT_EQ(read.size(), recorded.given.size());
      for (std::size_t i = 0; i < read.size(); ++i) expect_same(read[i], recorded.given[i]);
    }
}

TEST(Recording, CalibrationRigAndStartAreReadBackBitForBit) {
  const files::TemporaryFolder folder;
  const Recorded recorded(folder / "r");
  RecordingReader reader(recorded.folder);
  const RecordingSetup &read = reader.setup(), &given = recorded.setup;
  EXPECT_EQ(read.X_WC_start.matrix(), given.X_WC_start.matrix());
  EXPECT_TRUE(read.calibration.level_floor);
  RecordingWriter(folder / "again", read).finish();  // numbers round-trip, and each is generic
  for (const char* sensor : {"cam0", "cam1", "rgb0", "depth0", "lidar0", "imu0", "imu1"}) {
    const auto stated = [&](const char* in) {
      const std::string text = files::read_text(folder / in / "mav0" / sensor / "sensor.yaml");
      return text.substr(0, text.find("first_interval"));  // of the readings
    };
    EXPECT_EQ(stated("again"), stated("r")) << sensor;
  }
  double before = reader.part();
  EXPECT_LT(before, 0.5);
  for (; reader.next(); before = reader.part()) EXPECT_GE(reader.part(), before);
  EXPECT_EQ(reader.part(), 1);
}

TEST(Recording, ImagesOfTheRigThatAreAlreadyEncodedAreWrittenUnchanged) {
  const files::TemporaryFolder folder;
  const Recorded recorded(folder / "r");
  RecordingWriter writer(folder / "s", recorded.setup);
  const slam::Observation& o = recorded.given[0];
  writer.add(o, "", {"given", ""});
  const std::string stamp = std::to_string(file_stamp(o.rig[0].t)),
                    next = std::to_string(file_stamp(o.rig[1].t));
  EXPECT_EQ(files::read_text(folder / "s/mav0/cam1/data" / (stamp + ".png")), "given");
  EXPECT_EQ(files::read_text(folder / "s/mav0/cam1/data" / (next + ".png")),
            files::read_text(folder / "r/mav0/cam1/data" / (next + ".png")));
}

TEST(Recording, TruthIsReadBackBitForBit) {
  const files::TemporaryFolder folder;
  const Recorded recorded(folder / "r");
  const Truth truth = read_truth(recorded.folder);
  for (std::size_t i = 0; i < recorded.poses.size(); ++i) {
    EXPECT_EQ(truth.camera.at(i).t, recorded.poses[i].t);
    EXPECT_EQ(truth.camera[i].X.matrix(), recorded.poses[i].X_WC.matrix());
    EXPECT_EQ(truth.waist.at(i).X.matrix(), recorded.poses[i].X_WB.matrix());
    EXPECT_EQ(truth.waist_plan.at(i).X.matrix(), recorded.poses[i].X_PB.value().matrix());
    EXPECT_EQ(truth.waist_desired.at(i).X.matrix(), recorded.poses[i].X_WB_desired->matrix());
  }
  ASSERT_EQ(truth.surfaces.size(), 1u);
  EXPECT_EQ(truth.surfaces[0].kind, score::Surface::Kind::box);
  EXPECT_EQ(truth.surfaces[0].X_WS.matrix(), recorded.surface.X_WS.matrix());
  EXPECT_EQ(truth.surfaces[0].size, recorded.surface.size);
}

TEST(Recording, HasTheLayoutThatOtherReadersExpect) {
  const files::TemporaryFolder folder;
  const Recorded recorded(folder / "r");
  const std::string camera = files::read_text(recorded.folder / "mav0/cam0/data.csv");
  EXPECT_EQ(camera.substr(0, camera.find("\n1000000000033")),
            "#timestamp [ns],filename\n1000000000000000000,1000000000000000000.png");
  const fs::path second = recorded.folder / "mav0/cam0/data/1000000000033000000.png";
  EXPECT_EQ(cv::norm(cv::imread(second, cv::IMREAD_UNCHANGED), recorded.given[1].image, cv::NORM_INF), 0);
  EXPECT_THAT(
      files::read_text(recorded.folder / "mav0/imu0/data.csv"),
      testing::StartsWith("#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
                          "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n1000000000000000000,"));
  files::CsvReader motion(recorded.folder / "mav0/state_groundtruth_estimate0/data.csv");
  EXPECT_EQ(motion.titles().size(), 17u);
  EXPECT_TRUE(motion.next());
  cv::FileStorage sensor((recorded.folder / "mav0/cam0/sensor.yaml").string(), cv::FileStorage::READ);
  EXPECT_EQ(int(sensor["resolution"][0]), kWidth);
  const Eigen::Matrix4d expected = recorded.setup.calibration.X_CG.inverse().matrix();
  for (int i = 0; i < 16; ++i)  // T_BS of body G is X_GC
    EXPECT_EQ(double(sensor["T_BS"]["data"][i]), expected(i / 4, i % 4));
}

std::vector<fs::path> files_of(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && entry.path().filename() != "manifest.csv") files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

// Reads observations, then truth, as a replay does.
void read_everything(const fs::path& folder) {
  read_all(folder);
  read_truth(folder);
}

// Expects that each file of a recording is reported with these words after `spoil` changed it on disk.
void expect_named(const std::function<void(const fs::path& file, const std::string& bytes)>& spoil,
                  const std::string& words, bool with_manifest = false) {
  const files::TemporaryFolder folder;
  const Recorded recorded(folder / "r");
  std::vector<fs::path> all = files_of(recorded.folder);
  if (with_manifest) all.push_back(recorded.folder / "manifest.csv");
  for (const fs::path& file : all) {
    const std::string bytes = files::read_text(file);
    spoil(file, bytes);
    EXPECT_THAT(files::error_of([&] { read_everything(recorded.folder); }), HasSubstr(file.string() + words));
    fs::remove(file);
    files::write_text(file, bytes);
  }
  EXPECT_NO_THROW(read_everything(recorded.folder));
}

TEST(Recording, AnyMissingTruncatedOrEditedFileIsReported) {
  sensor_errors::Random random(9, "damage");
  expect_named([](const fs::path& file, const std::string&) { fs::remove(file); }, ": is missing", true);
  const auto pipe = [](const fs::path& file, const std::string&) {
    fs::remove(file);
    ASSERT_EQ(mkfifo(file.c_str(), 0600), 0);
  };
  expect_named(pipe, ": is not a regular file", true);
  const auto cut = [&](const fs::path& file, const std::string& bytes) {
    fs::resize_file(file, random.bits() % bytes.size());
  };
  expect_named(cut, ": truncated");
  const auto edit = [&](const fs::path& file, std::string bytes) {
    bytes[random.bits() % bytes.size()] ^= char(1 << random.bits() % 8);
    files::write_text(file, bytes);
  };
  for (int trial = 0; trial < 5; ++trial) expect_named(edit, ": edited");
}

TEST(Recording, UnwantedReadingsAreLeftOutButTheirFilesAreChecked) {
  const files::TemporaryFolder folder;
  const Recorded recorded(folder / "r");
  const auto read_wanted = [&] {
    std::vector<slam::Observation> all;
    RecordingReader reader(recorded.folder);
    while (auto observation = reader.next([](int sensor) { return sensor == 2; }))
      all.push_back(*observation);
    return all;
  };
  std::vector<slam::Observation> expected = recorded.given;
  for (slam::Observation& o : expected)
    std::erase_if(o.rig, [](const auto& reading) { return reading.sensor != 2 && reading.sensor != 4; });
  const std::vector<slam::Observation> read = read_wanted();
  ASSERT_EQ(read.size(), expected.size());
  for (std::size_t i = 0; i < read.size(); ++i) expect_same(read[i], expected[i]);
  const fs::path unwanted = fs::directory_iterator(recorded.folder / "mav0/lidar0/data")->path();
  std::string bytes = files::read_text(unwanted);
  bytes.back() ^= 1;
  files::write_text(unwanted, bytes);
  EXPECT_THAT(files::error_of(read_wanted), HasSubstr(unwanted.string() + ": edited"));
}

// Returns the error of reading a recording after replacing the first `from` in file `name` with `to`. The
// manifest is brought up to date, so that only the content can reveal the edit.
std::string complaint(const fs::path& folder, const std::string& name, const std::string& from,
                      const std::string& to) {
  fs::remove_all(folder);
  const Recorded recorded(folder);
  std::string text = files::read_text(folder / name), manifest = files::read_text(folder / "manifest.csv");
  const auto row = [&] {
    files::Hash hash;
    hash.add(text);
    return fmt::format("{},{},{}", hash.hex(), text.size(), name);
  };
  const std::string before = row();
  EXPECT_NE(text.find(from), text.npos) << from;
  files::write_text(folder / name, text.replace(text.find(from), from.size(), to));
  files::write_text(folder / "manifest.csv", manifest.replace(manifest.find(before), before.size(), row()));
  const std::string error = files::error_of([&] { read_everything(folder); });
  const std::string start = error.empty() ? "" : (folder / name).string();
  return error.starts_with(start) ? error.substr(start.size()) : "of another file: " + error;
}

TEST(Recording, ErrorsInAFileNameLineAndColumn) {
  const files::TemporaryFolder folder;
  EXPECT_EQ(complaint(folder / "r", "frames.csv", "1000000000033000000", "1000000000033000000"), "");
  const std::string sweep = "mav0/lidar0/data/999999999999999990.bin";
  EXPECT_EQ(complaint(folder / "r", sweep, "", std::string(20, '\xff')),
            ": point 0 (counting from 0): expected finite numbers");
  for (const auto& [name, from, to, words] : tests::bad_files("recordings")) {
    const std::string error = complaint(folder / "r", name, from, to);
    EXPECT_THAT(error, HasSubstr(words));
    EXPECT_TRUE(words[0] != ':' || error.starts_with(words)) << error;
  }
}

TEST(Recording, TheWriterRejectsReadingsThatIdealSensorsCannotGive) {
  using Spoil = void (*)(std::vector<slam::Observation>&);
  for (const auto& [spoil, words] : std::vector<std::pair<Spoil, const char*>>{
           {[](auto& all) { all[2].t = all[1].t; }, "frame"},
           {[](auto& all) { all[1].gyro.pop_back(), all[1].accelerometer.pop_back(); }, "contiguous"},
           {[](auto& all) { all[2].accelerometer.clear(); }, "counts differ"},
           {[](auto& all) { all[1].image = cv::Mat(4, 4, CV_8UC1); }, "size"},
           {[](auto& all) { std::swap(all[1].rig[0], all[1].rig[2]); }, "order of its sensors"},
           {[](auto& all) { std::swap(all[1].rig[0], all[1].rig[1]); }, "cam1/data.csv do not increase"},
           {[](auto& all) { all[1].rig[0].image = all[1].rig[2].image; }, "8-bit gray"},
           {[](auto& all) { all[1].rig.back().t = all[1].t + Stamp(1); }, "within its frame's time"}}) {
    const files::TemporaryFolder folder;
    sensor_errors::Random random(1, "test");
    RecordingSetup setup = setup_of(random);
    setup.rig = rig_of(1);
    RecordingWriter writer(folder / "r", setup);
    std::vector<slam::Observation> all = observations(random, 4);
    add_rig(all, 1);
    spoil(all);
    const auto add_all = [&] { std::ranges::for_each(all, [&](const auto& o) { writer.add(o); }); };
    EXPECT_THAT(files::error_of<std::logic_error>(add_all), HasSubstr(words));
  }
}

TEST(Recording, TorqueLimitsAreReadBackAndAbsentForARobotWithoutThem) {
  const files::TemporaryFolder folder;
  sensor_errors::Random random(1, "test");
  const std::vector<std::vector<std::optional<bool>>> robots{{true, false, true}, {{}, {}, {}}};
  for (std::size_t robot = 0; robot < robots.size(); ++robot) {
    const fs::path made = folder / std::to_string(robot);
    RecordingWriter writer(made, setup_of(random));
    for (std::size_t i = 0; i < robots[robot].size(); ++i)
      writer.add(TrueFeet{Stamp(std::int64_t(i)), {}, {}, robots[robot][i]});
    writer.finish();
    std::vector<std::optional<bool>> read;
    for (const TrueFeet& feet : read_truth(made).feet) read.push_back(feet.torque_limited);
    EXPECT_EQ(read, robots[robot]);
  }
}

TEST(Recording, AnExistingFolderIsNotOverwrittenAndAnUnfinishedOneIsNotRead) {
  const files::TemporaryFolder folder;
  sensor_errors::Random random(1, "test");
  const RecordingWriter unfinished(folder / "r", setup_of(random));
  EXPECT_THAT(files::error_of([&] { RecordingWriter writer(folder / "r", setup_of(random)); }),
              HasSubstr("already exists"));
  EXPECT_THAT(files::error_of([&] { RecordingReader reader(folder / "r"); }), HasSubstr("an unfinished one"));
  EXPECT_THAT(files::error_of([&] { RecordingReader reader(folder / "none"); }),
              HasSubstr("none: no such folder"));
}

TEST(Manifest, HashIsXxh3Of128Bits) {
  // Values published with the algorithm (empty input, seed 0), and printed by `printf gaitslam | xxh128sum`.
  EXPECT_EQ(files::Hash().hex(), "99aa06d3014798d86001c324468d497f");
  files::Hash whole, pieces;
  whole.add("gaitslam");
  for (const char* piece : {"ga", "", "it", "slam"}) pieces.add(piece);
  EXPECT_EQ(pieces.hex(), whole.hex());
  EXPECT_EQ(pieces.bytes(), 8u);
}

TEST(Manifest, FilesOutsideTheFolderAreRejected) {
  const files::TemporaryFolder folder;
  const fs::path recording = folder / "recording";
  fs::create_directories(recording);
  files::write_text(folder / "outside.txt", "content");
  fs::create_symlink(folder / "outside.txt", recording / "link.txt");
  files::Hash hash;
  hash.add("content");
  for (const std::string& path :
       {std::string("../outside.txt"), (folder / "outside.txt").string(), std::string("link.txt")}) {
    ManifestWriter writer(recording);
    writer.add(path, hash);
    writer.finish();
    EXPECT_THAT(files::error_of([&] { Manifest(recording).read(path); }),
                HasSubstr("leads outside the folder"))
        << path;
  }
}

TEST(HashedFile, AFullDiskIsAnError) {
  files::HashedFile full("/dev/full");
  EXPECT_THAT(files::error_of([&] {
                full.write("x");
                full.close();
              }),
              HasSubstr("/dev/full: cannot be written: No space left on device"));
}

const cv::Mat kGray(35, 48, CV_8UC1, cv::Scalar(99));

// OpenCV rotates images according to the orientation in their metadata, which does not belong to calibration
// and IMU.
TEST(DecodeImage, PixelsAreReadAsStoredWhateverTheirOrientation) {
  const std::string exif(
      "\xff\xe1\0\x22"
      "Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0",
      36);
  cv::Mat image = kGray.clone();
  image(cv::Rect(0, 0, 16, 16)) = 220;
  const std::string bytes = encoded(".jpg", image).insert(2, exif);
  const cv::Mat turned =
      cv::imdecode(std::vector<unsigned char>(bytes.begin(), bytes.end()), cv::IMREAD_GRAYSCALE);
  EXPECT_EQ(turned.size(), cv::Size(35, 48)) << "the orientation is there";
  EXPECT_LT(cv::norm(decode_image("a", bytes, {48, 35}), image, cv::NORM_INF), 10);
}

TEST(DecodeImage, BytesThatAreNoImageAreRejected) {
  for (const std::string& bytes :
       {std::string("no image"), encoded(".png", kGray).substr(0, 60), encoded(".jpg", kGray).substr(0, 20),
        encoded(".bmp", kGray), encoded(".pgm", kGray)})
    EXPECT_THROW(decode_image("a", bytes, {48, 35}), files::FileError);
}

cv::Mat decoded_by_opencv(const std::string& png) {
  const cv::Mat bytes(1, int(png.size()), CV_8UC1, const_cast<char*>(png.data()));
  cv::Mat image = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
  if (image.channels() == 3) cv::mixChannels({image.clone()}, {image}, {0, 2, 1, 1, 2, 0});  // it is BGR
  return image;
}

TEST(Png, ImagesAndPartsOfThemAreReadBackHereAndByOpenCv) {
  sensor_errors::Random random(1, "picture");
  for (const int type : {CV_8UC1, CV_8UC3, CV_16UC1})
    for (const cv::Size size : {cv::Size(320, 240), cv::Size(1, 1), cv::Size(7, 300), cv::Size(641, 3)}) {
      const cv::Mat whole = tests::random_image(size, random, type);
      for (const cv::Mat& image : {whole, whole(cv::Rect(size.width / 2, 0, 1, size.height))}) {
        const std::string png = encode_png(image);
        expect_same(decode_png(png, type).value(), image);
        EXPECT_FALSE(decode_png(png, type == CV_8UC1 ? CV_8UC3 : CV_8UC1));
        expect_same(decoded_by_opencv(png), image);
      }
    }
}

TEST(GrayPng, RefusesOtherPicturesAndDamagedOnes) {
  sensor_errors::Random random(1, "picture");
  const cv::Mat image = tests::random_image({32, 20}, random);
  for (const cv::Mat& other :
       {image, cv::Mat(4, 4, CV_16UC1, cv::Scalar(7)), cv::Mat(4, 4, CV_8UC3, cv::Scalar(7))})
    if (const auto decoded = decode_png(encoded(".png", other), CV_8UC1)) expect_same(*decoded, other);
  const std::string whole = encode_png(image);
  for (std::size_t n = 0; n < whole.size(); n += 7)
    EXPECT_FALSE(decode_png(whole.substr(0, n), CV_8UC1)) << n;
  for (std::size_t at = 0; at < whole.size(); at += 5) {
    std::string damaged = whole;
    damaged[at] = char(damaged[at] ^ 0x55);
    if (const auto decoded = decode_png(damaged, CV_8UC1)) expect_same(*decoded, image);
  }
}

}  // namespace
}  // namespace sim::recording
