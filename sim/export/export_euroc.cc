#include "sim/export/export_euroc.h"

#include <fmt/format.h>

#include "sim/export/imu_merger.h"
#include "sim/files/hashed_file.h"
#include "sim/recording/manifest.h"
#include "sim/recording/plan_row.h"
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
  out.write(kMotionSensor, recording::motion_yaml());
  out.write(kMotionRows, recording::Manifest(out.run.result / "recording").read(kMotionRows));
}

}  // namespace

void write_mav0(const ExportContext& out) {
  files::HashedFile camera = rows(out, kCameraRows, kCameraHeader), imu = rows(out, kImuRows, ""),
                    plan = rows(out, kPlanRows, kPlanHeader), times = rows(out, "times.txt", "");
  ImuMerger imu_merger(out.setup.imu_rate_hz);
  bool imu_begun = false;
  for (recording::FilterInput input = out.filter_input(); auto o = input.next_in_order();) {
    for (const ImuReading& reading : imu_merger.merge(*o)) write_imu(imu, reading, imu_begun);
    if (o->plan)
      plan.write(fmt::format("{},{}\n", recording::file_stamp(o->t), recording::plan_fields(*o->plan)));
    if (o->image.empty()) continue;
    const std::string name = fmt::format("{}.png", recording::file_stamp(o->t));
    out.write_png(kCameraFolder + name, o->image);
    camera.write(fmt::format("{},{}\n", recording::file_stamp(o->t), name));
    times.write(fmt::format("{}\n", recording::file_stamp(o->t)));
  }
  for (files::HashedFile* file : {&camera, &imu, &plan, &times}) file->close();
  write_sensors(out);
}

void export_euroc(const ExportContext& out) {
  write_mav0(out);
  out.write_readme(kEurocReadme);
}

}  // namespace sim::exports
