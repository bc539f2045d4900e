// help: the page of a command, or a topic, which is a README or a section of one.
#include <iostream>
#include <map>

#include "tools/cli/commands.h"
#include "tools/cli/shared/options.h"

namespace cli {
namespace {

constexpr const char* kHelpExamples = R"(Examples:
  gaitslam help
  gaitslam help robot init
  gaitslam help ci)";

struct Topic {
  const char *folder, *section = "";  ///< the section's heading; empty for the whole README
};
const std::map<std::string, Topic> kTopics{{"cache", {"sim/trials", "## Recordings and their cache"}},
                                           {"ci", {"sim/regression"}},
                                           {"controller", {"sim/controllers"}},
                                           {"estimator", {"sim/estimators"}},
                                           {"exit-codes", {"tools", "## Exit codes"}},
                                           {"formats", {"sim/export"}},
                                           {"scenario", {"sim/scenario"}},
                                           {"slurm", {"tools", "## Slurm"}}};

std::string topics() {
  std::string names;
  for (const auto& [name, topic] : kTopics) names += (names.empty() ? "" : ", ") + name;
  return names;
}

struct HelpRequest {
  const CLI::App* program = nullptr;
  std::vector<std::string> words;
};

std::string text_of(const Topic& topic) {
  const std::string page = files::read_text(standard_models().parent_path() / topic.folder / "README.md");
  const std::size_t begin = page.find(topic.section), end = page.find("\n## ", begin + 1);
  return *topic.section ? page.substr(begin, end - begin) : page;
}

int help(HelpRequest& request) {
  const CLI::App* page = request.program;
  std::string name = page->get_name();
  for (const std::string& word : request.words) {
    if (const auto topic = kTopics.find(word); topic != kTopics.end() && request.words.size() == 1) {
      std::cout << text_of(topic->second);
      return 0;
    }
    const auto found =
        page->get_subcommands([&](const CLI::App* command) { return command->get_name() == word; });
    if (found.empty()) throw UsageError("help: is '{}', expected a command or one of {}", word, topics());
    page = found.front(), name += " " + word;
  }
  std::cout << page->get_formatter()->make_help(page, name, CLI::AppFormatMode::Normal);
  return 0;
}

}  // namespace

void add_help(CLI::App& app, int& exit_code) {
  auto [command, request] =
      add_command(app, exit_code, "help", ("Print the page of a command or of a topic: " + topics()).c_str(),
                  kHelpExamples, help);
  request.program = &app;
  command.add_option("words", request.words, "a command or a topic")->option_text("COMMAND|TOPIC");
}

}  // namespace cli
