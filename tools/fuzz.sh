#!/bin/sh
# Runs the fuzz targets of tests/fuzz with clang's libFuzzer, on all processors, and prints a table:
#   tools/fuzz.sh [--fast] [--seconds S | --runs N | --total N] [--longest BYTES] [--seed N] [--slow S] [TARGET...]
# Each target runs for S seconds (default 3600) or N inputs; --total counts the inputs of earlier commands too, so that rerunning
# the command resumes a campaign. Findings are crashes, inputs that take more than 1 s (--slow: another limit) and more than
# 1 GB of memory; their inputs are kept in build/fuzz/found. Inputs that reach new code are kept in build/fuzz/corpus. --longest
# limits the length of inputs (default 4096). --seed fixes the random numbers. --fast leaves the address sanitizer out and draws
# from the corpus uniformly; --runs 0 then runs all of build/fuzz/corpus once under the sanitizers. Exit code 1: a finding.
set -eu
root=$(dirname "$(dirname "$(readlink -f "$0")")")
limit=-max_total_time=3600 total='' longest=4096 seed=0 slow=1 preset=fuzz entropic=1
while :; do
  case ${1:-} in
    --fast) preset=fuzz-fast entropic=0 && shift && continue ;;
    --seconds) limit=-max_total_time=$2 ;;
    --runs) limit=-runs=$2 ;;
    --total) total=$2 ;;
    --longest) longest=$2 ;;
    --seed) seed=$2 ;;
    --slow) slow=$2 ;;
    -*) echo "fuzz: $1 is not known; expected --fast, --seconds S, --runs N, --total N, --longest BYTES, --seed N, --slow S or targets" >&2 && exit 2 ;;
    *) break ;;
  esac
  shift 2
done
. "$root/tools/setup.sh"
install_packages "$root/tools/packages.txt" "$root/tools/packages_test.txt"
targets=${*:-$(cd "$root/tests/fuzz" && ls ./*.cc | sed 's|^\./||; s|\.cc$||')}
build "$preset" $(printf 'fuzz_%s ' $targets)
folder=$root/build/fuzz
mkdir -p "$folder/found" "$folder/log"

memory=$(mktemp -d -p "$([ -w /dev/shm ] && echo /dev/shm || echo "${TMPDIR:-/tmp}")" gaitslam-fuzz-XXXXXX)
trap 'rm -rf "$memory"' EXIT
trap 'exit 2' INT TERM
export TMPDIR="$memory" folder root limit total longest seed slow preset entropic
export ASAN_OPTIONS=quarantine_size_mb=16:detect_leaks=1 UBSAN_OPTIONS=print_stacktrace=1
export GLIBC_TUNABLES=glibc.malloc.trim_threshold=67108864  # memory that an input frees is kept for the next one

# One target, with --total a million inputs at a time; its log has libFuzzer's figures.
cat >"$memory/one" <<'ONE'
program=$root/build/$preset/tests/fuzz/fuzz_$1
log=$folder/log/$1
count=$folder/count/$1-$(sha256sum "$program" | cut -c1-16)
mkdir -p "$folder/corpus/$1" "$folder/found/$1" "$folder/count"
begin=$(date +%s) had=0
[ -z "$total" ] || had=$(cat "$count" 2>/dev/null || echo 0)
now=$had
while :; do
  if [ -n "$total" ]; then
    left=$((total - now))
    [ "$left" -gt 0 ] || break
    limit=-runs=$((left < 1000000 ? left : 1000000))
  fi
  status=0
  random=$((seed ? seed + now : 0))  # each part its own; for 0 libFuzzer draws one
  "$program" "$folder/corpus/$1" "$root/tests/fuzz/corpus/$1" "$limit" -seed=$random -entropic=$entropic -timeout="$slow" \
    -max_len="$longest" -rss_limit_mb=1024 -print_final_stats=1 -artifact_prefix="$folder/found/$1/" >"$log" 2>&1 || status=$?
  case $status in
    0) ;;
    72) echo "interrupted" >>"$log" ;;  # libFuzzer's word for SIGINT and SIGTERM
    *) echo "ended with $status" >>"$log" ;;
  esac
  [ -n "$total" ] || break
  ran=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log" | tail -n 1)
  now=$((now + ${ran:-0}))
  echo "$now" >"$count.$$" && mv "$count.$$" "$count"
  [ "$status" = 0 ] || break
  echo "fuzz: $1: $now of $total inputs, $(((total - now) * ($(date +%s) - begin) / (now - had) / 60)) min left" >&2
done
[ -z "$total" ] || echo "stat::number_of_executed_units: $now" >>"$log"
ONE
printf '%s\n' $targets | xargs -P "$(nproc)" -I{} sh "$memory/one" {}

figure() { sed -n "s/^stat::$2: *//p" "$folder/log/$1" | tail -n 1; }
findings=0
printf '%-14s %12s %9s %9s %8s  %s\n' target inputs 'per s' 'code' 'peak MB' result
for target in $targets; do
  log=$folder/log/$target
  result='nothing found'
  if grep -q '^interrupted$' "$log"; then result='nothing found until it was interrupted'; fi
  if grep -q '^ended with' "$log"; then
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
