#!/bin/sh
# Makes docs/statistics.md: how often the verdicts of `bench`, `ratio` and `regress` are wrong, and what they find. Simulated
# runs by the tests' long forms, real ones by the driver.
# Usage: statistics_evidence.sh BUILD OUT.md [--runs N] [--tiny]
#
# BUILD: a build directory with bin/crowdbench, bin/test_core and bin/test_bench. --runs: real A/A runs (200). --tiny: three
# real runs and no simulated ones, to see that it runs.
set -eu

fail() {
  echo "statistics_evidence: $*" >&2
  exit 2
}
[ $# -ge 2 ] || fail "usage: statistics_evidence.sh BUILD OUT.md [--runs N] [--tiny]"
build=$1
out=$2
shift 2
runs=200
tiny=
while [ $# -gt 0 ]; do
  case $1 in
    --runs) [ $# -ge 2 ] || fail "--runs needs a value"; runs=$2; shift ;;
    --tiny) tiny=yes; runs=3 ;;
    *) fail "'$1' is not an option" ;;
  esac
  shift
done
driver=$build/bin/crowdbench
[ -x "$driver" ] || fail "$driver is not there"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# The table that a test prints in its long form, without what the test framework says.
table() {
  CROWDBENCH_LONG_FORM=1 "$build/bin/$1" --gtest_filter="$2" >"$work/test" 2>&1 || { cat "$work/test" >&2; fail "$2 failed"; }
  grep '^|' "$work/test"
}

{
  printf '# How often verdicts are wrong\n\nMade by `tools/statistics_evidence.sh`. Simulated runs are simulated: a drift that a round shares, noise of\n'
  printf 'each frame, hitches (tests/bench/simulated_frames.h). Real runs were drawn by the device named below.\n'
  if [ -z "$tiny" ]; then
    printf '\n## Intervals on autocorrelated rounds\n\nShare of 95 %% intervals that hold the true median, 2,000 series each.\n\n'
    table test_core 'BlockBootstrap.KeepsItsCoverageUnderSerialCorrelation'
    printf '\n## A/A pairs, simulated\n\nRuns of 24 rounds each. What the verdict guarantees is at most 5 %% of false alarms: over 1,000 runs they lie\n'
    printf 'within the 95 %% binomial limits of 5 %%; 10,000 tell that the rate is below 5 %%, and outside of those limits on the careful side: exact\n'
    printf 'p values come in steps, and one run in twenty is taken to have rounds that are alike. "Detectable" is what `bench` and `ratio` print\n'
    printf '(80 %% power).\n\n'
    table test_bench 'Control.FalseAlarmsAreAtMostAsStatedAndThreePercentIsFound'
    printf '\n## `regress`, simulated\n\nNine times and one comparison a file, 24 rounds of frames that scatter by 2 %%; one time of nine is 3 %% slower; each run\n'
    printf 'is off besides. Least effect 1 %%, level 1 %%, Holm. Runs that differ much miss a slow-down of 3 %%: take more of them.\n\n'
    table test_bench 'Regress.PowerByRunsAndTheirScatter'
  fi
} >"$out.part"

echo "$runs real A/A runs" >&2
differ=0
run=0
while [ "$run" -lt "$runs" ]; do
  run=$((run + 1))
  "$driver" ratio --of mesh --to mesh --agents 20 --size 160x120 --pairs 24 --seed "$run" --json \
    --character mannequin:triangles=500 >"$work/ratio" 2>/dev/null || fail "ratio failed"
  # Of the member `control`: whether it differs, and what it would have found.
  awk '/"control"/ { inside = 1 } inside && /"differs"/ { print ($2 ~ /true/) ? 1 : 0; exit }' "$work/ratio" >>"$work/differs"
  awk '/"control"/ { inside = 1 } inside && /"detectable"/ { sub(",", "", $2); print $2; exit }' "$work/ratio" >>"$work/detectable"
done
differ=$(grep -c 1 "$work/differs" || true)
middle=$(sort -g "$work/detectable" | awk '{ v[NR] = $1 } END { printf "%.1f", 100 * v[int((NR + 1) / 2)] }')
renderer=$(awk -F'"' '/"renderer"/ { print $4; exit }' "$work/ratio")
{
  printf '\n## A/A pairs, real\n\nDrawn by %s. The control of %s runs of\n\n' "$renderer" "$runs"
  printf '    crowdbench ratio --of mesh --to mesh --agents 20 --size 160x120 --pairs 24 --character mannequin:triangles=500\n\n'
  # Exact: the counts that leave at most 2.5 % of a binomial at level 5 % on either side.
  limits=$(awk -v n="$runs" 'BEGIN {
    p = 0.95 ^ n
    for (k = 0; k <= n; ++k) {
      sum += p
      if (low == "" && sum > 0.025) low = k
      if (sum >= 0.975) { print low " to " k; exit }
      p *= (n - k) / (k + 1) * 0.05 / 0.95
    }
  }')
  printf 'with seeds 1 to %s differed in %s (%s; 95 %% limits of 5 %%: %s); median of the detectable change: %s %%.\n' "$runs" "$differ" \
    "$(awk -v n="$runs" -v k="$differ" 'BEGIN { printf "%.1f %%", 100 * k / n }')" "$limits" "$middle"
} >>"$out.part"
mv "$out.part" "$out"
