#!/bin/sh
# A batch estimator: reads an exported recording and writes a trajectory. It takes the walking plan for the truth.
#
#     tools/gaitslam evaluate RESULT... --format tum --command 'tools/examples/plan_alone.sh {folder} {trajectory}'
set -eu
grep -v '^#' "$1/plan.txt" >"$2"
