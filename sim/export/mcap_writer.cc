#include "sim/export/mcap_writer.h"

#include <libdeflate.h>

#include <algorithm>
#include <cassert>

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
  put(record(Op::data_end, Fields{}.number(0u).bytes));  // no checksum: each chunk has its own
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
