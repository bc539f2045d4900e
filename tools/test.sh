#!/bin/sh
# Builds and runs the tests: tools/test.sh [--long] [PRESET [ctest options]].
# PRESET is release (default), ci, dev, asan, tsan or no-world. --long adds the tests that take more than about 10 s each.
set -eu
labels="-LE long"
if [ "${1:-}" = --long ]; then
  labels=
  shift
fi
root=$(dirname "$(dirname "$(readlink -f "$0")")")
. "$root/tools/setup.sh"
preset=${1:-release}
[ $# -eq 0 ] || shift
install_packages "$root/tools/packages.txt" "$root/tools/packages_test.txt"
install_interop
build "$preset" tests/all
cd "$root"
exec ctest --preset "$preset" --no-tests=error -j "$(nproc)" $labels "$@"
