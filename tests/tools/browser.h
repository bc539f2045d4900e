// A page opened in headless Chromium.
#pragma once

#include <string>

namespace tests {

/// Returns the shell command that prints a page of this folder after its script ran and, on standard error,
/// the browser's console. No host name resolves: the page cannot load other files.
inline std::string browser_command(const std::string& page) {
  return "timeout 100 chromium --headless --no-sandbox --user-data-dir=profile --use-angle=swiftshader "
         "--enable-unsafe-swiftshader --host-resolver-rules='MAP * ~NOTFOUND' --enable-logging=stderr "
         "--window-size=1200,900 --virtual-time-budget=10000 --dump-dom \"file://$PWD/" +
         page + "\"";
}

}  // namespace tests
