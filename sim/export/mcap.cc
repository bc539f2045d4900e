#include "sim/export/mcap.h"

#include <libdeflate.h>

#include <algorithm>
#include <cassert>
#include <numeric>

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
  summary_offset = 0x0e,
  data_end
};

template <typename Number>
void put_number(std::string& to, Number x) {
  for (std::size_t byte = 0; byte < sizeof(Number); ++byte) to += static_cast<char>(x >> 8 * byte & 0xff);
}

void put_text(std::string& to, std::string_view text) {
  put_number(to, static_cast<std::uint32_t>(text.size()));
  to += text;
}

// The fields of a record, little-endian; texts and maps follow their length.
struct Fields {
  std::string bytes;

  template <typename Number>
  Fields& number(Number x) {
    put_number(bytes, x);
    return *this;
  }
  Fields& text(std::string_view t) {
    put_text(bytes, t);
    return *this;
  }
  Fields& map(const std::map<std::string, std::string>& entries) {
    std::string inner;
    for (const auto& [key, value] : entries) {
      put_text(inner, key);
      put_text(inner, value);
    }
    return text(inner);
  }
  template <typename Pairs>
  Fields& pairs(const Pairs& all) {
    std::string inner;
    for (const auto& [a, b] : all) {
      put_number(inner, a);
      put_number(inner, b);
    }
    return text(inner);
  }
};

std::string record(Op op, std::string_view fields) {
  std::string bytes(1, static_cast<char>(op));
  put_number(bytes, static_cast<std::uint64_t>(fields.size()));
  bytes += fields;
  return bytes;
}

std::uint32_t add_to_crc32(std::uint32_t crc, std::string_view bytes) {
  return libdeflate_crc32(crc, bytes.data(), bytes.size());
}

}  // namespace

McapWriter::McapWriter(const std::filesystem::path& file) : out_(file) {
  put(kMagic);
  put(record(Op::header, Fields{}.text("ros2").text("gaitslam").bytes));
}

void McapWriter::put(std::string_view bytes) {
  out_.write(bytes);
  crc_ = add_to_crc32(crc_, bytes);
  at_ += bytes.size();
}

std::uint16_t McapWriter::add_channel(const std::string& topic, const MessageType& type,
                                      const std::string& qos) {
  assert(begin_ == ~0ull);
  const auto id = static_cast<std::uint16_t>(channels_.size() + 1);
  schemas_.push_back(
      record(Op::schema, Fields{}.number(id).text(type.name).text("ros2msg").text(type.definition).bytes));
  channels_.push_back(record(
      Op::channel,
      Fields{}.number(id).number(id).text(topic).text("cdr").map({{"offered_qos_profiles", qos}}).bytes));
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
  fields.number(chunk_begin_)
      .number(chunk_end_)
      .number(size)
      .number(add_to_crc32(0, chunk_))
      .text("")
      .number(size);
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

std::string McapWriter::chunk_index(const Chunk& chunk) const {
  Fields fields;
  fields.number(chunk.begin).number(chunk.end).number(chunk.offset).number(chunk.length);
  fields.pairs(chunk.index_offsets).number(chunk.index_length).text("").number(chunk.size).number(chunk.size);
  return record(Op::chunk_index, fields.bytes);
}

std::uint64_t McapWriter::messages() const {
  return std::accumulate(counts_.begin(), counts_.end(), std::uint64_t{0});
}

std::uint64_t McapWriter::messages(std::uint16_t channel) const { return counts_.at(channel - 1u); }

std::string McapWriter::statistics() const {
  const auto n = [](const auto& list) { return static_cast<std::uint32_t>(list.size()); };
  std::map<std::uint16_t, std::uint64_t> counts;
  for (std::uint16_t channel = 1; channel <= counts_.size(); ++channel) counts[channel] = messages(channel);
  Fields fields;
  fields.number(messages()).number(static_cast<std::uint16_t>(n(schemas_))).number(n(channels_));
  fields.number(std::uint32_t{0}).number(std::uint32_t{0}).number(n(chunks_));
  fields.number(messages() ? begin_ : 0).number(end_).pairs(counts);
  return record(Op::statistics, fields.bytes);
}

// The summary groups the records by kind; after it come the offsets of the groups.
void McapWriter::write_summary() {
  std::vector<std::string> indexes;
  for (const Chunk& chunk : chunks_) indexes.push_back(chunk_index(chunk));
  const std::uint64_t summary = at_;
  crc_ = 0;
  std::string offsets;
  const auto group = [&](Op op, const std::vector<std::string>& records) {
    const std::uint64_t begin = at_;
    for (const std::string& one : records) put(one);
    if (at_ > begin)
      offsets +=
          record(Op::summary_offset,
                 Fields{}.number(static_cast<std::uint8_t>(op)).number(begin).number(at_ - begin).bytes);
  };
  group(Op::schema, schemas_);
  group(Op::channel, channels_);
  group(Op::statistics, {statistics()});
  group(Op::chunk_index, indexes);
  const std::uint64_t summary_offsets = at_;
  put(offsets);
  std::string footer = record(Op::footer, Fields{}.number(summary).number(summary_offsets).number(0u).bytes);
  footer.resize(footer.size() - 4);  // without the checksum, which covers all before it
  put(footer);
  std::string checksum;
  put_number(checksum, crc_);
  put(checksum);
}

void McapWriter::finish() {
  close_chunk();
  put(record(Op::data_end, Fields{}.number(crc_).bytes));
  write_summary();
  put(kMagic);
  out_.close();
}

}  // namespace sim::exports
