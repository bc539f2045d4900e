// Messages to and from a child program: framing, poses, and the conversation from START to END.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <functional>
#include <initializer_list>

#include "sim/programs/child_program.h"
#include "sim/programs/choice.h"

namespace sim::programs {

/// Precedes each message: gaitslam_header.
struct Header {
  char magic[4] = {'G', 'S', 'L', 'M'};
  std::uint32_t type = 0;
  std::uint64_t bytes = 0;  ///< number of bytes that follow
};
inline constexpr std::size_t kHeaderBytes = sizeof(Header);

/// The types of messages. input: OBSERVATION or SENSORS, which the program answers.
enum class Message : std::uint32_t { start = 1, ready, input, answer, end };

/// Maximum length in bytes of a text in a message.
inline constexpr std::size_t kMostTextBytes = 4096;

/// A message that the interface does not allow.
class InvalidMessage : public ProgramFailed {
 public:
  using ProgramFailed::ProgramFailed;
};

template <class Bytes>
std::string_view bytes_of(const Bytes& structure) {
  return {reinterpret_cast<const char*>(&structure), sizeof structure};
}
template <class Item>
std::string_view bytes_of(const std::vector<Item>& items) {
  return {reinterpret_cast<const char*>(items.data()), items.size() * sizeof(Item)};
}

using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

inline void copy(const Eigen::Vector3d& from, double* to) { std::copy_n(from.data(), 3, to); }

/// Pose: a structure of rotation[9], by rows, and translation_m[3].
template <class Pose>
Pose pose_of(const Eigen::Isometry3d& X) {
  Pose pose{};
  Eigen::Map<RowMajor3d>(pose.rotation) = X.linear();
  copy(X.translation(), pose.translation_m);
  return pose;
}

Eigen::Isometry3d isometry_of(const auto& pose) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::Map<const RowMajor3d>(pose.rotation);
  X.translation() = Eigen::Map<const Eigen::Vector3d>(pose.translation_m);
  return X;
}

/// Returns a whole message with its header.
std::string message(Message type, std::initializer_list<std::string_view> parts);

/// Returns whether the bytes start with a header.
bool starts_message(std::string_view bytes);

/// Returns the number of bytes that follow a header. Throws InvalidMessage if it is not a header of that
/// type, or if more than `most` bytes follow.
std::size_t payload_bytes(std::string_view header, Message type, std::size_t most);

/// Throws InvalidMessage: "its READY has 4 bytes, expected at least 8".
[[noreturn]] void fail_short(const char* of, std::size_t bytes, std::size_t expected);

/// Removes a structure from the front of the bytes. Throws InvalidMessage if there are not enough bytes.
template <class Structure>
Structure pop(std::string_view& bytes, const char* of) {
  if (bytes.size() < sizeof(Structure)) fail_short(of, bytes.size(), sizeof(Structure));
  Structure structure;
  std::memcpy(&structure, bytes.data(), sizeof structure);
  bytes.remove_prefix(sizeof structure);
  return structure;
}

/// Returns the word as a flag. Throws InvalidMessage unless it is 0 or 1.
bool flag(std::uint32_t word, const char* of);

/// Removes the version and the text's length from the front of a READY, and the text from its end. Throws
/// InvalidMessage if the version is not the header file's, or if the text states why the program cannot
/// start.
void check_ready(std::string_view& payload, std::uint32_t version, const char* header_file);

/// The conversation with a program. Failures contain the time and the program's last lines.
class Conversation {
 public:
  /// Sends START and reads the payload of READY. role: "estimator"; most_bytes: of an answer; writable: see
  /// ChildProgram. Throws std::invalid_argument if the program cannot be started or read_ready throws
  /// InvalidMessage, and ProgramFailed if the program crashes or misses its time limit.
  Conversation(const Choice& choice, std::string role, std::string_view start,
               const std::function<void(std::string_view)>& read_ready, std::size_t most_bytes,
               const std::filesystem::path& writable = {});
  /// Sends a message and returns the payload of its ANSWER. Throws ProgramFailed with only the cause.
  std::string ask(std::string_view message);
  /// Ends the program. Returns the exception to throw. when: "at t = 1.000 s".
  ProgramFailed failed(const std::string& when, const std::string& cause);
  /// Sends END and returns the log. Throws ProgramFailed if the program has sent more answers than it was
  /// asked for.
  std::string finish();
  double cpu_ms() const { return program_.cpu_ms(); }

 private:
  std::string last_lines();
  std::string receive(Message type, const TimeLimit& limit);

  Choice choice_;
  std::string role_;
  std::size_t most_bytes_;
  ChildProgram program_;
};

}  // namespace sim::programs
