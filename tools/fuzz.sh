#!/bin/sh
# Runs the fuzz targets of tests/fuzz with clang's libFuzzer, on all processors, and prints a table:
#   tools/fuzz.sh [--fast] [--seconds S | --runs N] [--seed N] [--slow S] [TARGET...]
# Each target runs for S seconds (default 3600) or N inputs. Findings are crashes, inputs that take more than 1 s (--slow sets
# another limit), and inputs that need more than 1 GB of memory; they are kept in build/fuzz/found. Inputs that reach new code are
# kept in build/fuzz/corpus. --seed fixes the random numbers. --fast omits the address sanitizer and samples the corpus uniformly;
# afterwards, --runs 0 runs all of build/fuzz/corpus once under the sanitizers. Exit code 1: there was a finding.
set -eu
root=$(dirname "$(dirname "$(readlink -f "$0")")")
limit=-max_total_time=3600 seed=0 slow=1 preset=fuzz entropic=1
while :; do
  case ${1:-} in
    --fast) preset=fuzz-fast entropic=0 && shift && continue ;;
    --seconds) limit=-max_total_time=$2 ;;
    --runs) limit=-runs=$2 ;;
    --seed) seed=$2 ;;
    --slow) slow=$2 ;;
    -*) echo "fuzz: $1: unknown option; expected --fast, --seconds S, --runs N, --seed N, --slow S or targets" >&2 && exit 2 ;;
    *) break ;;
  esac
  shift 2
done
. "$root/tools/setup.sh"
install_packages "$root/tools/packages.txt" "$root/tools/packages_test.txt"
build "$preset" fuzz
program=$root/build/$preset/fuzz
known=$("$program")
targets=${*:-$known}
for target in $targets; do
  echo "$known" | grep -qx "$target" || { echo "fuzz: $target: unknown target, expected one of" $known >&2; exit 2; }
done
folder=$root/build/fuzz
mkdir -p "$folder/found" "$folder/log"

memory=$(mktemp -d -p "$([ -w /dev/shm ] && echo /dev/shm || echo "${TMPDIR:-/tmp}")" gaitslam-fuzz-XXXXXX)
trap 'rm -rf "$memory"' EXIT
trap 'exit 2' INT TERM
export TMPDIR="$memory" folder root limit seed slow program entropic
export ASAN_OPTIONS=quarantine_size_mb=16:detect_leaks=1 UBSAN_OPTIONS=print_stacktrace=1
export GLIBC_TUNABLES=glibc.malloc.trim_threshold=67108864  # memory freed by one input is kept for the next one

# Runs one target; its log contains libFuzzer's statistics. libFuzzer exits with 72 on SIGINT and SIGTERM.
cat >"$memory/one" <<'ONE'
mkdir -p "$folder/corpus/$1" "$folder/found/$1"
status=0 more=
[ "$1" != scenario ] || more=$root/scenarios
"$program" "$1" "$folder/corpus/$1" $more "$limit" -seed="$seed" -entropic=$entropic \
  -timeout="$slow" -max_len=4096 -rss_limit_mb=1024 -print_final_stats=1 -artifact_prefix="$folder/found/$1/" \
  >"$folder/log/$1" 2>&1 || status=$?
[ "$status" = 0 ] || echo "ended with $status" >>"$folder/log/$1"
ONE
printf '%s\n' $targets | xargs -P "$(nproc)" -I{} sh "$memory/one" {}

figure() { sed -n "s/^stat::$2: *//p" "$folder/log/$1" | tail -n 1; }
findings=0
printf '%-14s %12s %9s %9s %8s  %s\n' target inputs 'per s' 'code' 'peak MB' result
for target in $targets; do
  log=$folder/log/$target
  result='nothing found'
  if grep -q '^ended with 72$' "$log"; then
    result='nothing found before it was interrupted'
  elif grep -q '^ended with' "$log"; then
    findings=$((findings + 1))
    result=$(sed -n 's/^SUMMARY: //p' "$log" | tail -n 1)
    result="FOUND ${result:-$(tail -n 1 "$log")}: build/fuzz/found/$target"
  fi
  code=$(sed -n 's/.* cov: \([0-9]*\).*/\1/p' "$log" | tail -n 1)
  printf '%-14s %12s %9s %9s %8s  %s\n' "$target" "$(figure "$target" number_of_executed_units)" \
    "$(figure "$target" average_exec_per_sec)" "${code:--}" "$(figure "$target" peak_rss_mb)" "$result"
done
echo "$findings findings"
[ "$findings" = 0 ]
