#include "sim/export/ros_bag.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/files/csv.h"
#include "sim/recording/manifest.h"
#include "sim/recording/recording_format.h"

namespace sim::exports {

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
    topics +=
        fmt::format(fmt::runtime(text_of("bag_topic.yaml")), name, type, qos, mcap_.messages(channel++));
  return fmt::format(fmt::runtime(text_of("bag_metadata.yaml")), mcap_.end_ns() - mcap_.begin_ns(),
                     mcap_.begin_ns(), mcap_.messages(), topics);
}

RecordedRows::RecordedRows(const std::filesystem::path& recording, const std::string& sensor) {
  const recording::Manifest manifest(recording);
  const std::string file = recording::recording_format::sensor_rows(sensor);
  if (!manifest.lists(file)) return;
  rows_.emplace(files::CsvReader(manifest.check(file), 1), recording::kEpoch);
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
          out.sensor(imu).X_CS.inverse() * out.sensor(lidar).X_CS;  // points of the lidar to the IMU
      const Eigen::Matrix3d R_by_rows = X.linear().transpose();
      extrinsics += fmt::format(fmt::runtime(text_of("mcap_extrinsics.md")), out.sensor(lidar).name,
                                imu == out.chest() ? "/imu" : "/rig/" + out.sensor(imu).name + "/imu",
                                fmt::join(X.translation(), ", "), fmt::join(R_by_rows.reshaped(), ", "));
    }
  std::vector<int> cameras = out.all(rig::Kind::gray);
  for (const rig::Kind kind : {rig::Kind::color, rig::Kind::depth})
    for (const int camera : out.all(kind)) cameras.push_back(camera);
  out.write_readme({"mcap.md"}, cameras, extrinsics);
}

}  // namespace sim::exports
