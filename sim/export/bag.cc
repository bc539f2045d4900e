#include "sim/export/bag.h"

#include <fmt/format.h>

#include "sim/recording/recording.h"

namespace sim::exports {

Bag::Topic Bag::add_topic(const std::string& name, const MessageType& type) {
  topics_.push_back({name, type.name, mcap_.add_channel(name, type)});
  return topics_.back().channel;
}

void Bag::add(Topic topic, slam::Stamp t, const std::string& cdr) {
  mcap_.add_message(topic, recording::file_stamp(t), cdr);
}

std::string Bag::entry(const NamedTopic& topic) const {
  return fmt::format(
      "    - topic_metadata:\n        name: {}\n        type: {}\n        serialization_format: cdr\n"
      "        offered_qos_profiles: \"\"\n      message_count: {}\n",
      topic.name, topic.type, mcap_.messages(topic.channel));
}

std::string Bag::finish() {
  mcap_.finish();
  std::string topics;
  for (const NamedTopic& topic : topics_) topics += entry(topic);
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

}  // namespace sim::exports
