// Runs another program to its end.
#pragma once

#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace cli {

/// A program with input from us: argv[0], searched in PATH. Throws std::runtime_error, with the first line of
/// its standard error, if it cannot be started or its exit code is not 0.
class FedChild {
 public:
  explicit FedChild(const std::vector<std::string>& argv);
  /// Closes its input and waits for its exit, unless finish() did.
  ~FedChild();
  FedChild(const FedChild&) = delete;
  FedChild& operator=(const FedChild&) = delete;

  void write(std::string_view bytes);
  /// Ends its input and waits for its end.
  void finish();

 private:
  std::string name_;
  std::FILE *errors_, *input_;
};

}  // namespace cli
