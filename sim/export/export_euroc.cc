#include "sim/export/export_euroc.h"

#include <fmt/format.h>

#include <deque>
#include <optional>
#include <utility>

#include "sim/export/imu_merger.h"
#include "sim/files/hash.h"
#include "sim/recording/manifest.h"
#include "sim/recording/recording_format.h"

namespace sim::exports {
namespace {

using namespace recording::recording_format;

constexpr const char* kEurocReadme =
    R"(Layout of EuRoC/ASL (Burri et al. 2016). `mav0/cam0` and `mav0/imu0` are the sensors,
`mav0/state_groundtruth_estimate0` the true motion of the chest IMU, `times.txt` the images' stamps in ns,
one per line. `mav0/plan0` is an extension: the planned motion of the camera at each frame.

GaitSLAM itself reads the folder with `gaitslam replay FOLDER`.
)";

files::HashedFile rows(const ExportContext& out, const std::string& name, const std::string& header) {
  files::HashedFile file(out.new_file(name));
  if (!header.empty()) file.write(header + "\n");
  return file;
}

void write_imu(files::HashedFile& imu, const ImuReading& reading, bool& begun) {
  if (!begun) imu.write((reading.accelerometer ? kImuHeader : kGyroHeader) + "\n");
  begun = true;
  imu.write(fmt::format("{},{}{}\n", recording::file_stamp(reading.t), files::csv_fields(reading.gyro),
                        reading.accelerometer ? "," + files::csv_fields(*reading.accelerometer) : ""));
}

void write_sensors(const ExportContext& out) {
  out.write(kBody, recording::body_yaml());
  out.write(kCameraSensor, recording::camera_yaml(out.setup));
  out.write(kImuSensor, recording::imu_yaml(out.setup, out.noise));
  out.write(kPlanSensor, recording::plan_yaml(out.setup));
  out.write_truth(kMotionSensor, recording::motion_yaml());
  out.write_truth(kMotionRows, recording::Manifest(out.run.result / "recording").read(kMotionRows));
}

/// Images and their stamps. Programs that look for readings before the first image and after the last one
/// leave their arrays where there are none: images_within_imu leaves such images out.
class ImageWriter {
 public:
  ImageWriter(const ExportContext& out, bool images_within_imu)
      : out_(out),
        within_(images_within_imu),
        camera_(rows(out, kCameraRows, kCameraHeader)),
        times_(rows(out, "times.txt", "")) {}

  void add(const slam::Observation& o) {
    if (o.image.empty() || (within_ && (!first_reading_ || o.t <= *first_reading_))) return;
    waiting_.push_back({o.t, o.image});
    if (!within_) write_until(o.t);
  }
  void note_reading(slam::Stamp t) {
    if (!first_reading_) first_reading_ = t;
    if (within_) write_until(t - slam::Stamp(1));
  }
  void close() {
    camera_.close();
    times_.close();
  }

 private:
  struct Image {
    slam::Stamp t{0};
    cv::Mat image;
  };

  void write_until(slam::Stamp t) {
    for (; !waiting_.empty() && waiting_.front().t <= t; waiting_.pop_front()) {
      const std::string name = fmt::format("{}.png", recording::file_stamp(waiting_.front().t));
      out_.write_png(kCameraFolder + name, waiting_.front().image);
      camera_.write(fmt::format("{},{}\n", recording::file_stamp(waiting_.front().t), name));
      times_.write(fmt::format("{}\n", recording::file_stamp(waiting_.front().t)));
    }
  }

  const ExportContext& out_;
  bool within_;
  files::HashedFile camera_, times_;
  std::optional<slam::Stamp> first_reading_;
  std::deque<Image> waiting_;  // for a reading after them
};

}  // namespace

void write_mav0(const ExportContext& out, bool images_within_imu) {
  files::HashedFile imu = rows(out, kImuRows, ""), plan = rows(out, kPlanRows, "");
  bool plan_begun = false;
  ImageWriter images(out, images_within_imu);
  ImuMerger imu_merger(out.setup.imu_rate_hz);
  bool imu_begun = false;
  for (recording::FilterInput input = out.filter_input(); auto o = out.next(input);) {
    for (const ImuReading& reading : imu_merger.merge(*o)) {
      write_imu(imu, reading, imu_begun);
      images.note_reading(reading.t);
    }
    if (o->plan && !std::exchange(plan_begun, true)) plan.write(recording::plan_header(*o->plan) + "\n");
    if (o->plan)
      plan.write(fmt::format("{},{}\n", recording::file_stamp(o->t), recording::plan_fields(*o->plan)));
    images.add(*o);
  }
  images.close();
  if (!plan_begun) plan.write(kPlanHeader + "\n");
  for (files::HashedFile* file : {&imu, &plan}) file->close();
  write_sensors(out);
}

void export_euroc(const ExportContext& out) {
  write_mav0(out);
  out.write_readme(kEurocReadme);
}

}  // namespace sim::exports
