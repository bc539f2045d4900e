#include "tools/cli/batch.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <initializer_list>
#include <map>
#include <nlohmann/json.hpp>
#include <system_error>

#include "tools/cli/commands.h"
#include "tools/cli/progress.h"

namespace cli {
namespace {

namespace fs = std::filesystem;

/// A folder of its own for the batch, gone when the batch is.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (fs::temp_directory_path() / "gaitslam-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr)
      throw UsageError(fmt::format("{}: {}", pattern, std::strerror(errno)));
    path_ = pattern;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  fs::path operator/(const std::string& name) const { return path_ / name; }

 private:
  fs::path path_;
};

/// Starts this very program (even when its file has been replaced since) with stderr in a file.
pid_t start(const std::vector<std::string>& arguments, const fs::path& log) {
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&files, STDERR_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  pid_t process = 0;
  const int fault = posix_spawn(&process, "/proc/self/exe", &files, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  if (fault != 0) throw std::system_error(fault, std::generic_category(), "cannot start a process");
  return process;
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

SeedOutcome outcome_of(std::uint64_t seed, int status, const fs::path& log) {
  std::string complaint = text_of(log);
  if (WIFEXITED(status)) return {seed, WEXITSTATUS(status), complaint};
  return {
      seed, 3,
      complaint + fmt::format("killed by signal {} ({})\n", WTERMSIG(status), strsignal(WTERMSIG(status)))};
}

/// Lies beside the batch's scenario.
fs::path set_by_file(const fs::path& scenario) { return scenario.parent_path() / "set_by.json"; }

/// The command line of one seed.
std::vector<std::string> arguments(const Batch& batch, const fs::path& scenario, std::uint64_t seed) {
  const std::string name = fmt::format("seed-{}", seed), set_seed = fmt::format("seed={}", seed),
                    process = std::to_string(getpid());
  std::vector<std::string> words{"gaitslam"};
  const auto add = [&](std::initializer_list<std::string> more) { words.insert(words.end(), more); };
  if (batch.recordings)
    add({"replay", (*batch.recordings / name).string(), set_seed, "--scenario", scenario.string(), "--out",
         (batch.root / name).string()});
  else
    add({"run", scenario.string(), set_seed, "--out", batch.root.string(), "--models",
         batch.models.string()});
  add({"--force", "--set-by", set_by_file(scenario).string(), "--die-with-parent", process});
  return words;
}

std::string log_name(std::uint64_t seed) { return fmt::format("seed-{}.log", seed); }

}  // namespace

void take_origin(sim::bench::ReadScenario& read, const fs::path& set_by) {
  read.origin = nlohmann::json::parse(text_of(set_by)).get<decltype(read.origin)>();
}

void die_with(pid_t batch) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != batch) raise(SIGKILL);
}

std::vector<SeedOutcome> run_batch(const sim::bench::Scenario& scenario, const Batch& batch) {
  const TemporaryFolder temporary;
  const fs::path frozen =
      temporary / (scenario.name + ".yaml");  // later edits of the file change no queued seed
  std::ofstream(frozen) << sim::bench::to_yaml(scenario);
  auto origin = batch.origin;
  origin["seed"] = "--seeds";
  std::ofstream(set_by_file(frozen)) << nlohmann::json(origin);
  std::vector<SeedOutcome> outcomes(batch.seeds.size());
  std::map<pid_t, std::size_t> running;
  std::optional<ProgressLine> line;
  if (!batch.progress) line.emplace(fmt::format("{} seeds of {}", batch.seeds.size(), scenario.name));
  for (std::size_t next = 0, done = 0; done < outcomes.size();) {
    const double part = static_cast<double>(done) / static_cast<double>(outcomes.size());
    line ? line->show(part) : batch.progress(part);
    if (next < outcomes.size() && running.size() < static_cast<std::size_t>(batch.jobs)) {
      const std::uint64_t seed = batch.seeds[next];
      fs::remove_all(batch.root /
                     fmt::format("seed-{}", seed));  // nothing old is taken for this run's result
      running[start(arguments(batch, frozen, seed), temporary / log_name(seed))] = next;
      ++next;
      continue;
    }
    int status = 0;
    const auto ended = running.find(waitpid(-1, &status, 0));
    if (ended == running.end()) continue;
    const std::uint64_t seed = batch.seeds[ended->second];
    outcomes[ended->second] = outcome_of(seed, status, temporary / log_name(seed));
    running.erase(ended);
    ++done;
  }
  return outcomes;
}

}  // namespace cli
