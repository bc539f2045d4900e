#include <iostream>

#include "tools/cli/jobs/terminal.h"
#include "tools/cli/shared/view_session.h"

namespace cli {

void add_view_place(CLI::App& command, ViewPlace& place) {
  command.add_option("--port", place.port, "port of the view; 0: any free one")->capture_default_str();
  command
      .add_option("--address", place.address,
                  "listening address of the view; one that others can reach needs a --token")
      ->capture_default_str();
  command
      .add_option("--token", place.token,
                  "the secret in the view's URL, at least 22 letters, digits, - or _; random by default")
      ->envname(kViewToken);
}

void add_view(CLI::App& command, ViewRequest& request) {
  CLI::Option* const view =
      command.add_flag("--view", request.view, "show the walk live in the browser; prints a URL");
  command
      .add_flag("--control", request.control, "with --view: it may pause, step and slow down what it shows")
      ->needs(view);
  command.add_flag("--wait", request.wait, "with --view: start when it is open in a browser")->needs(view);
  command.add_flag("--next-follows", request.next_follows)->group("");
  add_view_place(command, request);
  for (const char* option : {"--port", "--address"}) command.get_option(option)->needs(view);
  request.opened = print_view;
}

// With --json, standard output is for the document.
void print_view(const std::string& url) {
  (output() == Output::text ? std::cout : std::cerr) << "view at " << url << std::endl;
}

std::vector<std::string> view_arguments(const ViewRequest& request) {
  std::vector<std::string> arguments{"--view",        "--next-follows", "--address",
                                     request.address, "--port",         std::to_string(request.port)};
  if (request.control) arguments.emplace_back("--control");
  if (request.wait) arguments.emplace_back("--wait");
  return arguments;
}

}  // namespace cli
