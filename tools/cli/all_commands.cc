#include "tools/cli/commands.h"

std::vector<cli::AddCommand*> cli::commands() {
  return {add_run,    add_record,  add_replay,  add_evaluate, add_export,   add_view_command,
          add_video,  add_score,   add_regress, add_compare,  add_baseline, add_sweep,
          add_trials, add_element, add_tune,    add_check,    add_report,   add_reproduce,
          add_cache,  add_config,  add_robot,   add_walker,   add_help};
}
