#!/bin/sh
# What a machine with a GPU is asked, in eight minutes: its device, the pictures of the contract and golden tests against
# those of the software rasteriser, the tables of docs/figures.md, and frame times to 100,000 agents.
# Usage: gpu_check RESULTS [--device D] [--tiny]   (from an unpacked bundle of ./run gpu-check; needs sh, awk, coreutils)
#
# RESULTS is one folder of results, made here: summary.txt, device.txt, pictures.txt (how far each differs) and pictures/ (as
# drawn here, and the differences), figures.md, bench.sqlite, bench.txt, report.html. Exit status 1: a step failed or ran out of its time; the others are there.
# --tiny: to see that it runs, on a software rasteriser too.
#
# Eight minutes: every step has a limit of its own and at most what is left of all of them, and is interrupted then. `bench`
# keeps the points that it finished, figures.sh the tables; the summary says which step ran out of time.
set -u
self=$(readlink -f -- "$0")
here=${self%/*}

fail() {
  echo "gpu_check: $*" >&2
  exit 2
}
[ $# -ge 1 ] || fail "usage: gpu_check RESULTS [--device D] [--tiny]"
results=$1
shift
tiny=
while [ $# -gt 0 ]; do
  case $1 in
    --device) [ $# -ge 2 ] || fail "--device needs a value"; CROWDBENCH_DEVICE=$2; export CROWDBENCH_DEVICE; shift ;;
    --tiny) tiny=--tiny ;;
    *) fail "'$1' is not an option" ;;
  esac
  shift
done
mkdir -p "$results" || fail "cannot make $results"
results=$(cd "$results" && pwd)
[ ! -e "$results/summary.txt" ] || fail "$results holds the results of an earlier check; name another folder"
CROWDBENCH_CACHE_DIR=${CROWDBENCH_CACHE_DIR:-$results/cache}
export CROWDBENCH_CACHE_DIR

began=$(date +%s)
budget=465  # of 480 seconds
worst=0

# step NAME SECONDS OUTPUT COMMAND...: at most SECONDS, and what is left of all. An interrupted bench keeps its points.
step() {
  name=$1
  limit=$2
  output=$3
  shift 3
  start=$(date +%s)
  left=$((budget - (start - began)))
  [ "$left" -gt 5 ] || left=5
  [ "$limit" -lt "$left" ] || limit=$left
  echo "gpu_check: $name (at most $limit s)" >&2
  status=0
  timeout -s INT -k 5 "$limit" "$@" >"$results/$output" 2>"$results/$output.err" || status=$?
  took=$(($(date +%s) - start))
  case $status in
    0) said=fine ;;
    124 | 130 | 137) said="out of time" ;;
    *) said="status $status: $(tail -n 1 "$results/$output.err")" ;;
  esac
  [ -s "$results/$output.err" ] || rm -f "$results/$output.err"
  [ "$status" -eq 0 ] || worst=1
  printf '%-10s %4d s  %s\n' "$name" "$took" "$said" | tee -a "$results/summary.txt"
  return 0
}

# ---- the device -------------------------------------------------------------------------------------------------------

step device 60 device.txt "$here/crowdbench" info
cat "$results/device.txt"
[ "$worst" -eq 0 ] || fail "no device draws here: $(cat "$results/device.txt.err" 2>/dev/null)"
if [ -z "$tiny" ] && grep -q 'a software rasteriser' "$results/device.txt"; then
  rm "$results/summary.txt"
  fail "this device is a software rasteriser; on a GPU machine its EGL driver is missing (--device N chooses another)"
fi

# ---- pictures ---------------------------------------------------------------------------------------------------------

# The tests' own tolerance is what another driver's rasterisation may change (tests/support/picture_comparison.h).
filter='*GoldenGl.*:*ContractGl.*'
[ -z "$tiny" ] || filter='*GoldenGl.IsWhatItWas/mesh:*GoldenGl.IsWhatItWas/rigid:*ContractGl.IsAsNearToTheMeshAsItsBound/mesh'
CROWDBENCH_TEST_DATA=$here/tests/data
CROWDBENCH_TEST_PICTURES=$results/pictures
export CROWDBENCH_TEST_DATA CROWDBENCH_TEST_PICTURES
step pictures 120 pictures.txt "$here/test_renderers" --gtest_filter="$filter" --gtest_color=no

# ---- frame times and figures ------------------------------------------------------------------------------------------

if [ -n "$tiny" ]; then
  set -- --agents 1,20 --size 160x120 --rounds 10 --no-floors --minutes 1 --representation flat:views=sphere-8x2,frames=4
else
  set -- --agents 1,10,100,1000,10000,100000 --size 1280x720 --minutes 2
fi
step bench 180 bench.txt "$here/crowdbench" bench "$@" --occupancy 0.15 --out "$results/bench.sqlite"
[ ! -e "$results/bench.sqlite" ] ||
  step report 30 report.txt "$here/crowdbench" report "$results/bench.sqlite" --out "$results/report.html"
# shellcheck disable=SC2086
step figures 300 figures.txt "$here/figures.sh" "$here/crowdbench" "$results/figures.md" $tiny

[ "$CROWDBENCH_CACHE_DIR" != "$results/cache" ] || rm -rf "$results/cache"
printf '%-10s %4d s\n' all $(($(date +%s) - began)) | tee -a "$results/summary.txt"
echo "gpu_check: the results are in $results" >&2
exit "$worst"
