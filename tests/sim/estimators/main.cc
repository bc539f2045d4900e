// The test program hosts the libraries that its tests name, as gaitslam does.
#include <gtest/gtest.h>

#include "sim/estimators/library_estimator.h"

int main(int argc, char** argv) {
  if (const auto exit_code = sim::estimators::hosted_library(argc, argv)) return *exit_code;
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
