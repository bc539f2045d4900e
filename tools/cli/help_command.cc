// help: the page of a command, or a topic, which is a README or a section of one.
#include <iostream>

#include "tools/cli/commands.h"
#include "tools/cli/shared/options.h"

namespace cli {
namespace {

constexpr const char* kHelpExamples = "Examples:\n  gaitslam help run\n  gaitslam help ci";
constexpr const char* kTopicNames = "cache, ci, controller, estimator, exit-codes, formats, scenario, slurm";

struct Topic {
  std::string name, folder;
  std::string section{};  ///< a heading of the folder's README; empty for the whole file
};
const Topic kTopics[]{{"cache", "sim/trials", "## Recordings and their cache"},
                      {"ci", "sim/regression"},
                      {"controller", "sim/controllers"},
                      {"estimator", "sim/estimators"},
                      {"exit-codes", "tools", "## Exit codes"},
                      {"formats", "sim/export"},
                      {"scenario", "sim/scenario"},
                      {"slurm", "tools", "## Slurm"}};

struct HelpRequest {
  const CLI::App* program = nullptr;
  std::string word;
};

std::string text_of(const Topic& topic) {
  const std::string page = files::read_text(standard_models().parent_path() / topic.folder / "README.md");
  const std::size_t begin = page.find(topic.section), end = page.find("\n## ", begin + 1);
  return topic.section.empty() ? page : page.substr(begin, end - begin);
}

/// A topic takes precedence over a command of the same name, such as cache.
int help(HelpRequest& request) {
  const CLI::App* page = request.program;
  std::string name = page->get_name();
  if (const auto topic = std::ranges::find(kTopics, request.word, &Topic::name); topic != std::end(kTopics)) {
    std::cout << text_of(*topic);
    return 0;
  }
  if (!request.word.empty()) {
    const auto found =
        page->get_subcommands([&](const CLI::App* at) { return at->get_name() == request.word; });
    if (found.empty())
      throw UsageError("help: is '{}', expected a command or one of the topics {}", request.word,
                       kTopicNames);
    page = found[0], name += " " + request.word;
  }
  std::cout << page->get_formatter()->make_help(page, name, CLI::AppFormatMode::Normal);
  return 0;
}

}  // namespace

void add_help(CLI::App& app, int& exit_code) {
  auto [command, request] =
      add_command(app, exit_code, "help",
                  (std::string("Print the page of a command or of a topic: ") + kTopicNames).c_str(),
                  kHelpExamples, help);
  request.program = &app;
  command.add_option("word", request.word, "a command or a topic")->option_text("COMMAND|TOPIC");
}

}  // namespace cli
