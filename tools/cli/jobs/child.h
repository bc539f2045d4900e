// Runs other programs to their end.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace cli {

/// Runs argv[0], found by PATH, without a shell and without input. Throws std::runtime_error when it cannot
/// be started or does not end with exit code 0. It writes to our standard error.
void run_child(const std::vector<std::string>& argv);

/// A program that reads its standard input from us; otherwise as run_child, but that the first line that it
/// writes to its standard error is in the exception.
class FedChild {
 public:
  explicit FedChild(const std::vector<std::string>& argv);
  /// Ends its input and waits for its end, unless finish() did.
  ~FedChild();
  FedChild(const FedChild&) = delete;
  FedChild& operator=(const FedChild&) = delete;

  void write(std::string_view bytes);
  /// Ends its input and waits for its end.
  void finish();

 private:
  std::string name_;
  int process_ = 0, input_ = -1, errors_ = -1;
};

}  // namespace cli
