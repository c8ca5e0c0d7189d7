#!/bin/bash
# A sweep under a real Slurm on this machine, held to the same sweep without it: 1, 4 and 16 shards; one task killed in the middle
# and handed in again. As root, with Debian's slurm-wlm and munge (packages.txt, [slurm]); everything else is in a folder that
# is removed at the end.
#
#   bench/cluster/slurm_test.sh DRIVER [SHARDS...]
set -euo pipefail
driver=$(readlink -f "${1:?usage: slurm_test.sh DRIVER [SHARDS...]}")
shift
[ $# -gt 0 ] || set -- 1 4 16
[ "$(id -u)" -eq 0 ] || { echo "slurm_test: needs root, to start Slurm's daemons" >&2; exit 2; }
for program in slurmctld slurmd sbatch munged; do
  command -v "$program" >/dev/null || [ -x "/usr/sbin/$program" ] || { echo "slurm_test: $program is missing" >&2; exit 2; }
done
PATH=$PATH:/usr/sbin
work=$(mktemp -d)
pids=()
end() {
  [ ${#pids[@]} -eq 0 ] || kill "${pids[@]}" 2>/dev/null || true
  [ ! -f "$work/munged.pid" ] || kill "$(cat "$work/munged.pid")" 2>/dev/null || true
  wait 2>/dev/null || true
  rm -rf "$work"
}
trap end EXIT

# ---- a cluster of one node

if ! munge -n </dev/null >/dev/null 2>&1; then
  install -d -o munge -g munge -m755 /run/munge
  install -o munge -g munge -m644 /dev/null "$work/munged.pid"
  chmod 755 "$work"
  runuser -u munge -- "$(command -v munged)" --pid-file="$work/munged.pid" --force
fi
mkdir "$work/state" "$work/spool"
cpus=$(nproc)
cat >"$work/slurm.conf" <<CONF
ClusterName=local
SlurmctldHost=$(hostname -s)(127.0.0.1)
AuthType=auth/munge
SlurmUser=root
SlurmdUser=root
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/ctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/ctld.log
SlurmdLogFile=$work/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
ReturnToService=2
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerType=sched/backfill
SchedulerParameters=batch_sched_delay=0,sched_min_interval=0,bf_interval=1
NodeName=$(hostname -s) NodeAddr=127.0.0.1 CPUs=$cpus RealMemory=1000 State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
CONF
export SLURM_CONF=$work/slurm.conf
slurmctld -D -c >/dev/null 2>&1 &
pids+=($!)
slurmd -D >/dev/null 2>&1 &
pids+=($!)
for _ in $(seq 300); do
  [ "$(sinfo -h -o %T 2>/dev/null || true)" != idle ] || break
  sleep 0.1
done
[ "$(sinfo -h -o %T)" = idle ] || { echo "slurm_test: the node does not come up" >&2; tail -n 5 "$work"/*.log >&2; exit 1; }

# ---- the sweep

cat >"$work/p.toml" <<PLAN
[scenario]
width = 64
height = 48
[[scenario.character]]
source = "mannequin:triangles=500"
[axes]
crowd.agents = { from = 1, to = 16, steps = 16 }
representation = ["mesh", "mesh:triangles=250"]
[measure]
rounds = 100000
time_limit_s = 0.2
scores = ["mae", "psnr"]
PLAN
export CROWDBENCH_CACHE_DIR=$work/cache CROWDBENCH_DEVICE=software
cd "$work"
wait_for_jobs() {
  for _ in $(seq 6000); do
    [ -n "$(squeue -h 2>/dev/null)" ] || return 0
    sleep 0.1
  done
  echo "slurm_test: jobs do not end" >&2
  squeue >&2
  exit 1
}
# What a file holds of each point, times left out.
held() {
  node -e '
    const rows = JSON.parse(require("fs").readFileSync(0))
    const scores = new Map(rows.comparisons.map((c) => [c.id, c.scores]))
    for (const p of rows.sweep_points)
      console.log(p.condition, p.role, p.point_key, p.state, JSON.stringify(scores.get(p.comparison) ?? null))'
}
"$driver" sweep p.toml --out alone.sqlite --json 2>/dev/null | held >wanted
faults=0
for shards in "$@"; do
  rm -f p-*.log
  "$driver" sweep p.toml --out "k$shards.sqlite" --slurm "$shards" --submit >submitted
  if [ "$shards" -gt 1 ]; then
    # One task is killed in the middle of its work; the merge then lacks it. The first that has begun its file:
    task=
    for _ in $(seq 600); do
      task=$(pgrep -f -- "--out $work/k$shards-[0-9]+-of-" | head -n 1) || true
      ! compgen -G "$work/k$shards-*.partial" >/dev/null || [ -z "$task" ] || break
      sleep 0.05
    done
    [ -n "$task" ] || { echo "slurm_test: no task runs" >&2; tail -n 3 p-*.log >&2; exit 1; }
    kill -9 "$task"
    wait_for_jobs
    if [ -f "k$shards.sqlite" ]; then
      echo "slurm_test: merged although a task was killed (it had ended before)" >&2
    else
      grep -q missing p-merge.log || { echo "slurm_test: the merge does not say what is missing" >&2; faults=1; }
    fi
    sbatch --wait "k$shards.sbatch" >/dev/null || true
    wait_for_jobs
    sbatch --wait "k$shards-merge.sbatch" >/dev/null || true
  fi
  wait_for_jobs
  # Without the merged file the driver would measure it itself.
  if [ -f "k$shards.sqlite" ] && "$driver" sweep p.toml --out "k$shards.sqlite" --json 2>/dev/null | held | cmp -s - wanted; then
    echo "$shards shards: the same $(wc -l <wanted) rows as without Slurm"
  else
    echo "$shards shards: other rows than without Slurm" >&2
    tail -n 3 p-*.log >&2 || true
    faults=1
  fi
done
exit "$faults"
