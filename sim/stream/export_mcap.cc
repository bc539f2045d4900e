#include <fmt/format.h>

#include "sim/stream/export_parts.h"
#include "sim/stream/mcap.h"
#include "sim/stream/ros_messages.h"

namespace sim::stream {
namespace {

constexpr const char* kReadme =
    R"(`run.mcap` holds ROS 2 messages (CDR), `metadata.yaml` makes the folder a bag:

    ros2 bag play FOLDER                      # or: ros2 bag info FOLDER
    evo_ape mcap FOLDER/run.mcap /ground_truth/pose /slam/pose

Foxglove, Lichtblick and Rerun open `run.mcap` itself.

| topic | type | what |
|---|---|---|
| /camera/image/compressed | sensor_msgs/CompressedImage | PNG, lossless |
| /camera/camera_info | sensor_msgs/CameraInfo | at each image |
| /imu | sensor_msgs/Imu | chest IMU |
| /ground_truth/pose | geometry_msgs/PoseStamped | camera in the world, truth |
| /plan/pose | geometry_msgs/PoseStamped | camera as the walking plan has it |
| /slam/pose | geometry_msgs/PoseWithCovarianceStamped | GaitSLAM's filter, if it ran |
)";

constexpr const char *kCameraFrame = "camera", *kImuFrame = "imu", *kWorld = "world";

// A topic with its channel, for messages and for the bag's list.
struct Topic {
  std::string name;
  const MessageType& type;
  std::uint16_t channel;
};

class BagWriter {
 public:
  BagWriter(const Export& out, const Bag& bag);
  void write();

 private:
  Topic topic(const std::string& name, const MessageType& type) {
    return {name, type, mcap_.add_channel(name, type)};
  }
  void add(const Topic& to, slam::Stamp t, const std::string& cdr) {
    mcap_.add_message(to.channel, written(t), cdr);
  }
  void add_image(const slam::Observation& o);
  void add_imu(const ImuReading& reading);
  void add_estimate(const TumRow& row);
  std::string listed(const Topic& topic) const;
  std::string metadata() const;

  const Export& out_;
  const Bag& bag_;
  std::vector<TumRow> estimate_ = out_.estimate();
  McapWriter mcap_;
  Topic image_, info_, imu_, truth_, plan_;
  std::optional<Topic> slam_;
};

BagWriter::BagWriter(const Export& out, const Bag& bag)
    : out_(out),
      bag_(bag),
      mcap_((out.write(bag.place + "run.mcap", ""), out.folder / (bag.place + "run.mcap"))),
      image_(topic(bag.image_topic, bag.compressed ? ros::kCompressedImage : ros::kImage)),
      info_(topic(bag.info_topic, ros::kCameraInfo)),
      imu_(topic(bag.imu_topic, ros::kImu)),
      truth_(topic("/ground_truth/pose", ros::kPoseStamped)),
      plan_(topic("/plan/pose", ros::kPoseStamped)) {
  if (!estimate_.empty()) slam_.emplace(topic("/slam/pose", ros::kPoseWithCovarianceStamped));
  mcap_.add_metadata("gaitslam", {{"scenario", out.run.name}, {"seed", std::to_string(out.run.seed)}});
}

void BagWriter::add_image(const slam::Observation& o) {
  const cv::Mat image = out_.image(o.image);
  add(image_, o.t,
      bag_.compressed ? ros::compressed_image(o.t, kCameraFrame, png(image))
                      : ros::image(o.t, kCameraFrame, image));
  add(info_, o.t, ros::camera_info(o.t, kCameraFrame, out_.camera()));
}

void BagWriter::add_imu(const ImuReading& reading) {
  const double gyro = out_.noise.gyro_density, accelerometer = out_.noise.accelerometer_density;
  const double rate = out_.setup.imu_rate_hz;
  add(imu_, reading.t,
      ros::imu(reading, kImuFrame, gyro * gyro * rate, accelerometer * accelerometer * rate));
}

void BagWriter::add_estimate(const TumRow& row) {
  const Matrix6d P = row.covariance.value_or(Matrix6d::Zero());
  add(*slam_, row.t, ros::pose_with_covariance_stamped(row.t, kWorld, row.X, P));
}

// Truth and estimate are of the frames: put between the observations by their stamps.
void BagWriter::write() {
  const std::vector<TimedPose> truth = out_.truth().camera;
  auto true_pose = truth.begin();
  auto estimate = estimate_.begin();
  WholeReadings whole(out_.setup.imu_rate_hz);
  for (Seen seen = out_.seen(); auto o = seen.next_in_order();) {
    for (const ImuReading& reading : whole.take(*o)) add_imu(reading);
    if (!o->image.empty()) add_image(*o);
    if (o->plan) add(plan_, o->t, ros::pose_stamped(o->t, kWorld, o->plan->X_PC));
    for (; true_pose != truth.end() && true_pose->t <= o->t; ++true_pose)
      add(truth_, true_pose->t, ros::pose_stamped(true_pose->t, kWorld, true_pose->X));
    for (; estimate != estimate_.end() && estimate->t <= o->t; ++estimate) add_estimate(*estimate);
  }
  mcap_.finish();
  out_.write(bag_.place + "metadata.yaml", metadata());
}

std::string BagWriter::listed(const Topic& topic) const {
  return fmt::format(
      "    - topic_metadata:\n        name: {}\n        type: {}\n        serialization_format: cdr\n"
      "        offered_qos_profiles: \"\"\n      message_count: {}\n",
      topic.name, topic.type.name, mcap_.messages(topic.channel));
}

std::string BagWriter::metadata() const {
  std::string topics;
  for (const Topic* topic : {&image_, &info_, &imu_, &truth_, &plan_}) topics += listed(*topic);
  if (slam_) topics += listed(*slam_);
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

void export_bag(const Export& out, const Bag& bag) { BagWriter(out, bag).write(); }

void export_mcap(const Export& out) {
  export_bag(out, {"", "/camera/image/compressed", "/camera/camera_info", "/imu", true});
  out.write_readme(kReadme);
}

}  // namespace sim::stream
