#include "tools/cli/jobs/child.h"

#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <stdexcept>
#include <utility>

#include "sim/files/text.h"

namespace cli {
namespace {

std::string shell_line(const std::vector<std::string>& argv) {
  std::string line = "exec";
  for (const std::string& word : argv) line += " " + sim::files::shell_word(word);
  return line;
}

// Names the package of programs that are not installed by default.
std::string package_of(const std::string& program) {
  if (program == "rsvg-convert") return "; Debian's package librsvg2-bin has it";
  if (program == "ffmpeg") return "; Debian's package ffmpeg has it";
  return "";
}

void require_success(const std::string& program, int status, const std::string& error) {
  if (WIFEXITED(status) && WEXITSTATUS(status) == 127)
    throw std::runtime_error(fmt::format("{} cannot be run{}", program, package_of(program)));
  if (status != 0) throw std::runtime_error(fmt::format("{} failed{}", program, error));
}

}  // namespace

FedChild::FedChild(const std::vector<std::string>& argv) : name_(argv[0]), errors_(std::tmpfile()) {
  ::signal(SIGPIPE, SIG_IGN);  // write() reports a child that ended early
  const int errors = errors_ ? ::fileno(errors_) : STDERR_FILENO;
  input_ = ::popen(fmt::format("{} 2>/proc/{}/fd/{}", shell_line(argv), ::getpid(), errors).c_str(), "w");
  if (!input_) throw std::runtime_error(name_ + " cannot be started");
}

FedChild::~FedChild() {
  if (input_) ::pclose(input_);
  if (errors_) std::fclose(errors_);
}

void FedChild::write(std::string_view bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), input_) == bytes.size()) return;
  finish();
  throw std::runtime_error(name_ + " ended early");
}

void FedChild::finish() {
  const int status = ::pclose(std::exchange(input_, nullptr));
  std::array<char, 1000> line{};
  if (errors_) std::rewind(errors_);
  const bool has_error = errors_ && std::fgets(line.data(), line.size(), errors_);
  std::string error = has_error ? fmt::format(": {}", line.data()) : "";
  require_success(name_, status, error.substr(0, error.find('\n')));
}

}  // namespace cli
