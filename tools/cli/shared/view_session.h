// Options of the view in the browser. The runner, which is built without the view, has a stub of it.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "sim/view/session.h"

namespace cli {

using sim::view::view_of_replay;
using sim::view::view_of_run;
using sim::view::ViewPlace;
using sim::view::ViewRequest;

/// --address, --port and --token.
void add_view_place(CLI::App& command, ViewPlace& place);
/// Also --view, --control and --wait. An opened view prints its URL.
void add_view(CLI::App& command, ViewRequest& request);
void print_view(const std::string& url);

/// Arguments for a process that shows its walk as one of several. The token is in the environment, which
/// other users of the machine cannot read.
inline constexpr const char* kViewToken = "GAITSLAM_VIEW_TOKEN";
std::vector<std::string> view_arguments(const ViewRequest& request);

}  // namespace cli
