// A page opened in headless Chromium, as a reader does.
#pragma once

#include <string>

namespace tests {

/// The shell command that prints a page of this folder as it is after its script ran, and on standard error
/// what the page said on the browser's console. Names are resolved nowhere: what is not in the file is not
/// there.
inline std::string browser_command(const std::string& page) {
  return "timeout 100 chromium --headless --no-sandbox --user-data-dir=profile --use-angle=swiftshader "
         "--enable-unsafe-swiftshader --host-resolver-rules='MAP * ~NOTFOUND' --enable-logging=stderr "
         "--window-size=1200,900 --virtual-time-budget=10000 --dump-dom \"file://$PWD/" +
         page + "\"";
}

}  // namespace tests
