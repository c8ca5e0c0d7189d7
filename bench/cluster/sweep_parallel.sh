#!/bin/sh
# The shards of a sweep under GNU parallel, and their merge.
#
#   bench/cluster/sweep_parallel.sh PLAN.toml SHARDS OUT.sqlite [JOBS] [PARALLEL_ARGUMENTS...]
#
# JOBS at once, 1 where it is not said: shards on one machine disturb each other's times. Further arguments are parallel's:
# `--sshlogin a,b` gives them to other machines, which must see the same folder. CROWDBENCH: the program, else on the PATH.
set -eu
[ $# -ge 3 ] || { sed -n '2,7s/^# \{0,1\}//p' "$0" >&2; exit 2; }
plan=$1 shards=$2 out=$3 jobs=${4:-1}
shift 3
[ $# -eq 0 ] || shift
export CROWDBENCH=${CROWDBENCH:-crowdbench} PLAN=$plan SHARDS=$shards STEM=${out%.*}

# A shard that ends with 75 is run again; 1 says that points failed, which are rows like the others.
run='
while :; do
  status=0
  "$CROWDBENCH" sweep "$PLAN" --shard "{}/$SHARDS" --out "$STEM-{}-of-$SHARDS.sqlite" >/dev/null || status=$?
  [ "$status" -eq 75 ] || break
  sleep 1
done
[ "$status" -le 1 ]'
seq "$shards" | parallel --jobs "$jobs" --env CROWDBENCH --env PLAN --env SHARDS --env STEM "$@" "$run"

set --
for shard in $(seq "$shards"); do set -- "$@" "$STEM-$shard-of-$SHARDS.sqlite"; done
exec "$CROWDBENCH" merge "$out" "$@"
