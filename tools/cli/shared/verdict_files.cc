#include "tools/cli/shared/verdict_files.h"

#include <fmt/format.h>

#include <iostream>
#include <string>
#include <string_view>

#include "sim/files/atomic_file.h"
#include "sim/files/text.h"
#include "tools/cli/jobs/terminal.h"
#include "tools/cli/shared/out_folder.h"
#include "tools/cli/shared/usage_error.h"

namespace cli {
namespace {

namespace fs = std::filesystem;
namespace regression = sim::regression;

// The value that CLI11 passes for an option without one.
constexpr const char* kNoFile = "";

// The first bytes of each file, for any verdicts.
constexpr std::string_view kJunit = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"gaitslam ";
constexpr std::string_view kMarkdown = "### gaitslam ";
constexpr std::string_view kJson = "{\n  \"title\": \"gaitslam ";

void require_start(const std::optional<fs::path>& file, std::string_view start, const std::string& option) {
  if (!file) return;
  require_folder_of(*file, option);
  if (!fs::exists(fs::symlink_status(*file))) return;
  sim::files::require_regular(*file);
  sim::files::InputFile in(*file, sim::files::kMostOfText);
  const std::string_view found = in.next();
  if (!found.empty() && !found.starts_with(start))
    throw UsageError(fmt::format(
        "{}: exists and was not written by gaitslam; name another file, or remove it", file->string()));
}

}  // namespace

void VerdictFiles::require_replaceable() const {
  require_start(junit, kJunit, "--junit");
  require_start(markdown, kMarkdown, "--markdown");
  require_start(json, kJson, "--json");
}

void VerdictFiles::write(const regression::Comparison& comparison) const {
  using sim::files::write_atomically;
  if (junit) write_atomically(*junit, regression::junit(comparison));
  if (markdown) write_atomically(*markdown, regression::markdown(comparison));
  if (json) write_atomically(*json, regression::verdicts_json(comparison));
}

void report_verdicts(const regression::Comparison& comparison, const VerdictFiles& files) {
  text_out() << regression::verdict_table(comparison, colours());
  if (output() == Output::json) std::cout << regression::verdicts_json(comparison);
  files.write(comparison);
}

void add_verdict_files(CLI::App& command, VerdictFiles& files) {
  command.add_option("--junit", files.junit, "write JUnit XML to a file");
  command.add_option("--markdown", files.markdown, "write a Markdown table to a file");
  add_quiet(command);
  const auto take_json = [&files](const std::string& file) {
    if (file == kNoFile)
      choose_output(Output::json);
    else
      files.json = file;
  };
  command
      .add_option_function<std::string>(
          "--json", take_json,
          "print the verdicts as JSON (schemas/verdicts.schema.json) and nothing "
          "else, or write them to a file")
      ->expected(0, 1)
      ->option_text("[FILE]")
      ->excludes("--quiet");
}

}  // namespace cli
