#include "sim/programs/conversation.h"

#include <fmt/format.h>

namespace sim::programs {
namespace {

constexpr double kExitWithin_s = 2;         // time to exit after END
constexpr double kLastLinesWithin_s = 0.2;  // time to write last lines after a failure
constexpr const char* kUnsolicited =
    "it wrote more than one message to its standard output for each that it received";

}  // namespace

std::string message(Message type, std::initializer_list<std::string_view> parts) {
  Header header;
  header.type = std::uint32_t(type);
  for (const std::string_view part : parts) header.bytes += part.size();
  std::string bytes;
  bytes.reserve(sizeof header + header.bytes);
  bytes += bytes_of(header);
  for (const std::string_view part : parts) bytes += part;
  return bytes;
}

bool starts_message(std::string_view bytes) {
  return bytes.starts_with(std::string_view(Header{}.magic, sizeof Header::magic));
}

std::size_t payload_bytes(std::string_view header, Message type, std::size_t most) {
  const bool is_message = starts_message(header);
  const auto words = pop<Header>(header, "header");
  if (!is_message)
    throw InvalidMessage(
        fmt::format("its standard output is not a message: it starts with '{}'", printable(bytes_of(words))));
  if (words.type != std::uint32_t(type))
    throw InvalidMessage(fmt::format("its message is of type {}, expected {}", words.type, int(type)));
  if (words.bytes > most)
    throw InvalidMessage(
        fmt::format("its message announces {} bytes, expected at most {}", words.bytes, most));
  return std::size_t(words.bytes);
}

void fail_short(const char* of, std::size_t bytes, std::size_t expected) {
  throw InvalidMessage(fmt::format("its {} has {} bytes, expected at least {}", of, bytes, expected));
}

bool flag(std::uint32_t word, const char* of) {
  if (word > 1) throw InvalidMessage(fmt::format("its {} is {}, expected 0 or 1", of, word));
  return word == 1;
}

void check_ready(std::string_view& payload, std::uint32_t version, const char* header_file) {
  const auto its_version = pop<std::uint32_t>(payload, "READY"), text = pop<std::uint32_t>(payload, "READY");
  if (its_version != version)
    throw InvalidMessage(
        fmt::format("it speaks version {} of {}, expected {}", its_version, header_file, version));
  if (text > payload.size() || text > kMostTextBytes)
    throw InvalidMessage(
        fmt::format("its READY announces a text of {} bytes, and {} follow", text, payload.size()));
  if (text > 0) throw InvalidMessage("it cannot start: " + printable(payload.substr(payload.size() - text)));
}

Conversation::Conversation(const Choice& choice, std::string role, std::string_view start,
                           const std::function<void(std::string_view)>& read_ready, std::size_t most_bytes,
                           const std::filesystem::path& writable)
    : choice_(choice),
      role_(std::move(role)),
      most_bytes_(most_bytes),
      program_(choice.words, role_, writable) {
  try {
    const TimeLimit limit(choice_.start_within_s);
    program_.send(start, limit);
    read_ready(receive(Message::ready, limit));
  } catch (const InvalidMessage& refusal) {
    throw std::invalid_argument(
        fmt::format("{}: {}: {}{}", role_, choice_.name, refusal.what(), last_lines()));
  } catch (const ProgramFailed& failure) {
    throw failed("at its start", failure.what());
  }
}

std::string Conversation::ask(std::string_view message) {
  if (const std::string early = program_.unread(); starts_message(early))
    throw InvalidMessage(kUnsolicited);
  else if (!early.empty())
    throw InvalidMessage(fmt::format("its standard output has bytes that are not a message: '{}'",
                                     printable(early.substr(0, kHeaderBytes))));
  const TimeLimit limit(choice_.answer_within_s);
  program_.send(message, limit);
  return receive(Message::answer, limit);
}

ProgramFailed Conversation::failed(const std::string& when, const std::string& cause) {
  const std::string lines = last_lines();
  return ProgramFailed(fmt::format("the {} {} failed {}: {}{}", role_, choice_.name, when, cause, lines),
                       program_.log());
}

std::string Conversation::finish() {
  bool exited = false;
  try {
    program_.send(message(Message::end, {}), TimeLimit(kExitWithin_s));
    exited = true;
  } catch (const ProgramFailed&) {
    // It has already exited.
  }
  exited &= program_.end(TimeLimit(kExitWithin_s));
  if (starts_message(program_.unread())) throw failed("at its end", kUnsolicited);
  const std::string fault = program_.exit_fault(), log = program_.log();
  return fault.empty() || !exited ? log : log + fmt::format("gaitslam: after END, {}\n", fault);
}

// Ends the program. Output that it writes because its input ended is ignored.
std::string Conversation::last_lines() {
  const std::string lines = program_.last_lines();
  program_.end(TimeLimit(kLastLinesWithin_s));
  return lines.empty() ? "" : "; its last lines: " + lines;
}

std::string Conversation::receive(Message type, const TimeLimit& limit) {
  const std::size_t bytes = payload_bytes(program_.receive(kHeaderBytes, limit), type, most_bytes_);
  return program_.receive(bytes, limit);
}

}  // namespace sim::programs
