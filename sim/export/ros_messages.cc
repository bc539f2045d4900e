#include "sim/export/ros_messages.h"

#include <set>

namespace sim::exports {
namespace ros {
namespace {

// The type of this name from the text ros2.msg: its definition, followed by the definitions of the types it
// uses, each once.
MessageType type(const std::string& package, const std::string& name) {
  static const std::string all = text_of("ros2.msg");
  const auto find = [](const std::string& title) -> std::string {
    const std::size_t at = all.find("MSG: " + title + "\n");
    return at == all.npos ? "" : all.substr(at, all.find("MSG: ", at + 1) - at);
  };
  const std::string own = find(package + "/" + name);
  std::string definition = own.substr(own.find('\n') + 1);
  std::set<std::string> known;
  for (std::size_t at = 0; at < definition.size(); at = definition.find('\n', at) + 1) {
    const std::string used = definition.substr(at, definition.find_first_of("[ \n", at) - at);
    if (const std::string part = find(used); !part.empty() && known.insert(used).second)
      definition += std::string(80, '=') + "\n" + part;
  }
  return {package + "/msg/" + name, definition};
}

// Common Data Representation: little-endian numbers aligned to their size, after four bytes for the encoding.
class Cdr {
 public:
  template <typename Number>
  Cdr& number(Number x) {
    bytes_.resize(4 + (bytes_.size() - 4 + sizeof(Number) - 1) / sizeof(Number) * sizeof(Number));
    bytes_.append(reinterpret_cast<const char*>(&x), sizeof x);  // this machine is little-endian
    return *this;
  }
  Cdr& text(const std::string& t) {
    number(std::uint32_t(t.size() + 1)).bytes_.append(t.c_str(), t.size() + 1);
    return *this;
  }
  Cdr& raw(const unsigned char* data, std::size_t size) {
    number(std::uint32_t(size)).bytes_.append(reinterpret_cast<const char*>(data), size);
    return *this;
  }
  template <typename List>
  Cdr& numbers(const List& list) {
    for (const double x : list) number(x);
    return *this;
  }
  Cdr& header(slam::Stamp t, const std::string& frame) {
    const std::int64_t ns = recording::file_stamp(t);
    return number(std::int32_t(ns / 1'000'000'000)).number(std::uint32_t(ns % 1'000'000'000)).text(frame);
  }
  Cdr& pose(const Eigen::Isometry3d& X) {
    Eigen::Quaterniond q(X.linear());
    q.normalize();
    return numbers(Eigen::Vector3d(X.translation())).numbers(q.coeffs());  // x, y, z, w
  }
  std::string bytes() { return std::move(bytes_); }

