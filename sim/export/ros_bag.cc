#include "sim/export/ros_bag.h"

#include <fmt/ranges.h>
#include <libdeflate.h>

#include <algorithm>
#include <cassert>

#include "sim/recording/image_file.h"

namespace sim::exports {
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

// The fields of a record, little-endian. Texts and maps are preceded by their length.
struct Fields {
  std::string bytes;

  template <typename Number>
  Fields& number(Number x) {
    bytes.append(reinterpret_cast<const char*>(&x), sizeof x);
    return *this;
  }
  Fields& text(std::string_view t) {
    number(std::uint32_t(t.size())).bytes += t;
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
  return Fields{}.number(std::uint8_t(op)).number(std::uint64_t{fields.size()}).bytes.append(fields);
}

// Returns how far a camera is to the right of the head camera, or 0 unless both look in the same direction
// side by side, so that their images are rectified.
double right_of_head(const rig::RigSensor& camera) {
  const Eigen::Vector3d p = camera.X_CS.translation();
  const bool parallel = camera.X_CS.linear().isIdentity(1e-9) && std::hypot(p.y(), p.z()) < 1e-9;
  return camera.kind == rig::Kind::gray && parallel ? p.x() : 0;
}

std::string message(const ExportedReading& reading, const rig::RigSensor& sensor, bool as_png) {
  const std::string frame = frame_of(sensor);
  if (sensor.kind == rig::Kind::lidar)
    return ros::point_cloud(reading.t, frame, reading.points, sensor.lowest_rad, sensor.highest_rad);
  if (as_png && rig::is_camera(sensor))
    return ros::compressed_image(reading.t, frame, recording::encode_png(reading.image));
  if (rig::is_camera(sensor)) return ros::image(reading.t, frame, reading.image);
  return ros::imu(reading, frame, std::pow(sensor.gyro_sigma_rad_s, 2),
                  std::pow(sensor.accelerometer_sigma_m_s2, 2));
}

}  // namespace

McapWriter::McapWriter(const fs::path& file) : out_(file) {
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
  const auto id = std::uint16_t(channels_.size() + 1);
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
  const auto t = std::uint64_t(t_ns);
  const auto sequence = std::uint32_t(++counts_.at(channel - 1u));
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
    std::ranges::stable_sort(moments);
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
  put(record(Op::data_end, Fields{}.number(0u).bytes));  // no checksum: each chunk has its own
  const std::uint64_t summary = at_;
  for (const auto* records : {&schemas_, &channels_})
    for (const std::string& one : *records) put(one);
  const auto n = [](const auto& list) { return std::uint32_t(list.size()); };
  std::map<std::uint16_t, std::uint64_t> counts;
  for (std::uint16_t channel = 1; channel <= counts_.size(); ++channel) counts[channel] = messages(channel);
  Fields statistics;
  statistics.number(messages()).number(std::uint16_t(n(schemas_))).number(n(channels_));
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

Topic Bag::add_topic(const std::string& name, const MessageType& type, bool latched) {
  const std::string qos = latched ? text_of("bag_latched.yaml") : "";
  std::string escaped;
  for (const char c : qos) escaped += c == '\n' ? "\\n" : std::string(1, c);
  topics_.push_back({name, type.name, escaped});
  return mcap_.add_channel(name, type, qos);
}

void Bag::add(Topic topic, slam::Stamp t, const std::string& cdr) {
  if (topic) mcap_.add_message(*topic, recording::file_stamp(t), cdr);
}

std::string Bag::finish() {
  mcap_.finish();
  std::string topics;
  for (std::uint16_t channel = 1; const auto& [name, type, qos] : topics_)
    topics += filled_text("bag_topic.yaml", name, type, qos, mcap_.messages(channel++));
  return filled_text("bag_metadata.yaml", mcap_.end_ns() - mcap_.begin_ns(), mcap_.begin_ns(),
                     mcap_.messages(), topics);
}

RecordedRows::RecordedRows(const recording::Manifest& manifest, const std::string& file) {
  if (!manifest.lists(file)) return;
  rows_.emplace(files::CsvReader(manifest.check(file)), recording::kEpoch);
  const std::vector<std::string>& titles = rows_->row().titles();
  for (std::size_t i = 1; i < titles.size(); ++i) names.push_back(titles[i].substr(0, titles[i].find(" [")));
}

void RecordedRows::until(slam::Stamp t,
                         const std::function<void(slam::Stamp, const std::vector<double>&)>& each) {
  for (; rows_ && rows_->stamp() && *rows_->stamp() <= t; rows_->advance()) {
    newest.clear();
    for (std::size_t i = 1; i < rows_->row().fields(); ++i) newest.push_back(rows_->row().number(i));
    each(*rows_->stamp(), newest);
  }
}

void write_ros_bag(const ExportContext& out, const std::string& folder, bool for_viewers) {
  Bag bag(out.new_file(folder + "run.mcap"));
  SensorTopics sensors(out, bag, for_viewers);
  PoseTopics poses(out, bag, for_viewers);
  for (Frames frames(out); const auto frame = frames.next();) {
    sensors.write(*frame);
    poses.write(*frame);
  }
  poses.finish();
  out.write(folder + "metadata.yaml", bag.finish());
}

void export_mcap(const ExportContext& out) {
  write_ros_bag(out, "", true);
  std::string extrinsics;
  for (const int lidar : out.all(rig::Kind::lidar))
    for (const int imu : out.all(rig::Kind::imu)) {
      const Eigen::Isometry3d X =
          out.sensor(imu).X_CS.inverse() * out.sensor(lidar).X_CS;  // maps the lidar's points to the IMU
      const Eigen::Matrix3d R_by_rows = X.linear().transpose();
      extrinsics += filled_text("mcap_extrinsics.md", out.sensor(lidar).name,
                                imu == out.chest() ? "/imu" : "/rig/" + out.sensor(imu).name + "/imu",
                                fmt::join(X.translation(), ", "), fmt::join(R_by_rows.reshaped(), ", "));
    }
  std::vector<int> cameras = out.all(rig::Kind::gray);
  for (const rig::Kind kind : {rig::Kind::color, rig::Kind::depth})
    for (const int camera : out.all(kind)) cameras.push_back(camera);
  out.write_readme({"mcap.md"}, cameras, extrinsics);
}

std::string frame_of(const rig::RigSensor& sensor) {
  if (sensor.name == rig::kChestImu) return ros::kImuFrame;
  if (!rig::is_camera(sensor)) return sensor.name + "_frame";
  return (sensor.kind == rig::Kind::depth ? sensor.aligned_with : sensor.name) + "_optical_frame";
}

SensorTopics::SensorTopics(const ExportContext& out, Bag& bag, bool for_viewers)
    : out_(out), bag_(bag), topics_(out.sensors.size()) {
  using rig::Kind;
  for (const Kind kind : {Kind::gray, Kind::color, Kind::depth, Kind::lidar, Kind::imu})
    for (int number = 0; const int i : out.all(kind)) {
      if (!for_viewers && kind != Kind::gray && kind != Kind::imu) continue;
      const std::string name = !for_viewers
                                   ? fmt::format("/{}{}", kind == Kind::imu ? "imu" : "cam", number++)
                               : i == out.head()  ? ros::kHeadTopics
                               : i == out.chest() ? ""
                                                  : "/rig/" + out.sensor(i).name;
      Topics& topics = topics_[std::size_t(i)];
      topics.as_png = for_viewers && kind != Kind::depth;  // readers disagree about compressed depth
      if (kind == Kind::lidar)
        topics.readings = bag.add_topic(name + "/points", ros::kPointCloud);
      else if (kind == Kind::imu)
        topics.readings = bag.add_topic(name + (for_viewers ? ros::kImuTopic : ""), ros::kImu);
      else if (topics.as_png)
        topics.readings = bag.add_topic(name + ros::kImageTopic, ros::kCompressedImage);
      else
        topics.readings = bag.add_topic(name + "/image_raw", ros::kImage);
      if (rig::is_camera(out.sensor(i)))
        topics.info = bag.add_topic(name + ros::kInfoTopic, ros::kCameraInfo);
      if (kind == Kind::depth) add_registered(name + "/registered", i, topics);
    }
}

void SensorTopics::add_registered(const std::string& name, int depth, Topics& topics) {
  topics.registered_to = image_of_depth(out_, depth);
  const rig::RigSensor &from = out_.sensor(depth), &to = out_.sensor(topics.registered_to);
  if (from.aligned_with == to.name) return;
  topics.registration.emplace(from.camera, to.camera, to.X_CS.inverse() * from.X_CS);
  topics.registered = bag_.add_topic(name + "/image_raw", ros::kImage);
  topics.registered_info = bag_.add_topic(name + ros::kInfoTopic, ros::kCameraInfo);
}

void SensorTopics::write(const ExportedFrame& frame) {
  for (const ExportedReading& reading : frame.readings) {
    const Topics& topics = topics_.at(std::size_t(reading.sensor));
    const rig::RigSensor& sensor = out_.sensor(reading.sensor);
    if (topics.readings) bag_.add(topics.readings, reading.t, message(reading, sensor, topics.as_png));
    const auto add_info = [&](Topic topic, const rig::RigSensor& camera) {
      bag_.add(topic, reading.t,
               ros::camera_info(reading.t, frame_of(camera), camera.camera, right_of_head(camera)));
    };
    if (topics.info) add_info(topics.info, sensor);
    if (!topics.registration) continue;
    const rig::RigSensor& to = out_.sensor(topics.registered_to);
    bag_.add(topics.registered, reading.t,
             ros::image(reading.t, frame_of(to), (*topics.registration)(reading.image)));
    add_info(topics.registered_info, to);
  }
}

}  // namespace sim::exports
