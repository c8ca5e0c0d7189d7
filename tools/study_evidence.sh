#!/bin/sh
# Makes docs/study-evidence.md: how often the analysis of simulated answers is right. The rows are what the tests of
# tests/studies/recovery_test.cpp and, from an export's folder on, tests/bench/study_simulation_test.cpp print, over more seeds than
# they take in the normal run.
# Usage: study_evidence.sh BUILD OUT.md [--seeds N] [--kills N] [--part NAME]...
#
# BUILD: a build directory with bin/test_studies, bin/test_bench and bin/crowdbench. --seeds: simulated studies a row (500).
# --kills: of the study's server while simulated clients answer (1000).
# --part: this part alone is made anew, and the others stay as OUT.md has them; without it, all. A part takes less than 20
# minutes of two cores: intervals, participants, clips, exports, quest, power, server.
set -eu

all='intervals participants clips exports quest power server'
fail() {
  echo "study_evidence: $*" >&2
  exit 2
}
[ $# -ge 2 ] || fail "usage: study_evidence.sh BUILD OUT.md [--seeds N] [--kills N] [--part NAME]..."
build=$1
out=$2
shift 2
seeds=500
kills=1000
parts=
while [ $# -gt 0 ]; do
  case $1 in
    --seeds) [ $# -ge 2 ] || fail "--seeds needs a value"; seeds=$2; shift ;;
    --kills) [ $# -ge 2 ] || fail "--kills needs a value"; kills=$2; shift ;;
    --part)
      [ $# -ge 2 ] || fail "--part needs a value"
      case " $all " in *" $2 "*) parts="$parts $2" ;; *) fail "there is no part '$2'; there are $all" ;; esac
      shift ;;
    *) fail "'$1' is not an option" ;;
  esac
  shift
done
for tests in studies bench; do
  [ -x "$build/bin/test_$tests" ] || fail "$build/bin/test_$tests is not there"
done
if [ -n "$parts" ] && ! grep -q '^<!-- part ' "$out" 2>/dev/null; then
  fail "$out has no parts yet: make all of them first, without --part"
fi
[ -n "$parts" ] || parts=$all
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# The rows that tests of a program, studies or bench, print. A test that fails is said in the page: its rows stand there for what
# they are.
rows() {
  CROWDBENCH_SEEDS=$seeds "$build/bin/test_$1" --gtest_filter="$2" >"$work/test" 2>&1 ||
    grep 'FAILED  \] Rec' "$work/test" | sort -u >>"$work/failed"
  grep '^|' "$work/test"
}

intervals_head='| what | found | share | nominal | limits |
|---|--:|--:|--:|--:|'

part() {
  case $1 in
    intervals)
      printf '## Intervals and verdicts\n\nHow often 95 %% intervals hold the truth, and what is called equivalent. "Limits": between which a\n'
      printf 'count lies 95 times of 100 where the nominal share is true.\n\n%s\n' "$intervals_head"
      rows studies 'Recovery.ThresholdOfMixed*:Recovery.ThresholdOfPsycho*:Recovery.Differences*:Recovery.Equivalent*' ;;
    participants)
      printf '## Thresholds over few and many participants\n\n%s\n' "$intervals_head"
      rows studies 'Recovery.ThresholdOverFewParticipants*' ;;
    clips)
      printf '## Thresholds over few and many clips\n\nClips that differ (standard deviation in logits), and clips that do not.\n\n%s\n' \
        "$intervals_head"
      rows studies 'Recovery.ThresholdOverFewClips*' ;;
    exports)
      printf '## From an exported folder to the interval\n\n%s\n' "$intervals_head"
      rows bench 'RecoveredStudyTest.*' ;;
    quest)
      printf '## QUEST+ against constant stimuli\n\nThresholds drawn anew for each study; both read as the same posterior: the width of its 95 %% interval,\n'
      printf 'the error of its mean (medians), and how often the interval holds the truth.\n\n'
      printf '| method | trials | width | error | held |\n|---|--:|--:|--:|--:|\n'
      rows studies 'Recovery.QuestPlus*' ;;
    power)
      printf '## Power of the mixed model\n\nBeside the same simulation by lme4 (1,000 studies a row).\n\n'
      printf '| design | observers | power | lme4 |\n|---|--:|--:|--:|\n'
      rows studies 'Recovery.Power*' ;;
    server)
      printf '## A server that is killed\n\nBy SIGKILL at random moments, started again each time: `tools/study_kill.mjs`.\n\n'
      node "$(dirname "$0")/study_kill.mjs" "$build/bin/crowdbench" "$work/kills" --kills "$kills" >"$work/killed" ||
        echo '[ ] A server that is killed' >>"$work/failed"
      sed '/^[0-9]* kills, /d; s/^/    /' "$work/killed" ;;
  esac
  [ "$1" = server ] || printf '\n%s simulated studies a row.\n' "$seeds"
  if [ -s "$work/failed" ]; then
    printf '\nOutside of what the tests demand:\n\n'
    sed 's/.*\] /- /; s/ (.*//' "$work/failed"
  fi
}

{
  printf '# How often the analysis of a study is right\n\nMade by `tools/study_evidence.sh`, which makes each part alone, too (`--part`). '
  printf 'All observers are simulated; nobody was asked\nanything.\n'
  for name in $all; do
    printf '\n<!-- part %s -->\n' "$name"
    case " $parts " in
      *" $name "*)
        : >"$work/failed"
        part "$name" ;;
      *) sed -n "/^<!-- part $name -->\$/,/^<!-- part /{/^<!-- part /d;p}" "$out" | sed '$!b;/^$/d' ;;
    esac
  done
} >"$out.part"
mv "$out.part" "$out"
