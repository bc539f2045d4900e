#include "tools/cli/shared/out_folder.h"

#include <CLI/CLI.hpp>
#include <iostream>

#include "sim/result/limits.h"

namespace cli {
namespace {

bool contains(const fs::path& folder, const fs::path& path) {
  const fs::path above = fs::weakly_canonical(folder), below = fs::weakly_canonical(path);
  return std::mismatch(above.begin(), above.end(), below.begin(), below.end()).first == above.end();
}

std::string kept_text(const fs::path& path, OutUse use) {
  const char* const kept =
      use == OutUse::result ? "nothing was written, {} is unchanged; to start over"
      : use == OutUse::adds_result
          ? "this run leaves no result; earlier results in {} are unchanged; to start over"
          : "finished results are kept in {}; to resume";
  return fmt::format(fmt::runtime(kept), path.string());
}

}  // namespace

void add_out(CLI::App& command, OutRequest& request) {
  command.add_option("--out", request.out, "folder for the results");
  command.add_flag("--force", request.force, "replace existing results");
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

void require_new_result(const fs::path& folder, bool force) {
  files::require_replaceable(folder.has_filename() ? folder : folder.parent_path());
  if (!force && files::has_marker(folder))
    throw UsageError("{}: already exists; --force replaces it", folder.string());
}

OutFolder::OutFolder(const OutRequest& request, const fs::path& standard, OutUse use)
    : path_(request.out ? fs::path(*request.out) : standard), on_interrupt_(kept_text(path_, use)) {
  if (path_.empty()) throw UsageError("--out: is empty, expected a folder for results");
  std::error_code fault;
  existing_ = fs::absolute(path_);
  while (!fs::exists(existing_, fault) && existing_ != existing_.parent_path())
    existing_ = existing_.parent_path();
  if (use == OutUse::result) {
    if (contains(path_, fs::current_path()))
      throw UsageError("{}: would be replaced, but is or contains the current folder; choose another folder",
                       path_.string());
    require_new_result(path_, request.force);
    return;
  }
  if (result::is_result(path_))
    throw UsageError("{}: is a result, expected a folder for results", path_.string());
  files::mark_folder(path_);
  if (use == OutUse::adds_result) return;
  lock_ = files::FileLock::acquire(path_ / files::kMarker, files::FileLock::How::try_exclusive);
  if (!lock_)
    throw UsageError("{}: another process is writing there; wait for it, or choose another folder",
                     path_.string());
}

OutFolder::~OutFolder() {
  std::error_code fault;
  const auto is_marker = [](const fs::directory_entry& entry) {
    return entry.path().filename() == files::kMarker;
  };
  const fs::path path = fs::absolute(path_, fault);
  if (path != existing_ && std::all_of(fs::directory_iterator(path, fault), {}, is_marker))
    fs::remove(path / files::kMarker, fault);
  for (fs::path empty = path; empty != existing_ && empty != empty.parent_path(); empty = empty.parent_path())
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
  result::renew_summary(result_folder);
  if (outcome.exit_code == 3)
    std::cerr << fmt::format("gaitslam: {}: {}\n", scenario::name_of(outcome.ending), outcome.cause);
  return outcome.exit_code;
}

}  // namespace cli
