#include "sim/export/ros_bag.h"

#include <fmt/format.h>

#include "sim/recording/grey_png.h"
#include "sim/recording/recording.h"

namespace sim::exports {
namespace {

constexpr const char *kCameraFrame = "camera", *kImuFrame = "imu", *kWorld = "world";

class BagWriter {
 public:
  BagWriter(const ExportContext& out, const BagLayout& layout);
  void write();

 private:
  void add_image(const slam::Observation& o);
  void add_imu(const ImuReading& reading);
  void add_estimate(const files::TumRow& row);

  const ExportContext& out_;
  const BagLayout& layout_;
  std::vector<files::TumRow> estimate_ = out_.estimate();
  Bag bag_;
  Bag::Topic image_, info_, imu_, truth_, plan_;
  std::optional<Bag::Topic> slam_;
  std::optional<ViewerTopics> viewer_;
};

BagWriter::BagWriter(const ExportContext& out, const BagLayout& layout)
    : out_(out),
      layout_(layout),
      bag_(out.new_file(layout.folder + "run.mcap")),
      image_(bag_.add_topic(layout.image_topic, layout.compressed ? ros::kCompressedImage : ros::kImage)),
      info_(bag_.add_topic(layout.info_topic, ros::kCameraInfo)),
      imu_(bag_.add_topic(layout.imu_topic, ros::kImu)),
      truth_(bag_.add_topic("/ground_truth/pose", ros::kPoseStamped)),
      plan_(bag_.add_topic("/plan/pose", ros::kPoseStamped)) {
  if (!estimate_.empty()) slam_.emplace(bag_.add_topic("/slam/pose", ros::kPoseWithCovarianceStamped));
  if (layout.for_viewers) viewer_.emplace(out, bag_);
}

void BagWriter::add_image(const slam::Observation& o) {
  const cv::Mat image = out_.exported(o.image);
  bag_.add(image_, o.t,
           layout_.compressed ? ros::compressed_image(o.t, kCameraFrame, recording::encode_grey_png(image))
                              : ros::image(o.t, kCameraFrame, image));
  bag_.add(info_, o.t, ros::camera_info(o.t, kCameraFrame, out_.camera()));
}

void BagWriter::add_imu(const ImuReading& reading) {
  const double gyro = out_.noise.gyro_density, accelerometer = out_.noise.accelerometer_density;
  const double rate = out_.setup.imu_rate_hz;
  bag_.add(imu_, reading.t,
           ros::imu(reading, kImuFrame, gyro * gyro * rate, accelerometer * accelerometer * rate));
}

void BagWriter::add_estimate(const files::TumRow& row) {
  const files::Matrix6d P = row.covariance.value_or(files::Matrix6d::Zero());
  bag_.add(*slam_, row.t, ros::pose_with_covariance_stamped(row.t, kWorld, row.X, P));
}

// Truth and estimate have the stamps of the frames; they are merged with the observations by time.
void BagWriter::write() {
  const std::vector<files::TimedPose> truth = out_.truth().camera;
  auto true_pose = truth.begin();
  auto estimate = estimate_.begin();
  ImuMerger imu_merger(out_.setup.imu_rate_hz);
  for (recording::FilterInput input = out_.filter_input(); auto o = out_.next(input);) {
    for (const ImuReading& reading : imu_merger.merge(*o)) add_imu(reading);
    if (!o->image.empty()) add_image(*o);
    if (o->plan) bag_.add(plan_, o->t, ros::pose_stamped(o->t, kWorld, o->plan->X_PC));
    for (; true_pose != truth.end() && true_pose->t <= o->t; ++true_pose)
      bag_.add(truth_, true_pose->t, ros::pose_stamped(true_pose->t, kWorld, true_pose->X));
    for (; estimate != estimate_.end() && estimate->t <= o->t; ++estimate) add_estimate(*estimate);
    if (viewer_) viewer_->write(*o);
  }
  if (viewer_) viewer_->finish();
  out_.write(layout_.folder + "metadata.yaml", bag_.finish());
}

}  // namespace

// As version 5 of metadata.yaml writes them: numbers of rmw's enumerations.
Bag::Topic Bag::add_topic(const std::string& name, const MessageType& type, Durability durability) {
  static const std::string forever = "\n    sec: 9223372036\n    nsec: 854775807\n";
  static const std::string latched =
      "- history: 1  # keep_last\n  depth: 1\n  reliability: 1  # reliable\n"
      "  durability: 1  # transient_local\n  deadline:" +
      forever + "  lifespan:" + forever + "  liveliness: 1\n  liveliness_lease_duration:" + forever +
      "  avoid_ros_namespace_conventions: false\n";
  const std::string qos = durability == Durability::transient_local ? latched : "";
  topics_.push_back({name, type.name, qos, mcap_.add_channel(name, type, qos)});
  return topics_.back().channel;
}

void Bag::add(Topic topic, slam::Stamp t, const std::string& cdr) {
  mcap_.add_message(topic, recording::file_stamp(t), cdr);
}

std::string Bag::finish() {
  mcap_.finish();
  std::string topics;
  for (const NamedTopic& topic : topics_) {
    std::string qos = "\"";
    for (const char c : topic.qos) qos += c == '\n' ? std::string("\\n") : std::string(1, c);
    topics += fmt::format(
        "    - topic_metadata:\n        name: {}\n        type: {}\n        serialization_format: cdr\n"
        "        offered_qos_profiles: {}\n      message_count: {}\n",
        topic.name, topic.type, qos + "\"", mcap_.messages(topic.channel));
  }
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

void write_ros_bag(const ExportContext& out, const BagLayout& layout) { BagWriter(out, layout).write(); }

}  // namespace sim::exports
