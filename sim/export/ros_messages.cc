#include "sim/export/ros_messages.h"

#include <array>
#include <cstring>
#include <set>

#include "sim/recording/recording.h"

namespace sim::exports::ros {
namespace {

// Definitions of the types that messages are made of.
const std::map<std::string, std::string, std::less<>> kParts{
    {"std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"},
    {"builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"},
    {"geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"},
    {"geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"},
    {"geometry_msgs/Quaternion", "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n"},
    {"geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"},
    {"geometry_msgs/PoseStamped", "std_msgs/Header header\ngeometry_msgs/Pose pose\n"},
    {"geometry_msgs/PoseWithCovariance", "geometry_msgs/Pose pose\nfloat64[36] covariance\n"},
    {"geometry_msgs/Transform", "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"},
    {"geometry_msgs/TransformStamped",
     "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n"},
    {"geometry_msgs/Wrench", "geometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque\n"},
    {"sensor_msgs/PointField",
     "uint8 UINT32=6\nuint8 FLOAT32=7\nstring name\nuint32 offset\nuint8 datatype\nuint32 count\n"},
    {"sensor_msgs/RegionOfInterest",
     "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n"}};

// The definition followed by those of the types that it uses, each once.
MessageType type(const std::string& name, std::string definition) {
  std::set<std::string_view> known;
  for (std::size_t at = 0; at < definition.size(); at = definition.find('\n', at) + 1) {
    const std::string used = definition.substr(at, definition.find_first_of("[ \n", at) - at);
    const auto part = kParts.find(used);
    if (part != kParts.end() && known.insert(part->first).second)
      definition += std::string(80, '=') + "\nMSG: " + part->first + "\n" + part->second;
  }
  return {name, definition};
}

MessageType stamped(const std::string& name, const std::string& fields) {
  return type(name, "std_msgs/Header header\n" + fields);
}

// Common Data Representation: little-endian numbers aligned to their size, after four bytes for the encoding.
class Cdr {
 public:
  template <typename Number>
  Cdr& number(Number x) {
    bytes_.resize(4 + (bytes_.size() - 4 + sizeof(Number) - 1) / sizeof(Number) * sizeof(Number));
    std::array<char, sizeof(Number)> raw;
    std::memcpy(raw.data(), &x, sizeof(Number));
    bytes_.append(raw.data(), raw.size());
    return *this;
  }
  Cdr& text(const std::string& t) {
    number(static_cast<std::uint32_t>(t.size() + 1)).bytes_.append(t.c_str(), t.size() + 1);
    return *this;
  }
  Cdr& raw(const unsigned char* data, std::size_t size) {
    number(static_cast<std::uint32_t>(size)).bytes_.append(reinterpret_cast<const char*>(data), size);
    return *this;
  }
  template <typename List>
  Cdr& numbers(const List& list) {
    for (const double x : list) number(x);
    return *this;
  }
  Cdr& header(slam::Stamp t, const std::string& frame) {
    const std::int64_t ns = recording::file_stamp(t);
    return number(static_cast<std::int32_t>(ns / 1'000'000'000))
        .number(static_cast<std::uint32_t>(ns % 1'000'000'000))
        .text(frame);
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

// Fields of four bytes, float32 except the last, which is uint32: a point in memory is its record.
template <class Point>
std::string cloud(slam::Stamp t, const std::string& frame, const std::vector<const char*>& names,
                  const std::vector<Point>& points) {
  constexpr std::uint8_t kUint32 = 6, kFloat32 = 7;
  constexpr auto step = static_cast<std::uint32_t>(sizeof(Point));
  const auto count = static_cast<std::uint32_t>(points.size());
  Cdr cdr;
  cdr.header(t, frame).number(1u).number(count).number(step / 4);
  for (std::uint32_t i = 0; i < step / 4; ++i)
    cdr.text(names.at(i)).number(4 * i).number(4 * (i + 1) < step ? kFloat32 : kUint32).number(1u);
  cdr.number(std::uint8_t{0}).number(step).number(step * count);
  cdr.raw(reinterpret_cast<const unsigned char*>(points.data()), step * points.size());
  return cdr.number(std::uint8_t{1}).bytes();
}

}  // namespace

const MessageType kCompressedImage =
    stamped("sensor_msgs/msg/CompressedImage", "string format\nuint8[] data\n");
const MessageType kImage = stamped("sensor_msgs/msg/Image",
                                   "uint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\n"
                                   "uint32 step\nuint8[] data\n");
const MessageType kImu =
    stamped("sensor_msgs/msg/Imu",
            "geometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n"
            "geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n"
            "geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n");
const MessageType kCameraInfo =
    stamped("sensor_msgs/msg/CameraInfo",
            "uint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\nfloat64[9] k\nfloat64[9] r\n"
            "float64[12] p\nuint32 binning_x\nuint32 binning_y\nsensor_msgs/RegionOfInterest roi\n");
const MessageType kPoseStamped = stamped("geometry_msgs/msg/PoseStamped", "geometry_msgs/Pose pose\n");
const MessageType kPoseWithCovarianceStamped =
    stamped("geometry_msgs/msg/PoseWithCovarianceStamped", "geometry_msgs/PoseWithCovariance pose\n");
const MessageType kTransforms =
    type("tf2_msgs/msg/TFMessage", "geometry_msgs/TransformStamped[] transforms\n");
const MessageType kPath = stamped("nav_msgs/msg/Path", "geometry_msgs/PoseStamped[] poses\n");
const MessageType kPointCloud =
    stamped("sensor_msgs/msg/PointCloud2",
            "uint32 height\nuint32 width\nsensor_msgs/PointField[] fields\nbool is_bigendian\n"
            "uint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n");
const MessageType kJointState =
    stamped("sensor_msgs/msg/JointState",
            "string[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n");
const MessageType kWrench = stamped("geometry_msgs/msg/WrenchStamped", "geometry_msgs/Wrench wrench\n");
const MessageType kString{"std_msgs/msg/String", "string data\n"};

std::string compressed_image(slam::Stamp t, const std::string& frame, std::string_view png) {
  Cdr cdr;
  cdr.header(t, frame).text("png");
  return cdr.raw(reinterpret_cast<const unsigned char*>(png.data()), png.size()).bytes();
}

std::string image(slam::Stamp t, const std::string& frame, const cv::Mat& image) {
  const cv::Mat whole = image.isContinuous() ? image : image.clone();
  const std::size_t row = whole.elemSize() * static_cast<std::size_t>(whole.cols);
  Cdr cdr;
  cdr.header(t, frame).number(static_cast<std::uint32_t>(whole.rows));
  cdr.number(static_cast<std::uint32_t>(whole.cols));
  cdr.text(whole.type() == CV_16UC1 ? "16UC1" : whole.type() == CV_8UC3 ? "rgb8" : "mono8");
  cdr.number(std::uint8_t{0}).number(static_cast<std::uint32_t>(row));
  return cdr.raw(whole.data, row * static_cast<std::size_t>(whole.rows)).bytes();
}

std::string imu(const ImuReading& reading, const std::string& frame, double gyro_variance,
                double accelerometer_variance) {
  const std::array<double, 4> no_orientation{0, 0, 0, 1};
  std::array<double, 9> unknown{};
  unknown[0] = -1;  // by convention: not measured
  Cdr cdr;
  cdr.header(reading.t, frame).numbers(no_orientation).numbers(unknown);
  cdr.numbers(reading.gyro).numbers(diagonal(gyro_variance));
  cdr.numbers(reading.accelerometer.value_or(Eigen::Vector3d::Zero()));
  return cdr.numbers(reading.accelerometer ? diagonal(accelerometer_variance) : unknown).bytes();
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
  cdr.header(t, frame).number(static_cast<std::uint32_t>(camera.height_px));
  cdr.number(static_cast<std::uint32_t>(camera.width_px)).text(lens ? "equidistant" : "plumb_bob");
  cdr.number(static_cast<std::uint32_t>(d.size())).numbers(d).numbers(K).numbers(diagonal(1)).numbers(P);
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
  cdr.number(static_cast<std::uint32_t>(all.size()));
  for (const Transform& each : all) cdr.header(each.t, each.parent).text(each.child).pose(each.X);
  return cdr.bytes();
}

std::string path(slam::Stamp t, const std::string& frame, std::span<const files::TumRow> poses) {
  Cdr cdr;
  cdr.header(t, frame).number(static_cast<std::uint32_t>(poses.size()));
  for (const files::TumRow& pose : poses) cdr.header(pose.t, frame).pose(pose.X);
  return cdr.bytes();
}

std::string point_cloud(slam::Stamp t, const std::string& frame, const std::vector<CloudPoint>& points) {
  return cloud(t, frame, {"x", "y", "z", "id"}, points);
}

std::string point_cloud(slam::Stamp t, const std::string& frame,
                        const std::vector<slam::LidarPoint>& points) {
  return cloud(t, frame, {"x", "y", "z", "intensity", "t"}, points);
}

std::string joint_state(slam::Stamp t, const std::vector<std::string>& names,
                        const std::vector<double>& positions) {
  Cdr cdr;
  cdr.header(t, "").number(static_cast<std::uint32_t>(names.size()));
  for (const std::string& name : names) cdr.text(name);
  cdr.number(static_cast<std::uint32_t>(positions.size())).numbers(positions);
  return cdr.number(0u).number(0u).bytes();  // no velocities, no efforts
}

std::string wrench(slam::Stamp t, const std::string& frame, const Eigen::Vector3d& force_n,
                   const Eigen::Vector3d& torque_nm) {
  return Cdr{}.header(t, frame).numbers(force_n).numbers(torque_nm).bytes();
}

}  // namespace sim::exports::ros
