#include "tools/cli/jobs/verdicts.h"

#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <set>
#include <string_view>

#include "sim/files/atomic_file.h"
#include "sim/files/text.h"
#include "tools/cli/shared/out_folder.h"

namespace cli {
namespace {

/// A format of verdicts, and the first bytes of its files.
struct VerdictFormat {
  const char* option;
  std::string_view start;
  std::string (*text)(const regression::Comparison&);
};
constexpr std::array kFormats{
    VerdictFormat{"--junit", "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuite name=\"gaitslam ",
                  regression::junit},
    VerdictFormat{"--markdown", "### gaitslam ", regression::markdown},
    VerdictFormat{"--json", "{\n  \"title\": \"gaitslam ", regression::verdicts_json}};

}  // namespace

std::vector<regression::ScenarioVerdict> verdicts_of(const std::vector<regression::ScenarioResults>& baseline,
                                                     const std::vector<Judged>& now,
                                                     const std::vector<regression::Gate>& gates_of_missing) {
  std::vector<regression::ScenarioVerdict> verdicts;
  std::set<std::string> judged;
  for (const Judged& one : now) {
    const auto before = std::ranges::find(baseline, one.results.name, &regression::ScenarioResults::name);
    auto& verdict = verdicts.emplace_back(regression::compare(
        before == baseline.end() ? regression::ScenarioResults() : *before, one.results, one.gates));
    verdict.limits = regression::judge_limits(one.scenario, one.results.seeds, one.expects_missed);
    verdict.repro = one.repro;
    verdict.file = one.file;
    judged.insert(one.results.name);
  }
  for (const regression::ScenarioResults& before : baseline)
    if (!judged.contains(before.name))
      verdicts.push_back(regression::compare(before, {before.name, {}, {}}, gates_of_missing));
  return verdicts;
}

void add_verdict_files(CLI::App& command, VerdictFiles& files) {
  command.add_option("--junit", files[0], "write JUnit XML to a file");
  command.add_option("--markdown", files[1], "write Markdown tables to a file");
  add_quiet(command);
  const auto take_json = [&files](const std::string& file) {
    if (file.empty())  // CLI11 passes this for an option without a value
      choose_output(Output::json);
    else
      files[2] = file;
  };
  command
      .add_option_function<std::string>(
          "--json", take_json, "print only JSON (schemas/verdicts.schema.json), or write it to a file")
      ->expected(0, 1)
      ->option_text("[FILE]")
      ->excludes("--quiet");
}

void require_replaceable(const VerdictFiles& files) {
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (!files[i]) continue;
    require_folder_of(*files[i], kFormats[i].option);
    if (!fs::exists(fs::symlink_status(*files[i]))) continue;
    files::require_regular(*files[i]);
    files::InputFile in(*files[i], files::kMostOfText);
    const std::string_view found = in.next();
    if (!found.empty() && !found.starts_with(kFormats[i].start))
      throw UsageError("{}: exists and was not written by gaitslam; name another file, or remove it",
                       files[i]->string());
  }
}

void report_verdicts(const regression::Comparison& comparison, const VerdictFiles& files) {
  text_out() << regression::verdict_table(comparison, colours());
  if (output() == Output::json) std::cout << regression::verdicts_json(comparison);
  for (std::size_t i = 0; i < files.size(); ++i)
    if (files[i]) files::write_atomically(*files[i], kFormats[i].text(comparison));
}

}  // namespace cli
