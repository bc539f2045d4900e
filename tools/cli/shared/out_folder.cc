#include "tools/cli/shared/out_folder.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstring>
#include <iostream>

#include "sim/result/limits.h"

namespace cli {
namespace {

/// Log file of a resumable command while it runs. A record's key is the path of a finished result.
constexpr const char* kUnfinished = ".unfinished";

bool contains(const fs::path& folder, const fs::path& path) {
  const fs::path above = fs::weakly_canonical(folder), below = fs::weakly_canonical(path);
  return std::mismatch(above.begin(), above.end(), below.begin(), below.end()).first == above.end();
}

/// True if the folder contains only what a command writes before its first result or leaves when killed.
bool has_no_results(const fs::path& folder) {
  std::error_code fault;
  const auto is_trace = [](const fs::directory_entry& entry) {
    const std::string name = entry.path().filename();
    return name == files::kMarker || name == kUnfinished || files::is_partial(entry.path());
  };
  return std::all_of(fs::directory_iterator(folder, fault), {}, is_trace);
}

/// True if the same command was interrupted here.
bool was_interrupted(const fs::path& folder, const std::optional<std::string>& identity) {
  const fs::path file = folder / kUnfinished;
  std::error_code fault;
  return identity && files::has_marker(folder) && fs::is_regular_file(fs::symlink_status(file, fault)) &&
         files::read_text(file).starts_with(*identity + "\n");
}

/// Throws UsageError if --force is needed because the command would replace something.
void require_free(const fs::path& folder, const OutUse& use) {
  if (!use.continues && !has_no_results(folder))
    throw UsageError("{}: already exists; --force replaces what the command writes there", folder.string());
  for (const std::string& result : use.results)
    if (result::is_result(folder / result))
      throw UsageError("{}: already exists; --force replaces it", (folder / result).string());
}

/// Returns the nearest existing folder above the path. Throws UsageError unless it is writable.
fs::path writable_ancestor(const fs::path& path) {
  std::error_code fault;
  fs::path nearest = fs::absolute(path);
  while (!fs::exists(nearest, fault) && nearest != nearest.parent_path()) nearest = nearest.parent_path();
  int why = fs::is_directory(nearest, fault) ? 0 : ENOTDIR;
  if (why == 0 && access(nearest.c_str(), W_OK | X_OK) != 0) why = errno;
  if (why != 0)
    throw UsageError("{}: cannot be written: {}: {}", path.string(), nearest.string(), std::strerror(why));
  return nearest;
}

std::string kept_text(const fs::path& path, const OutUse& use) {
  if (use.replaces) return fmt::format("nothing was written, {} is unchanged; to start over", path.string());
  if (use.names.empty() && !use.identity)
    return fmt::format("this run leaves no result; earlier results in {} are unchanged; to start over",
                       path.string());
  return fmt::format("finished results are kept in {}; to resume", path.string());
}

}  // namespace

void add_out(CLI::App& command, OutRequest& request) {
  command.add_option("--out", request.out, "folder for the results");
  command.add_flag("--force", request.force, "write to an existing folder and replace earlier results");
}

void require_separate(const fs::path& out, const fs::path& read) {
  if (contains(out, read))
    throw UsageError("{}: would be replaced, but the command reads {}; choose another folder", out.string(),
                     read.string());
}

void require_folder_of(const fs::path& file, const std::string& option) {
  std::error_code fault;
  const fs::path folder = file.has_parent_path() ? file.parent_path() : ".";
  if (!fs::is_directory(folder, fault))
    throw UsageError("{} {}: the folder {} does not exist; create it first, or choose another file", option,
                     file.string(), folder.string());
}

void require_new_file(const fs::path& file, bool force, const std::string& option) {
  std::error_code fault;
  require_folder_of(file, option);
  if (fs::is_directory(file, fault))
    throw UsageError("{}: is a folder, expected a file to write", file.string());
  files::require_regular(file);
  if (!force && fs::exists(fs::symlink_status(file, fault)))
    throw UsageError("{}: already exists; --force replaces it", file.string());
}

OutFolder::OutFolder(const OutRequest& request, const fs::path& standard, const OutUse& use)
    : path_(request.out ? fs::path(*request.out) : standard),
      names_(use.names),
      on_interrupt_(kept_text(path_, use)) {
  std::error_code fault;
  if (path_.empty()) throw UsageError("--out: is empty, expected a folder for results");
  if (fs::exists(path_, fault) && !fs::is_directory(path_, fault))
    throw UsageError("{}: is a file, expected a folder for results", path_.string());
  const bool resumes = was_interrupted(path_, use.identity);
  if (request.out && !request.force && !resumes) require_free(path_, use);
  if (use.replaces) {
    if (contains(path_, fs::current_path()))
      throw UsageError("{}: would be replaced, but is or contains the current folder; choose another folder",
                       path_.string());
    files::require_replaceable(path_.has_filename() ? path_ : path_.parent_path());
  }
  for (const std::string& result : use.results) files::require_replaceable(path_ / result);
  existing_ = writable_ancestor(path_);
  if (use.identity) names_.push_back(kUnfinished);
  if (!names_.empty()) {
    fs::create_directories(path_);
    lock_ = files::FileLock::acquire_folder(path_);
    if (!lock_)
      throw UsageError("{}: another process is writing there; wait for it, or choose another folder",
                       path_.string());
    made_marker_ = !files::has_marker(path_);
    files::claim_outputs(path_, names_);
    if (!resumes && use.identity) fs::remove(path_ / kUnfinished);
    if (!resumes && !use.continues) files::set_aside(path_, use.names);
    if (use.identity) log_.emplace(path_ / kUnfinished, *use.identity);
  }
  if (!use.replaces) files::remove_leftovers(path_);
}

void OutFolder::finished() const {
  if (log_) fs::remove(path_ / kUnfinished);  // without a log, another command may have been interrupted here
}

OutFolder::~OutFolder() {
  std::error_code fault;
  if (lock_ && has_no_results(path_)) fs::remove(path_ / kUnfinished, fault);
  if (made_marker_ &&
      std::ranges::none_of(names_, [&](const auto& name) { return fs::exists(path_ / name, fault); }))
    fs::remove(path_ / files::kMarker, fault);
  for (fs::path empty = fs::absolute(path_, fault); empty != existing_ && empty != empty.parent_path();
       empty = empty.parent_path())
    if (fs::exists(empty, fault) && !fs::remove(empty, fault)) return;
}

void print_outcome(int exit_code, const fs::path& folder, const nlohmann::ordered_json& details) {
  nlohmann::ordered_json json{{"format_version", 1}, {"exit_code", exit_code}, {"folder", folder.string()}};
  json.update(details);
  std::cout << files::json_text(json, 2) << '\n';
}

int report(const result::Outcome& outcome, const fs::path& result_folder, bool all_metrics) {
  if (output() == Output::json)
    print_outcome(outcome.exit_code, result_folder,
                  {{"ending", scenario::name_of(outcome.ending)},
                   {"cause", outcome.cause},
                   {"score", files::read_json(result_folder / "score.json").value()}});
  const result::TableStyle style{colors(), all_metrics};
  text_out() << result::score_table(result_folder, style, outcome.exit_code == 3) << "results in "
             << result_folder.string() << '\n';
  if (const auto about = result::read_about(result_folder / "about.json"); about.counterfactual)
    text_out() << "counterfactual: " << *about.counterfactual << '\n';
  if (const auto earlier = result::renew_summary(result_folder))
    text_out() << "the summary of earlier settings is now in " << earlier->string() << '\n';
  if (outcome.exit_code == 3)
    std::cerr << fmt::format("gaitslam: {}: {}\n", scenario::name_of(outcome.ending), outcome.cause);
  return outcome.exit_code;
}

}  // namespace cli
