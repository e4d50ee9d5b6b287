#!/usr/bin/env bash
# An array of four jobs under a Slurm of its own, of which one is cancelled: the parts, put together, lack what it had
# not done, and --resume ends in the table of a campaign that ran in one piece.
# usage: slurm_test.sh TENON_CAMPAIGN     77 if Slurm is not installed and TENON_REQUIRE_CLUSTER is not set
set -euo pipefail
campaign=$1
if ! command -v slurmctld >/dev/null || ! command -v slurmd >/dev/null; then
  echo "Slurm is not installed: apt-get install slurm-wlm"
  [ -z "${TENON_REQUIRE_CLUSTER:-}" ] && exit 77
  exit 1
fi

work=$(mktemp -d "${TMPDIR:-/tmp}/tenon_slurm.XXXXXX")
trap 'kill $(jobs -p) 2>/dev/null || true; wait; rm -rf "$work"' EXIT
host=$(hostname -s)
port=$((20000 + $$ % 20000))
mkdir "$work/state" "$work/spool"
cat > "$work/slurm.conf" <<END
ClusterName=tenon
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$port
SlurmdPort=$((port + 1))
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthType=auth/none
CredType=cred/none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/none
ReturnToService=2
KillWait=1
SchedulerParameters=batch_sched_delay=0,sched_interval=1,sched_min_interval=0
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=main Nodes=$host Default=YES MaxTime=INFINITE State=UP
END
echo CgroupPlugin=cgroup/v1 > "$work/cgroup.conf"  # the other ones want to see /sys/fs/cgroup, which not every machine has
export SLURM_CONF=$work/slurm.conf
slurmctld -D > "$work/ctld.out" 2>&1 &
slurmd -D -N "$host" > "$work/d.out" 2>&1 &
until_true() {  # minutes under the sanitizers
  for _ in $(seq 6000); do
    if "$@"; then return 0; fi
    sleep 0.1
  done
  echo "timed out: $*"
  tail -n 20 "$work"/*.log "$work"/*.out
  exit 1
}
node_is_idle() { sinfo -h -o %T 2>/dev/null | grep -q idle; }
until_true node_is_idle

cat > "$work/campaign.yaml" <<END
app: tenon-quadruped
scenario: A4
duration_s: 0.5
seeds: {first: 101, count: 200}
END
cat > "$work/job.sh" <<END
#!/bin/sh
exec $campaign $work/campaign.yaml --shard \$SLURM_ARRAY_TASK_ID/4 --jobs 1 --out $work/part_\$SLURM_ARRAY_TASK_ID
END
job=$(sbatch --parsable --array=1-4 --output="$work/job_%a.txt" "$work/job.sh")
rows() { cat "$work/$1/runs.csv" 2>/dev/null | wc -l; }
third_has_begun() { [ "$(rows part_3)" -gt 3 ]; }
until_true third_has_begun
scancel "${job}_3"
all_are_over() { [ -z "$(squeue -h)" ]; }
until_true all_are_over

[ "$(rows part_1)" = 51 ]
[ "$(rows part_3)" -lt 51 ]
"$campaign" --merge "$work"/part_? --out "$work/whole" 2>&1 | tee "$work/merge.txt"
grep -q "runs are missing" "$work/merge.txt"
"$campaign" "$work/whole/campaign.yaml" --out "$work/whole" --resume > /dev/null
"$campaign" "$work/campaign.yaml" --out "$work/one" --jobs 1 > /dev/null
python3 - "$work/one/runs.csv" "$work/whole/runs.csv" <<'END'
import csv, sys
def rows(path):
    machine = ("wall", "qp_time", "mpc_time", "real_time")
    return [[(k, v) for k, v in row.items() if not k.startswith(machine)] for row in csv.DictReader(open(path))]
one, whole = map(rows, sys.argv[1:])
assert len(one) == 200, len(one)
assert one == whole
END
echo "the same table"
