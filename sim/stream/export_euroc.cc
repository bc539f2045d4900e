#include <fmt/format.h>

#include "sim/stream/export_parts.h"
#include "sim/stream/manifest.h"
#include "sim/stream/plan_row.h"
#include "sim/stream/recording_format.h"

namespace sim::stream {
namespace {

using namespace recording_format;

constexpr const char* kEurocReadme =
    R"(Layout of EuRoC/ASL (Burri et al. 2016). `mav0/cam0` and `mav0/imu0` are the sensors,
`mav0/state_groundtruth_estimate0` the true motion of the chest IMU, `times.txt` the images' stamps in ns,
one a line. `mav0/plan0` is an extension: what the walking plan says of the camera at each frame.

GaitSLAM itself reads the folder with `gaitslam replay FOLDER`.
)";

constexpr const char* kOrbReadme =
    R"(For ORB-SLAM3 (v1.0). `settings.yaml` serves its programs without and with the IMU; in their folder:

    ./Examples/Monocular/mono_euroc Vocabulary/ORBvoc.txt FOLDER/settings.yaml FOLDER FOLDER/times.txt run
    ./Examples/Monocular-Inertial/mono_inertial_euroc Vocabulary/ORBvoc.txt FOLDER/settings.yaml FOLDER \
      FOLDER/times.txt run

Its trajectory `f_run.txt` has stamps in ns. `groundtruth.tum` has the true camera poses in s; to compare:

    awk '{$1 = sprintf("%.9f", $1 / 1e9); print}' f_run.txt > run.tum
    evo_ape tum FOLDER/groundtruth.tum run.tum --align --correct_scale
)";

// A file of rows, made with its folder.
HashedFile rows(const Export& out, const std::string& name, const std::string& header) {
  out.write(name, "");
  HashedFile file(out.folder / name);
  if (!header.empty()) file.write(header + "\n");
  return file;
}

void write_imu(HashedFile& imu, const ImuReading& reading, bool& begun) {
  if (!begun) imu.write((reading.accelerometer ? kImuHeader : kGyroHeader) + "\n");
  begun = true;
  imu.write(fmt::format("{},{}{}\n", written(reading.t), csv_fields(reading.gyro),
                        reading.accelerometer ? "," + csv_fields(*reading.accelerometer) : ""));
}

void write_sensors(const Export& out) {
  out.write(kBody, body_yaml());
  out.write(kCameraSensor, camera_yaml(out.setup));
  out.write(kImuSensor, imu_yaml(out.setup, out.noise));
  out.write(kPlanSensor, plan_yaml(out.setup));
  out.write(kMotionSensor, motion_yaml());
  out.write(kMotionRows, Manifest(out.run.result / "recording").read(kMotionRows));
}

}  // namespace

void export_mav0(const Export& out) {
  HashedFile camera = rows(out, kCameraRows, kCameraHeader), imu = rows(out, kImuRows, ""),
             plan = rows(out, kPlanRows, kPlanHeader), times = rows(out, "times.txt", "");
  WholeReadings whole(out.setup.imu_rate_hz);
  bool imu_begun = false;
  for (Seen seen = out.seen(); auto o = seen.next_in_order();) {
    for (const ImuReading& reading : whole.take(*o)) write_imu(imu, reading, imu_begun);
    if (o->plan) plan.write(plan_row(written(o->t), *o->plan));
    if (o->image.empty()) continue;
    const std::string name = fmt::format("{}.png", written(o->t));
    out.write_png(kCameraFolder + name, o->image);
    camera.write(fmt::format("{},{}\n", written(o->t), name));
    times.write(fmt::format("{}\n", written(o->t)));
  }
  for (HashedFile* file : {&camera, &imu, &plan, &times}) file->close();
  write_sensors(out);
}

void export_euroc(const Export& out) {
  export_mav0(out);
  out.write_readme(kEurocReadme);
}

void export_orbslam3(const Export& out) {
  export_mav0(out);
  out.write("settings.yaml", orb_camera(out) + orb_imu(out) + orb_rest());
  out.write("groundtruth.tum", tum_of(out.truth().camera));
  out.write_readme(kOrbReadme);
}

}  // namespace sim::stream