 private:
  std::string bytes_ = std::string("\0\1\0\0", 4);
};

std::array<double, 9> diagonal(double x) { return {x, 0, 0, 0, x, 0, 0, 0, x}; }

struct CloudField {
  const char* name;
  std::uint8_t datatype;
};
constexpr std::uint8_t kUint8 = 2, kUint32 = 6, kFloat32 = 7;

// Each field starts at a multiple of four bytes, so a point in memory is already a record.
template <class Point>
std::string cloud(slam::Stamp t, const std::string& frame, const std::vector<CloudField>& fields,
                  const std::vector<Point>& points) {
  constexpr auto step = std::uint32_t(sizeof(Point));
  const auto count = std::uint32_t(points.size());
  Cdr cdr;
  cdr.header(t, frame).number(1u).number(count).number(std::uint32_t(fields.size()));
  for (std::uint32_t offset = 0; const auto& [name, datatype] : fields)
    cdr.text(name).number(std::exchange(offset, offset + 4)).number(datatype).number(1u);
  cdr.number(std::uint8_t{0}).number(step).number(step * count);
  cdr.raw(reinterpret_cast<const unsigned char*>(points.data()), step * points.size());
  return cdr.number(std::uint8_t{1}).bytes();
}

}  // namespace

const MessageType kCompressedImage = type("sensor_msgs", "CompressedImage"),
                  kImage = type("sensor_msgs", "Image"), kImu = type("sensor_msgs", "Imu"),
                  kCameraInfo = type("sensor_msgs", "CameraInfo"),
                  kPoseStamped = type("geometry_msgs", "PoseStamped"),
                  kPoseWithCovarianceStamped = type("geometry_msgs", "PoseWithCovarianceStamped"),
                  kTransforms = type("tf2_msgs", "TFMessage"), kPath = type("nav_msgs", "Path"),
                  kPointCloud = type("sensor_msgs", "PointCloud2"),
                  kJointState = type("sensor_msgs", "JointState"),
                  kWrench = type("geometry_msgs", "WrenchStamped"), kString = type("std_msgs", "String");

std::string compressed_image(slam::Stamp t, const std::string& frame, std::string_view png) {
  Cdr cdr;
  cdr.header(t, frame).text("png");
  return cdr.raw(reinterpret_cast<const unsigned char*>(png.data()), png.size()).bytes();
}

std::string image(slam::Stamp t, const std::string& frame, const cv::Mat& image) {
  const cv::Mat whole = image.isContinuous() ? image : image.clone();
  const std::size_t row = whole.elemSize() * std::size_t(whole.cols);
  Cdr cdr;
  cdr.header(t, frame).number(std::uint32_t(whole.rows));
  cdr.number(std::uint32_t(whole.cols));
  cdr.text(whole.type() == CV_16UC1 ? "16UC1" : whole.type() == CV_8UC3 ? "rgb8" : "mono8");
  cdr.number(std::uint8_t{0}).number(std::uint32_t(row));
  return cdr.raw(whole.data, row * std::size_t(whole.rows)).bytes();
}

std::string imu(const ExportedReading& reading, const std::string& frame, double gyro_variance,
                double accelerometer_variance) {
  const std::array<double, 4> no_orientation{0, 0, 0, 1};
  std::array<double, 9> unknown{};
  unknown[0] = -1;  // by convention: not measured
  Cdr cdr;
  cdr.header(reading.t, frame).numbers(no_orientation).numbers(unknown);
  cdr.numbers(reading.gyro).numbers(diagonal(gyro_variance));
  cdr.numbers(reading.accelerometer);
  return cdr.numbers(reading.has_acceleration ? diagonal(accelerometer_variance) : unknown).bytes();
}

std::string camera_info(slam::Stamp t, const std::string& frame, const slam::CameraIntrinsics& camera,
                        double right_m) {
  const auto* const lens = std::get_if<slam::Equidistant>(&camera.lens);
  const std::vector<double> d =
      lens ? std::vector{lens->k1, lens->k2, lens->k3, lens->k4} : std::vector<double>(5);
  const double fu = camera.fu_px, fv = camera.fv_px, u0 = camera.u0_px, v0 = camera.v0_px;
  const std::array<double, 9> K{fu, 0, u0, 0, fv, v0, 0, 0, 1};
  const std::array<double, 12> P{fu, 0, u0, -fu * right_m, 0, fv, v0, 0, 0, 0, 1, 0};
  Cdr cdr;
  cdr.header(t, frame).number(std::uint32_t(camera.height_px));
  cdr.number(std::uint32_t(camera.width_px)).text(lens ? "equidistant" : "plumb_bob");
  cdr.number(std::uint32_t(d.size())).numbers(d).numbers(K).numbers(diagonal(1)).numbers(P);
  for (int zero = 0; zero < 6; ++zero) cdr.number(0u);  // binning, region of interest
  return cdr.number(std::uint8_t{0}).bytes();
}

std::string pose_stamped(slam::Stamp t, const std::string& frame, const Eigen::Isometry3d& X) {
  return Cdr{}.header(t, frame).pose(X).bytes();
}

std::string pose_with_covariance_stamped(slam::Stamp t, const std::string& frame, const Eigen::Isometry3d& X,
                                         const files::Matrix6d& P) {
  // The derivative of (position, rotation about axes W) with respect to (rotation about axes C, position).
  files::Matrix6d J = files::Matrix6d::Zero();
  J.topRightCorner<3, 3>().setIdentity();
  J.bottomLeftCorner<3, 3>() = X.linear();
  const files::Matrix6d covariance = J * P * J.transpose();
  return Cdr{}.header(t, frame).pose(X).numbers(covariance.reshaped()).bytes();  // symmetric
}

std::string string(const std::string& text) { return Cdr{}.text(text).bytes(); }

std::string transforms(const std::vector<Transform>& all) {
  Cdr cdr;
  cdr.number(std::uint32_t(all.size()));
  for (const Transform& each : all) cdr.header(each.t, each.parent).text(each.child).pose(each.X);
  return cdr.bytes();
}

std::string path(slam::Stamp t, const std::string& frame, std::span<const files::TumRow> poses) {
  Cdr cdr;
  cdr.header(t, frame).number(std::uint32_t(poses.size()));
  for (const files::TumRow& pose : poses) cdr.header(pose.t, frame).pose(pose.X);
  return cdr.bytes();
}

std::string point_cloud(slam::Stamp t, const std::string& frame, const std::vector<CloudPoint>& points) {
  return cloud(t, frame, {{"x", kFloat32}, {"y", kFloat32}, {"z", kFloat32}, {"id", kUint32}}, points);
}

std::string point_cloud(slam::Stamp t, const std::string& frame, const std::vector<slam::LidarPoint>& points,
                        double lowest_rad, double highest_rad) {
  struct Record {
    slam::LidarPoint point;
    std::uint32_t ring;  // the first byte, on a little-endian machine
  };
  std::vector<Record> records;
  for (const slam::LidarPoint& point : points) {
    const double elevation = std::atan2(point.z_m, std::hypot(point.x_m, point.y_m));
    const double row = kRings * (elevation - lowest_rad) / (highest_rad - lowest_rad);
    records.push_back({point, std::uint32_t(std::clamp(row, 0.0, kRings - 1.0))});
  }
  return cloud(t, frame,
               {{"x", kFloat32},
                {"y", kFloat32},
                {"z", kFloat32},
                {"intensity", kFloat32},
                {"t", kUint32},
                {"ring", kUint8}},
               records);
}

std::string joint_state(slam::Stamp t, const std::vector<std::string>& names,
                        const std::vector<double>& positions) {
  Cdr cdr;
  cdr.header(t, "").number(std::uint32_t(names.size()));
  for (const std::string& name : names) cdr.text(name);
  cdr.number(std::uint32_t(positions.size())).numbers(positions);
  return cdr.number(0u).number(0u).bytes();  // no velocities, no efforts
}

std::string wrench(slam::Stamp t, const std::string& frame, const Eigen::Vector3d& force_n,
                   const Eigen::Vector3d& torque_nm) {
  return Cdr{}.header(t, frame).numbers(force_n).numbers(torque_nm).bytes();
}

}  // namespace ros
}  // namespace sim::exports
