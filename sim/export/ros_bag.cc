#include "sim/export/ros_bag.h"

#include <fmt/format.h>

#include <optional>

#include "sim/export/imu_merger.h"
#include "sim/export/mcap.h"
#include "sim/export/ros_messages.h"
#include "sim/recording/grey_png.h"

namespace sim::exports {
namespace {

constexpr const char *kCameraFrame = "camera", *kImuFrame = "imu", *kWorld = "world";

// A topic with its channel in the MCAP file.
struct Topic {
  std::string name;
  const MessageType& type;
  std::uint16_t channel;
};

class BagWriter {
 public:
  BagWriter(const ExportContext& out, const BagLayout& layout);
  void write();

 private:
  Topic topic(const std::string& name, const MessageType& type) {
    return {name, type, mcap_.add_channel(name, type)};
  }
  void add(const Topic& to, slam::Stamp t, const std::string& cdr) {
    mcap_.add_message(to.channel, recording::file_stamp(t), cdr);
  }
  void add_image(const slam::Observation& o);
  void add_imu(const ImuReading& reading);
  void add_estimate(const files::TumRow& row);
  std::string topic_entry(const Topic& topic) const;
  std::string metadata() const;

  const ExportContext& out_;
  const BagLayout& layout_;
  std::vector<files::TumRow> estimate_ = out_.estimate();
  McapWriter mcap_;
  Topic image_, info_, imu_, truth_, plan_;
  std::optional<Topic> slam_;
};

BagWriter::BagWriter(const ExportContext& out, const BagLayout& layout)
    : out_(out),
      layout_(layout),
      mcap_(out.new_file(layout.folder + "run.mcap")),
      image_(topic(layout.image_topic, layout.compressed ? ros::kCompressedImage : ros::kImage)),
      info_(topic(layout.info_topic, ros::kCameraInfo)),
      imu_(topic(layout.imu_topic, ros::kImu)),
      truth_(topic("/ground_truth/pose", ros::kPoseStamped)),
      plan_(topic("/plan/pose", ros::kPoseStamped)) {
  if (!estimate_.empty()) slam_.emplace(topic("/slam/pose", ros::kPoseWithCovarianceStamped));
  mcap_.add_metadata("gaitslam", {{"scenario", out.run.name}, {"seed", std::to_string(out.run.seed)}});
}

void BagWriter::add_image(const slam::Observation& o) {
  const cv::Mat image = out_.exported(o.image);
  add(image_, o.t,
      layout_.compressed ? ros::compressed_image(o.t, kCameraFrame, recording::encode_grey_png(image))
                         : ros::image(o.t, kCameraFrame, image));
  add(info_, o.t, ros::camera_info(o.t, kCameraFrame, out_.camera()));
}

void BagWriter::add_imu(const ImuReading& reading) {
  const double gyro = out_.noise.gyro_density, accelerometer = out_.noise.accelerometer_density;
  const double rate = out_.setup.imu_rate_hz;
  add(imu_, reading.t,
      ros::imu(reading, kImuFrame, gyro * gyro * rate, accelerometer * accelerometer * rate));
}

void BagWriter::add_estimate(const files::TumRow& row) {
  const files::Matrix6d P = row.covariance.value_or(files::Matrix6d::Zero());
  add(*slam_, row.t, ros::pose_with_covariance_stamped(row.t, kWorld, row.X, P));
}

// Truth and estimate have the stamps of the frames; they are merged with the observations by time.
void BagWriter::write() {
  const std::vector<files::TimedPose> truth = out_.truth().camera;
  auto true_pose = truth.begin();
  auto estimate = estimate_.begin();
  ImuMerger imu_merger(out_.setup.imu_rate_hz);
  for (recording::FilterInput input = out_.filter_input(); auto o = input.next_in_order();) {
    for (const ImuReading& reading : imu_merger.merge(*o)) add_imu(reading);
    if (!o->image.empty()) add_image(*o);
    if (o->plan) add(plan_, o->t, ros::pose_stamped(o->t, kWorld, o->plan->X_PC));
    for (; true_pose != truth.end() && true_pose->t <= o->t; ++true_pose)
      add(truth_, true_pose->t, ros::pose_stamped(true_pose->t, kWorld, true_pose->X));
    for (; estimate != estimate_.end() && estimate->t <= o->t; ++estimate) add_estimate(*estimate);
  }
  mcap_.finish();
  out_.write(layout_.folder + "metadata.yaml", metadata());
}

std::string BagWriter::topic_entry(const Topic& topic) const {
  return fmt::format(
      "    - topic_metadata:\n        name: {}\n        type: {}\n        serialization_format: cdr\n"
      "        offered_qos_profiles: \"\"\n      message_count: {}\n",
      topic.name, topic.type.name, mcap_.messages(topic.channel));
}

std::string BagWriter::metadata() const {
  std::string topics;
  for (const Topic* topic : {&image_, &info_, &imu_, &truth_, &plan_}) topics += topic_entry(*topic);
  if (slam_) topics += topic_entry(*slam_);
  const std::string span = fmt::format(
      "{{0}}duration:\n{{0}}  nanoseconds: {}\n{{0}}starting_time:\n{{0}}  nanoseconds_since_epoch: {}\n"
      "{{0}}message_count: {}\n",
      mcap_.end_ns() - mcap_.begin_ns(), mcap_.begin_ns(), mcap_.messages());
  return "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n" +
         fmt::format(fmt::runtime(span), "  ") + "  topics_with_message_count:\n" + topics +
         "  compression_format: \"\"\n  compression_mode: \"\"\n  relative_file_paths:\n    - run.mcap\n"
         "  files:\n    - path: run.mcap\n" +
         fmt::format(fmt::runtime(span), "      ");
}

}  // namespace

void write_ros_bag(const ExportContext& out, const BagLayout& layout) { BagWriter(out, layout).write(); }

}  // namespace sim::exports
