// A ROS 2 bag that is being written: run.mcap and what metadata.yaml says of it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/export/mcap.h"
#include "slam/observation.h"

namespace sim::exports {

/// All members throw FileError.
class Bag {
 public:
  using Topic = std::uint16_t;

  explicit Bag(const std::filesystem::path& mcap_file) : mcap_(mcap_file) {}

  /// Before the first message.
  Topic add_topic(const std::string& name, const MessageType& type);
  void add_metadata(const std::string& name, const std::map<std::string, std::string>& entries) {
    mcap_.add_metadata(name, entries);
  }
  /// cdr: a message with this stamp.
  void add(Topic topic, slam::Stamp t, const std::string& cdr);
  /// Closes the file. Returns the text of metadata.yaml.
  std::string finish();

 private:
  struct NamedTopic {
    std::string name, type;
    Topic channel;
  };
  std::string entry(const NamedTopic& topic) const;

  McapWriter mcap_;
  std::vector<NamedTopic> topics_;
};

}  // namespace sim::exports
