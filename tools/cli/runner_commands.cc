#include "tools/cli/commands.h"

std::vector<cli::AddCommand*> cli::commands() {
  return {add_run, add_record, add_replay, add_check, add_config, add_element};
}
