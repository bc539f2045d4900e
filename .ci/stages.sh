# Sourced by .ci/run and .ci/nightly: `stage NAME` starts a stage; the seconds of each are printed at the end.
set -eu
export CI=true  # a missing tool is an error, not a skipped test
root=$PWD
# Tests, regression and front page walk some seeds of the same scenarios: once each.
export GAITSLAM_SHARED_CACHE="$root/build/ci/cache"
. tools/setup.sh

stages='' current=''
end_stage() {
  [ -z "$current" ] || stages="$stages$(printf '%6d s  %s' $(($(date +%s) - started)) "$current$1")
"
}
stage() {
  end_stage ''
  current=$1 started=$(date +%s)
  echo "== $1"
}
report() {
  code=$?
  [ "$code" = 0 ] && end_stage '' || end_stage ": FAILED, exit code $code"
  printf '== stages\n%s' "$stages"
  exit "$code"
}
trap report EXIT
trap 'exit 130' INT TERM

stage packages
install_packages tools/packages.txt tools/packages_test.txt
install_interop
