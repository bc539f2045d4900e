// The EuRoC/ASL layout.
#include <iterator>

#include "sim/export/export_context.h"
#include "sim/recording/image_file.h"

namespace sim::exports {
namespace {

using namespace recording::recording_format;

files::HashedFile rows(const ExportContext& out, const std::string& name, const std::string& header) {
  files::HashedFile file(out.new_file(name));
  if (!header.empty()) file.write(header + "\n");
  return file;
}

std::string folder_of(const char* kind, std::size_t number) {
  return fmt::format("mav0/{}{}/", kind, number);
}

/// Images of a camera and their stamps. Some programs read beyond their arrays if there is no IMU reading
/// before and after an image; images_within_imu skips such images.
class ImageWriter {
 public:
  ImageWriter(const ExportContext& out, bool images_within_imu, const std::string& folder)
      : out_(out),
        within_(images_within_imu),
        folder_(folder),
        camera_(rows(out, folder + "data.csv", kCameraHeader)) {}

  void add(const ExportedReading& image) {
    if (within_ && (!first_reading_ || image.t <= *first_reading_)) return;
    waiting_.push_back({image.t, image.image});
    if (!within_) write_until(image.t);
  }
  void note_reading(slam::Stamp t) {
    if (!first_reading_) first_reading_ = t;
    if (within_) write_until(t - slam::Stamp(1));
  }
  /// Returns the stamps of the images.
  std::vector<std::int64_t> close() {
    camera_.close();
    return std::move(times_);
  }

 private:
  void write_until(slam::Stamp t) {
    for (; !waiting_.empty() && waiting_.front().first <= t; waiting_.pop_front()) {
      const std::int64_t stamp = recording::file_stamp(waiting_.front().first);
      const std::string name = fmt::format("{}.png", stamp);
      out_.write(folder_ + "data/" + name, recording::encode_png(waiting_.front().second));
      camera_.write(fmt::format("{},{}\n", stamp, name));
      times_.push_back(stamp);
    }
  }

  const ExportContext& out_;
  bool within_;
  const std::string folder_;
  files::HashedFile camera_;
  std::vector<std::int64_t> times_;
  std::optional<slam::Stamp> first_reading_;
  std::deque<std::pair<slam::Stamp, cv::Mat>> waiting_;  // waiting for a later reading
};

std::string lines(const std::vector<std::int64_t>& stamps) {
  return fmt::format("{}{}", fmt::join(stamps, "\n"), stamps.empty() ? "" : "\n");
}

}  // namespace

WalkMotion write_mav0(const ExportContext& out, bool images_within_imu) {
  constexpr double kStanding_m_s = 0.02;
  WalkMotion motion;
  std::optional<std::pair<slam::Stamp, Eigen::Vector3d>> planned;
  std::array<std::optional<files::HashedFile>, 3> sources;  // in the order of motion_sources()
  const std::vector<int> eyes = out.all(rig::Kind::gray), imus = out.all(rig::Kind::imu);
  std::map<int, ImageWriter> images;  // by sensor
  for (std::size_t i = 0; i < eyes.size(); ++i)
    images.emplace(eyes[i], ImageWriter(out, images_within_imu, folder_of("cam", i)));
  std::map<int, files::HashedFile> readings;
  for (std::size_t i = 0; i < imus.size(); ++i)
    readings.emplace(imus[i], rows(out, folder_of("imu", i) + "data.csv", kImuHeader));
  for (Frames frames(out); const auto frame = frames.next();) {
    for (const ExportedReading& reading : frame->readings)
      if (const auto eye = images.find(reading.sensor); eye != images.end()) {
        eye->second.add(reading);
      } else if (const auto imu = readings.find(reading.sensor); imu != readings.end()) {
        if (!reading.has_acceleration) continue;
        imu->second.write(fmt::format("{},{},{}\n", recording::file_stamp(reading.t),
                                      files::csv_fields(reading.gyro),
                                      files::csv_fields(reading.accelerometer)));
        if (reading.sensor != out.chest()) continue;
        motion.turns_rad_s.push_back(reading.gyro.norm());
        for (auto& [sensor, writer] : images) writer.note_reading(reading.t);
      }
    for (std::size_t i = 0; i < sources.size(); ++i) {
      const recording::MotionSource& source = recording::motion_sources()[i];
      if (!source.in(frame->motion)) continue;
      if (!sources[i]) sources[i].emplace(rows(out, sensor_rows(source.name), source.header));
      sources[i]->write(
          fmt::format("{},{}\n", recording::file_stamp(frame->t), source.fields(frame->motion)));
    }
    const auto& plan = frame->motion.plan;
    const auto& legs = frame->motion.legs;
    if (!plan && !legs) continue;
    const std::pair now(frame->t, Eigen::Vector3d((plan ? plan->X_PC : legs->X_OC).translation()));
    if (planned && planned->first < now.first)
      if (const double speed =
              (now.second - planned->second).norm() / slam::seconds(now.first - planned->first);
          speed > kStanding_m_s)
        motion.speeds_m_s.push_back(speed);
    planned = now;
  }
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const recording::MotionSource& source = recording::motion_sources()[i];
    if (sources[i] || i == 0)
      out.write(sensor_file(source.name), recording::motion_source_yaml(source, out.setup));
    if (sources[i]) sources[i]->close();
  }
  std::vector<std::vector<std::int64_t>> times;
  for (std::size_t i = 0; i < eyes.size(); ++i) {
    const rig::RigSensor& eye = out.sensor(eyes[i]);
    times.push_back(images.at(eyes[i]).close());
    out.write(
        folder_of("cam", i) + "sensor.yaml",
        recording::camera_yaml({eye.camera, eye.X_CS.inverse() * out.setup.calibration.X_CG}, eye.rate_hz));
  }
  out.write("times.txt", lines(times[0]));
  if (std::vector<std::int64_t> both; times.size() > 1) {
    std::ranges::set_intersection(times[0], times[1], std::back_inserter(both));
    out.write("times_stereo.txt", lines(both));
    if (both.empty())
      out.run.warn("cam0 and cam1 have no images with the same stamp: times_stereo.txt is empty");
  }
  for (std::size_t i = 0; i < imus.size(); ++i) {
    const rig::RigSensor& imu = out.sensor(imus[i]);
    readings.at(imus[i]).close();
    out.write(
        folder_of("imu", i) + "sensor.yaml",
        recording::imu_yaml(imu.name + "; +g up at rest", out.X_GS(imus[i]), imu.rate_hz, noise_of(imu)));
  }
  out.write(kBody, recording::body_yaml());
  out.write_truth(sensor_file(kMotion), recording::motion_yaml());
  if (out.run.with_truth) out.write(sensor_rows(kMotion), out.motion());
  return motion;
}

void export_euroc(const ExportContext& out) {
  write_mav0(out);
  out.write_readme({"euroc.md"}, out.all(rig::Kind::gray));
}

}  // namespace sim::exports
