#include "sim/export/ros_messages.h"

#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <set>

#include "sim/recording/recording.h"

namespace sim::exports {
namespace ros {
namespace {

// The type of that name in texts/ros2.msg: its definition followed by those of the types that it uses, each
// once.
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
    bytes_.append(reinterpret_cast<const char*>(&x), sizeof x);  // of this little-endian machine
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
  const std::size_t row = whole.elemSize() * static_cast<std::size_t>(whole.cols);
  Cdr cdr;
  cdr.header(t, frame).number(static_cast<std::uint32_t>(whole.rows));
  cdr.number(static_cast<std::uint32_t>(whole.cols));
  cdr.text(whole.type() == CV_16UC1 ? "16UC1" : whole.type() == CV_8UC3 ? "rgb8" : "mono8");
  cdr.number(std::uint8_t{0}).number(static_cast<std::uint32_t>(row));
  return cdr.raw(whole.data, row * static_cast<std::size_t>(whole.rows)).bytes();
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

}  // namespace ros

namespace {

constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
constexpr std::size_t kChunk = 4 << 20;  // bytes

enum class Op : std::uint8_t {
  header = 1,
  footer,
  schema,
  channel,
  message,
  chunk,
  message_index,
  chunk_index,
  statistics = 0x0b,
  data_end = 0x0f
};

// The fields of a record, little-endian; texts and maps follow their length.
struct Fields {
  std::string bytes;

  template <typename Number>
  Fields& number(Number x) {
    bytes.append(reinterpret_cast<const char*>(&x), sizeof x);
    return *this;
  }
  Fields& text(std::string_view t) {
    number(static_cast<std::uint32_t>(t.size())).bytes += t;
    return *this;
  }
  template <typename Pairs>
  Fields& pairs(const Pairs& all) {
    Fields inner;
    for (const auto& [a, b] : all) inner.number(a).number(b);
    return text(inner.bytes);
  }
};

std::string record(Op op, std::string_view fields) {
  return Fields{}
      .number(static_cast<std::uint8_t>(op))
      .number(std::uint64_t{fields.size()})
      .bytes.append(fields);
}

}  // namespace

McapWriter::McapWriter(const std::filesystem::path& file) : out_(file) {
  put(kMagic);
  put(record(Op::header, Fields{}.text("ros2").text("gaitslam").bytes));
}

void McapWriter::put(std::string_view bytes) {
  out_.write(bytes);
  at_ += bytes.size();
}

std::uint16_t McapWriter::add_channel(const std::string& topic, const MessageType& type,
                                      const std::string& qos) {
  assert(begin_ == ~0ull);
  const auto id = static_cast<std::uint16_t>(channels_.size() + 1);
  schemas_.push_back(
      record(Op::schema, Fields{}.number(id).text(type.name).text("ros2msg").text(type.definition).bytes));
  const std::string metadata = Fields{}.text("offered_qos_profiles").text(qos).bytes;
  channels_.push_back(
      record(Op::channel, Fields{}.number(id).number(id).text(topic).text("cdr").text(metadata).bytes));
  counts_.push_back(0);
  put(schemas_.back());
  put(channels_.back());
  return id;
}

void McapWriter::add_message(std::uint16_t channel, std::int64_t t_ns, std::string_view cdr) {
  const auto t = static_cast<std::uint64_t>(t_ns);
  const auto sequence = static_cast<std::uint32_t>(++counts_.at(channel - 1u));
  Fields fields;
  fields.number(channel).number(sequence).number(t).number(t).bytes += cdr;
  moments_[channel].push_back({t, chunk_.size()});
  chunk_ += record(Op::message, fields.bytes);
  chunk_begin_ = std::min(chunk_begin_, t), chunk_end_ = std::max(chunk_end_, t);
  begin_ = std::min(begin_, t), end_ = std::max(end_, t);
  if (chunk_.size() >= kChunk) close_chunk();
}

void McapWriter::close_chunk() {
  if (chunk_.empty()) return;
  const std::uint64_t size = chunk_.size();
  Fields fields;
  fields.number(chunk_begin_).number(chunk_end_).number(size);
  fields.number(libdeflate_crc32(0, chunk_.data(), chunk_.size())).text("").number(size);
  const std::uint64_t offset = at_;
  put(record(Op::chunk, fields.bytes + chunk_));
  Chunk index{chunk_begin_, chunk_end_, offset, at_ - offset, 0, size, {}};
  for (auto& [channel, moments] : moments_) {
    std::stable_sort(moments.begin(), moments.end());
    index.index_offsets[channel] = at_;
    put(record(Op::message_index, Fields{}.number(channel).pairs(moments).bytes));
  }
  index.index_length = at_ - offset - index.length;
  chunks_.push_back(index);
  chunk_.clear();
  moments_.clear();
  chunk_begin_ = ~0ull, chunk_end_ = 0;
}

void McapWriter::finish() {
  close_chunk();
  put(record(Op::data_end, Fields{}.number(0u).bytes));  // without a checksum: the chunks have theirs
  const std::uint64_t summary = at_;
  for (const auto* records : {&schemas_, &channels_})
    for (const std::string& one : *records) put(one);
  const auto n = [](const auto& list) { return static_cast<std::uint32_t>(list.size()); };
  std::map<std::uint16_t, std::uint64_t> counts;
  for (std::uint16_t channel = 1; channel <= counts_.size(); ++channel) counts[channel] = messages(channel);
  Fields statistics;
  statistics.number(messages()).number(static_cast<std::uint16_t>(n(schemas_))).number(n(channels_));
  statistics.number(0u).number(0u).number(n(chunks_)).number(messages() ? begin_ : 0).number(end_);
  put(record(Op::statistics, statistics.pairs(counts).bytes));
  for (const Chunk& chunk : chunks_) {
    Fields index;
    index.number(chunk.begin).number(chunk.end).number(chunk.offset).number(chunk.length);
    index.pairs(chunk.index_offsets).number(chunk.index_length).text("");
    put(record(Op::chunk_index, index.number(chunk.size).number(chunk.size).bytes));
  }
  constexpr std::uint64_t kNoOffsets = 0;
  put(record(Op::footer, Fields{}.number(summary).number(kNoOffsets).number(0u).bytes));
  put(kMagic);
  out_.close();
}

}  // namespace sim::exports
