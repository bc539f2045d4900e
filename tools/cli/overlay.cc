#include "tools/cli/commands.h"

namespace cli {

void add_with(CLI::App* command, sim::bench::Changes& changes) {
  command
      ->add_option(
          "--with", changes.with,
          "YAML file of keys that are set anew, as the best.yaml of a tuning; more than once: in that order")
      ->option_text("FILE")
      ->allow_extra_args(false);
}

}  // namespace cli
