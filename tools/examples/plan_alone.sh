#!/bin/sh
# A batch estimator: reads an exported recording and outputs the walking plan as its trajectory.
#
#     tools/gaitslam evaluate RESULT... --format tum --command 'tools/examples/plan_alone.sh {folder} {trajectory}'
set -eu
grep -v '^#' "$1/plan.txt" >"$2"
