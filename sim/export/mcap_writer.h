// MCAP files (mcap.dev, format version 0): chunked, indexed, uncompressed, with a checksum for each chunk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

#include "sim/files/hash.h"

namespace sim::exports {

/// The type of a channel's messages: the name of its schema, and its definition in ROS 2's interface
/// language.
struct MessageType {
  std::string name, definition;
};

/// A file of ROS 2 messages in CDR. Keeps one chunk and the indexes in memory. Throws FileError.
class McapWriter {
 public:
  explicit McapWriter(const fs::path& file);

  /// Adds a channel before the first message; returns its number. qos: publisher's profiles in YAML or empty.
  std::uint16_t add_channel(const std::string& topic, const MessageType& type, const std::string& qos);
  void add_message(std::uint16_t channel, std::int64_t t_ns, std::string_view cdr);
  /// Writes the indexes and closes the file. Without them it is not a valid MCAP file.
  void finish();

  std::uint64_t messages() const { return std::accumulate(counts_.begin(), counts_.end(), std::uint64_t{0}); }
  std::uint64_t messages(std::uint16_t channel) const { return counts_.at(channel - 1u); }
  std::uint64_t begin_ns() const { return begin_; }
  std::uint64_t end_ns() const { return end_; }

 private:
  struct Chunk {  // its index
    std::uint64_t begin, end, offset, length, index_length, size;
    std::map<std::uint16_t, std::uint64_t> index_offsets;
  };
  using Moments = std::vector<std::pair<std::uint64_t, std::uint64_t>>;  // time, offset in the chunk

  void put(std::string_view bytes);
  void close_chunk();

  files::HashedFile out_;
  std::uint64_t at_ = 0;
  std::vector<std::string> schemas_, channels_;  // records
  std::vector<std::uint64_t> counts_;            // messages per channel
  std::vector<Chunk> chunks_;
  std::string chunk_;
  std::map<std::uint16_t, Moments> moments_;
  std::uint64_t chunk_begin_ = ~0ull, chunk_end_ = 0, begin_ = ~0ull, end_ = 0;
};

}  // namespace sim::exports
