// The TUM RGB-D layout.

#include "sim/export/export_context.h"
#include "sim/recording/image_file.h"

namespace sim::exports {
namespace {

// Three lines before the first row, because readers skip that many.
std::string header(const char* what, const ExportContext& out, const char* columns) {
  return fmt::format("# {}\n# file: {}, seed {}\n# {}\n", what, out.run.name, out.run.seed, columns);
}

// Pairs each image with the depth image nearest in time, at most half a period apart; none is used twice.
std::string associations(const std::vector<slam::Stamp>& images, const std::vector<slam::Stamp>& depths,
                         double depth_rate_hz) {
  const double most_s = 0.5 / depth_rate_hz;
  const auto apart = [](slam::Stamp a, slam::Stamp b) { return std::abs(slam::seconds(a - b)); };
  std::string text;
  auto depth = depths.begin();
  for (auto image = images.begin(); image != images.end() && depth != depths.end(); ++image) {
    while (depth + 1 != depths.end() && apart(*image, depth[1]) <= apart(*image, *depth)) ++depth;
    const bool next_is_nearer = image + 1 != images.end() && apart(image[1], *depth) < apart(*image, *depth);
    if (next_is_nearer || apart(*image, *depth) > most_s) continue;
    text +=
        fmt::format("{0} rgb/{0}.png {1} depth/{1}.png\n", written_seconds(*image), written_seconds(*depth));
    ++depth;
  }
  return text;
}

// A depth camera and the camera of its images: the first pair with a color camera, otherwise the first
// pair. Without depth: the first color camera, otherwise the head camera.
struct Rgbd {
  explicit Rgbd(const ExportContext& out) : rgb(out.head()) {
    const auto is_color = [&](int camera) { return out.sensor(camera).kind == rig::Kind::color; };
    const std::vector<int> colors = out.all(rig::Kind::color);
    if (!colors.empty()) rgb = colors.front();
    for (const int one : out.all(rig::Kind::depth))
      if (const int image = image_of_depth(out, one); !depth || (!is_color(rgb) && is_color(image)))
        depth = one, rgb = image;
    if (!depth) return;
    const rig::RigSensor &from = out.sensor(*depth), &to = out.sensor(rgb);
    if (from.aligned_with != to.name)
      registration.emplace(from.camera, to.camera, to.X_CS.inverse() * from.X_CS);
    if (!is_color(rgb) && !colors.empty())
      out.run.warn(fmt::format("no color camera shares the view of {}: rgb/ has the images of {}", from.name,
                               to.name));
  }

  cv::Mat registered(const cv::Mat& image) const { return registration ? (*registration)(image) : image; }

  int rgb;
  std::optional<int> depth;
  std::optional<DepthRegistration> registration;
};

}  // namespace

void export_tum(const ExportContext& out) {
  const Rgbd cameras(out);
  const Eigen::Isometry3d& X_CS = out.sensor(cameras.rgb).X_CS;
  const char* poses = "timestamp tx ty tz qx qy qz qw";
  std::string images = header("color images", out, "timestamp filename"),
              depths = header("depth maps, 1000 per m", out, "timestamp filename"),
              accelerations = header("accelerometer data, chest IMU", out, "timestamp ax ay az"),
              plan = header("planned camera poses", out, poses);
  std::vector<slam::Stamp> with_image, with_depth;
  double measured = 0;  // fractions of images with depth
  const auto add = [&](const char* folder, slam::Stamp t, const cv::Mat& image, std::string& list,
                       std::vector<slam::Stamp>& stamps) {
    const std::string name = fmt::format("{}/{}.png", folder, written_seconds(t));
    list += fmt::format("{} {}\n", written_seconds(t), name);
    stamps.push_back(t);
    out.write(name, recording::encode_png(image));
  };
  for (Frames frames(out); const auto frame = frames.next();) {
    if (const auto& planned = frame->motion.plan)
      plan += files::tum_row(recording::kEpoch + frame->t, planned->X_PC * X_CS);
    for (const ExportedReading& reading : frame->readings)
      if (const auto& a = reading.accelerometer; reading.sensor == out.chest() && reading.has_acceleration)
        accelerations += fmt::format("{} {} {} {}\n", written_seconds(reading.t), a.x(), a.y(), a.z());
      else if (reading.sensor == cameras.rgb)
        add("rgb", reading.t, reading.image, images, with_image);
      else if (reading.sensor == cameras.depth) {
        const cv::Mat depth = cameras.registered(reading.image);
        measured += double(cv::countNonZero(depth)) / double(depth.total());
        add("depth", reading.t, depth, depths, with_depth);
      }
  }
  out.write("rgb.txt", images);
  if (cameras.depth) {
    out.write("depth.txt", depths);
    const std::string pairs = associations(with_image, with_depth, out.sensor(*cameras.depth).rate_hz);
    out.write("associations.txt", pairs);
    if (measured == 0)
      out.run.warn("depth/ has no depth at any pixel: nothing is within the depth camera's range and view");
    if (pairs.empty())
      out.run.warn("associations.txt is empty: no image and depth image were taken at the same time");
  }
  out.write("accelerometer.txt", accelerations);
  out.write("plan.txt", plan);
  const auto of_camera = [&](std::vector<files::TimedPose> all) {
    for (files::TimedPose& pose : all) pose.X = pose.X * X_CS;
    return tum_text(all);
  };
  out.write_truth("groundtruth.txt",
                  header("ground truth trajectory", out, poses) + of_camera(out.truth().camera));
  if (const auto rows = out.estimate(); !rows.empty())
    out.write("estimate.txt",
              header("estimated trajectory", out, poses) + of_camera({rows.begin(), rows.end()}));
  out.write("settings.yaml", orbslam3_settings(out, cameras.rgb, cameras.depth, false));
  std::string of_depth;
  if (cameras.depth)
    of_depth = filled_text(
        "tum_depth.md", out.sensor(*cameras.depth).name,
        cameras.registration ? "registered to the images of `rgb/`" : "measured at the pixels of `rgb/`",
        100 * measured / std::max<double>(1, double(with_depth.size())));
  out.write_readme({"tum.md"}, {cameras.rgb}, of_depth);
}

}  // namespace sim::exports
