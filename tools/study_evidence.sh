#!/bin/sh
# Makes docs/study-evidence.md: how often the analysis of simulated answers is right. The rows are what the tests of
# tests/studies/recovery_test.cpp and, from an export's folder on, tests/bench/study_simulation_test.cpp print, over more seeds than
# they take in the normal run.
# Usage: study_evidence.sh BUILD OUT.md [--seeds N] [--kills N]
#
# BUILD: a build directory with bin/test_studies, bin/test_bench and bin/crowdbench. --seeds: simulated studies a row (500).
# --kills: of the study's server while simulated clients answer (1000).
set -eu

fail() {
  echo "study_evidence: $*" >&2
  exit 2
}
[ $# -ge 2 ] || fail "usage: study_evidence.sh BUILD OUT.md [--seeds N] [--kills N]"
build=$1
out=$2
shift 2
seeds=500
kills=1000
while [ $# -gt 0 ]; do
  case $1 in
    --seeds) [ $# -ge 2 ] || fail "--seeds needs a value"; seeds=$2; shift ;;
    --kills) [ $# -ge 2 ] || fail "--kills needs a value"; kills=$2; shift ;;
    *) fail "'$1' is not an option" ;;
  esac
  shift
done
for tests in studies bench; do
  [ -x "$build/bin/test_$tests" ] || fail "$build/bin/test_$tests is not there"
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# The rows that tests of a program, studies or bench, print. A test that fails is said in the page: its rows stand there for what
# they are.
rows() {
  CROWDBENCH_SEEDS=$seeds "$build/bin/test_$1" --gtest_filter="$2" >"$work/test" 2>&1 ||
    grep 'FAILED  \] Rec' "$work/test" | sort -u >>"$work/failed"
  grep '^|' "$work/test"
}

: >"$work/failed"
{
  printf '# How often the analysis of a study is right\n\nMade by `tools/study_evidence.sh`: %s simulated studies a row. ' "$seeds"
  printf 'All observers are simulated; nobody was asked anything.\n'
  printf '\n## Intervals and verdicts\n\nHow often 95 %% intervals hold the truth, and what is called equivalent. "Limits": between which a\n'
  printf 'count lies 95 times of 100 where the nominal share is true.\n\n'
  printf '| what | found | share | nominal | limits |\n|---|--:|--:|--:|--:|\n'
  rows studies 'Recovery.Threshold*:Recovery.Differences*:Recovery.Equivalent*'
  rows bench 'RecoveredStudyTest.*'
  printf '\n## QUEST+ against constant stimuli\n\nThresholds drawn anew for each study; both read as means of the same posterior.\n\n'
  printf '| method | trials | median error of the threshold |\n|---|--:|--:|\n'
  rows studies 'Recovery.QuestPlus*'
  printf '\n## Power of the mixed model\n\nBeside the same simulation by lme4 (1,000 studies a row).\n\n'
  printf '| design | observers | power | lme4 |\n|---|--:|--:|--:|\n'
  rows studies 'Recovery.Power*'
  printf '\n## A server that is killed\n\nBy SIGKILL at random moments, started again each time: `tools/study_kill.mjs`.\n\n'
  node "$(dirname "$0")/study_kill.mjs" "$build/bin/crowdbench" "$work/kills" --kills "$kills" >"$work/killed" ||
    echo '[ ] A server that is killed' >>"$work/failed"
  sed '/^[0-9]* kills, /d; s/^/    /' "$work/killed"
} >"$out.part"
if [ -s "$work/failed" ]; then
  { printf '\n## Outside of what the tests demand\n\n'; sed 's/.*\] /- /; s/ (.*//' "$work/failed"; } >>"$out.part"
fi
mv "$out.part" "$out"
