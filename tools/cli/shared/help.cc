#include "sim/files/text.h"
#include "tools/cli/commands.h"

GAITSLAM_EMBED(gaitslam_help, GAITSLAM_HELP)

std::pair<std::string, std::string> cli::help_of(const std::string& command) {
  const std::string text = sim::files::titled_lines(gaitslam_help(), command).value();
  const std::size_t end = text.find('\n') + 1;
  return {text.substr(0, end - 1), text.substr(end)};
}
