#include "sim/stream/export.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "sim/stream/export_parts.h"
#include "sim/stream/manifest.h"

namespace sim::stream {
namespace {

namespace fs = std::filesystem;

constexpr double kReading_s = 0.005;     // that the scenario's standard deviations of a reading are meant for
constexpr double kLeastGyroWalk = 1e-6;  // rad/s²/√Hz, m/s³/√Hz: programs divide by these
constexpr double kLeastAccelerometerWalk = 1e-5;

// A mean of white noise over dt has the standard deviation density/√dt.
ImuNoise noise_of(const ErrorOptions& errors) {
  const ErrorOptions::Gyro& gyro = errors.gyro;
  const ErrorOptions::Accelerometer& accelerometer = errors.accelerometer;
  return {std::max(kLeastGyroWalk, gyro.sigma_rad_s * std::sqrt(kReading_s)),
          std::max(kLeastGyroWalk, gyro.bias_walk_sigma_rad_s2),
          std::max(kLeastAccelerometerWalk, accelerometer.sigma_m_s2 * std::sqrt(kReading_s)),
          std::max(kLeastAccelerometerWalk, accelerometer.bias_walk_sigma_m_s3)};
}

void (*exporter(ExportFormat format))(const Export&) {
  constexpr std::array kExporters{export_euroc,    export_tum,      export_kitti, export_mcap,
                                  export_orbslam3, export_openvins, export_kalibr};
  static_assert(kExporters.size() == kExportFormats.size());
  return kExporters.at(static_cast<std::size_t>(format));
}

bool knows_no_lens(ExportFormat format) {
  return format == ExportFormat::tum || format == ExportFormat::kitti;
}

}  // namespace

Export::Export(const ExportedRun& run_, const fs::path& folder_, bool undistort)
    : run(run_),
      folder(folder_),
      setup(RecordingReader(run.result / "recording").setup()),
      noise(noise_of(run.errors)),
      equidistant_(fit_equidistant(camera())) {
  if (undistort) undistorted_.emplace(camera());
  setup.calibration.camera = undistort ? undistorted_->pinhole() : equidistant_.camera;
}

std::vector<TumRow> Export::estimate() const {
  const fs::path file = run.result / "estimate_cov.txt";
  return fs::exists(file) ? read_tum(file) : std::vector<TumRow>{};
}

void Export::write(const std::string& name, std::string_view bytes) const {
  const fs::path file = folder / name;
  fs::create_directories(file.parent_path());
  HashedFile out(file);
  out.write(bytes);
  out.close();
}

void Export::write_png(const std::string& name, const cv::Mat& seen) const {
  const std::vector<unsigned char> bytes = png(image(seen));
  write(name, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

std::string Export::lens_text() const {
  if (undistorted_)
    return fmt::format(
        "The camera's lens is taken out of the images (bilinear): they are those of a pinhole of f = {} px\n"
        "with centre ({}, {}), exactly, and show what every one of their pixels saw.\n",
        camera().fu_px, camera().u0_px, camera().v0_px);
  return fmt::format(
      "The camera's own lens has one radial parameter, which few programs know. It is given as the "
      "equidistant\n"
      "model of Kannala and Brandt (2006), fitted over the whole image: {:.4f} px root mean square, {:.4f} "
      "px at\n"
      "most. Images are as the camera gave them. `gaitslam export ... --undistort` takes the lens out of "
      "the\n"
      "images instead: they are then a pinhole's, exactly.\n",
      equidistant_.rms_px, equidistant_.largest_px);
}

void Export::write_readme(const std::string& text) const {
  write(
      "README.md",
      fmt::format(
          "# {}, seed {}\n\nA walk simulated by GaitSLAM: what its filter saw, sensor noise included.\n\n{}\n"
          "## Conventions\n\nTimes begin at {} s. An IMU reading is the mean over 1/{} s, stamped in the "
          "middle of\n"
          "it; its noise is stated per root hertz: gyro {:.3g} rad/s/sqrt(Hz), accelerometer {:.3g}\n"
          "m/s^2/sqrt(Hz) (white noise of a reading times the square root of its 5 ms). The biases walk by\n"
          "{} rad/s^2/sqrt(Hz) and {} m/s^3/sqrt(Hz); where they do not walk, these are {} and {}, as "
          "programs\n"
          "divide by them. Camera axes: x right, y down, z ahead. World: z up, origin under the start. The "
          "body frame "
          "is\n"
          "the chest IMU; the IMU's stamps are {} s later than the\ncamera's.\n\n{}",
          run.name, run.seed, text, kEpoch.count() / 1'000'000'000, setup.imu_rate_hz, noise.gyro_density,
          noise.accelerometer_density, noise.gyro_walk, noise.accelerometer_walk, kLeastGyroWalk,
          kLeastAccelerometerWalk, run.errors.motion.time_offset_s, lens_text()));
}

std::string written_seconds(slam::Stamp t) {
  return fmt::format("{}.{:09}", written(t) / 1'000'000'000, written(t) % 1'000'000'000);
}

std::string real(double x) {
  const std::string text = fmt::format("{}", x);
  return text.find_first_of(".e") == text.npos ? text + ".0" : text;
}

std::string matrix_text(const Eigen::Isometry3d& X, std::string_view before, std::string_view after,
                        std::string_view apart) {
  std::string text;
  for (int row = 0; row < 4; ++row)
    text += fmt::format("{}{}{}, {}, {}, {}{}", row ? apart : "", before, real(X(row, 0)), real(X(row, 1)),
                        real(X(row, 2)), real(X(row, 3)), after);
  return text;
}

std::string tum_of(const std::vector<TimedPose>& poses) {
  std::string text;
  for (const TimedPose& pose : poses) text += tum_row(kEpoch + pose.t, pose.X);
  return text;
}

std::vector<unsigned char> png(const cv::Mat& image) {
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".png", image, bytes, {cv::IMWRITE_PNG_COMPRESSION, 1}))
    throw std::logic_error("export: an image cannot be encoded");
  return bytes;
}

ToldLens told_lens(const slam::CameraIntrinsics& camera) {
  if (const auto* k = std::get_if<slam::Equidistant>(&camera.lens))
    return {true, {k->k1, k->k2, k->k3, k->k4}};
  return {false, {}};
}

std::string orb_camera(const Export& out) {
  const slam::CameraIntrinsics& camera = out.camera();
  const auto [equidistant, k] = told_lens(camera);
  return fmt::format(
      "%YAML:1.0\nFile.version: \"1.0\"\n\nCamera.type: \"{}\"\nCamera1.fx: {}\nCamera1.fy: {}\n"
      "Camera1.cx: {}\nCamera1.cy: {}\n{}Camera.width: {}\nCamera.height: {}\nCamera.fps: {:.0f}\n"
      "Camera.RGB: 1\n\n",
      equidistant ? "KannalaBrandt8" : "PinHole", real(camera.fu_px), real(camera.fv_px), real(camera.u0_px),
      real(camera.v0_px),
      equidistant ? fmt::format("Camera1.k1: {}\nCamera1.k2: {}\nCamera1.k3: {}\nCamera1.k4: {}\n",
                                real(k[0]), real(k[1]), real(k[2]), real(k[3]))
                  : "",
      camera.width_px, camera.height_px, out.setup.camera_rate_hz);
}

std::string orb_imu(const Export& out) {
  return fmt::format(
      "IMU.T_b_c1: !!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: f\n   data: [{}]\n"
      "IMU.NoiseGyro: {}\nIMU.NoiseAcc: {}\nIMU.GyroWalk: {}\nIMU.AccWalk: {}\nIMU.Frequency: {}\n\n",
      matrix_text(out.setup.calibration.X_CG.inverse(), "", "", ", "), real(out.noise.gyro_density),
      real(out.noise.accelerometer_density), real(out.noise.gyro_walk), real(out.noise.accelerometer_walk),
      real(out.setup.imu_rate_hz));
}

std::string orb_rest() {
  return "ORBextractor.nFeatures: 1000\nORBextractor.scaleFactor: 1.2\nORBextractor.nLevels: 8\n"
         "ORBextractor.iniThFAST: 20\nORBextractor.minThFAST: 7\n\n"
         "Viewer.KeyFrameSize: 0.05\nViewer.KeyFrameLineWidth: 1.0\nViewer.GraphLineWidth: 0.9\n"
         "Viewer.PointSize: 2.0\nViewer.CameraSize: 0.08\nViewer.CameraLineWidth: 3.0\nViewer.ViewpointX: "
         "0.0\n"
         "Viewer.ViewpointY: -0.7\nViewer.ViewpointZ: -3.5\nViewer.ViewpointF: 500.0\n";
}

void export_run(const ExportedRun& run, ExportFormat format, const fs::path& folder, Existing existing) {
  DurableFolder durable(folder, existing);
  exporter(format)(Export(run, durable.path(), run.undistort || knows_no_lens(format)));
  durable.commit();
}

}  // namespace sim::stream
