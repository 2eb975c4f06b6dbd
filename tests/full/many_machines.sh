#!/usr/bin/env bash
# A study as an array job of Slurm on three nodes of this machine, and by GNU parallel in two network namespaces, as docs/study.md
# shows: a shard that is killed, and one whose node dies, run again, and the merged result is that of a single run.
#   tests/full/many_machines.sh BIN       Debian packages slurm-wlm, munge, parallel; root
bin=$(cd "$1" && pwd) || exit 2
. "$(dirname "$0")/../live/namespace.sh"
for program in slurmctld slurmd sbatch munged parallel; do
  command -v $program >/dev/null || { echo "skipped: $program (Debian packages slurm-wlm, munge, parallel) is not here"; exit 77; }
done
[ "$(id -u)" -eq 0 ] || { echo "skipped: Slurm's programs need root"; exit 77; }
# Slurm looks its host's name up, as getaddrinfo does for hosts that have more than a loopback address.
if [ "$(hostname)" != localhost ]; then exec unshare --uts sh -c 'hostname localhost && ip address add 192.0.2.1/32 dev lo && exec "$0" "$@"' "$0" "$@"; fi
shards=8
study=("$bin/multireach-study" --urdf "$root/robots/hoap2/hoap2.urdf" --base torso --tip right_hand --gamma "100,1000" --samples 200000)
numbers() { grep -v '"ns_per_step_per_core"' "$1"; }
status() { "$bin/multireach-study" status "$1"; }
# Waits until a shard of the study in folder $1 runs, for a minute at most; prints its progress file.
running() {
  local file
  for _ in $(seq 300); do
    for file in "$1"/shard*.json.progress; do [ ! -e "$file" ] || { echo "$file"; return 0; }; done
    sleep 0.2
  done
  return 1
}
# Waits for all shards of folder $1, merges them and compares them with the single run.
finish_study() {
  for _ in $(seq 600); do status "$1" >"$work/status" 2>/dev/null && break; sleep 0.5; done
  echo "$2: $(status "$1")"
  "$bin/multireach-study" merge "$1"/shard*.json --json "$work/merged.json" || failed "$2: the shards do not merge"
  diff <(numbers "$work/single.json") <(numbers "$work/merged.json") >"$work/diff" || { failed "$2: the merged result is not that of a single run"; head -n 5 "$work/diff"; }
}
"${study[@]}" --json "$work/single.json" || failed "the single run"

# Slurm: a controller and three nodes, each of one processor. The daemons are ended by their process groups.
slurm="$work/slurm" daemons=()
mkdir -p "$slurm"/{state,munge} "$work/array"
stop_daemons() { for pid in "${daemons[@]}"; do kill -KILL -- "-$pid" 2>/dev/null; wait "$pid" 2>/dev/null; done; }
trap 'stop_daemons; rm -rf "$work"' EXIT
daemon() { setsid "$@" >>"$slurm/log" 2>&1 & daemons+=($!); }
head -c 128 /dev/urandom >"$slurm/munge/key"; chmod 600 "$slurm/munge/key"
chmod 711 "$work" "$slurm" "$slurm/munge"
daemon munged --foreground --force --key-file="$slurm/munge/key" --socket="$slurm/munge/socket" --pid-file="$slurm/munge/pid" \
  --log-file="$slurm/munge/log" --seed-file="$slurm/munge/seed"
cat >"$slurm/slurm.conf" <<CONF
ClusterName=multireach
SlurmctldHost=localhost(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$slurm/munge/socket,cred_expire=10
StateSaveLocation=$slurm/state
SlurmdSpoolDir=$slurm/spool.%n
SlurmctldPidFile=$slurm/slurmctld.pid
SlurmdPidFile=$slurm/slurmd.%n.pid
ProctrackType=proctrack/pgid
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/linear
MpiDefault=none
SlurmdTimeout=10
ReturnToService=2
NodeName=node[0-2] NodeHostname=localhost NodeAddr=127.0.0.1 Port=[17010-17012] CPUs=1 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES State=UP
CONF
export SLURM_CONF="$slurm/slurm.conf"
for _ in $(seq 50); do [ ! -S "$slurm/munge/socket" ] || break; sleep 0.1; done
daemon slurmctld -D
for node in 0 1 2; do daemon slurmd -D -N node$node; done
for _ in $(seq 100); do [ "$(sinfo --noheader --format=%D --states=idle 2>/dev/null)" != 3 ] || break; sleep 0.3; done
[ "$(sinfo --noheader --format=%D --states=idle)" = 3 ] || { failed "Slurm's nodes are not idle"; tail -n 20 "$slurm/log"; finish; }
cat >"$work/array/job.sh" <<JOB
#!/bin/sh
#SBATCH --array=0-$((shards - 1))
#SBATCH --requeue
${study[*]} --threads 1 --shard \$SLURM_ARRAY_TASK_ID/\$SLURM_ARRAY_TASK_COUNT --json shard\$SLURM_ARRAY_TASK_ID.json
[ \$? -lt 128 ] || scontrol requeue \$SLURM_JOB_ID
JOB
(cd "$work/array" && sbatch --output=%a.out job.sh) >/dev/null || failed "sbatch"
begun=$(running "$work/array") || failed "no shard began: $(squeue)"
shard=$(basename "$begun" .json.progress)
pkill -KILL -f "multireach-study .*--json $shard.json" || failed "$shard did not run any more"
echo "Slurm: $shard was killed"
sleep 1
read -r node index job < <(squeue --noheader --states=running --format='%N %K %A' | head -n 1)
echo "Slurm: $node died with shard $index"
# slurmd and what it started, whose processes are in groups of their own.
pkill -KILL -f "slurmd -D -N $node\$"
pkill -KILL -f "slurmstepd: \[${job}[.]"
pkill -KILL -f "multireach-study .*--json shard$index.json"
status "$work/array"
finish_study "$work/array" "Slurm"
[ "$(scontrol show job 2>/dev/null | grep -c 'Requeue=1 Restarts=[1-9]')" -ge 1 ] || failed "no shard was queued again"
stop_daemons
daemons=()

# GNU parallel, with two hosts: namespaces, which a command takes the place of ssh for.
mkdir "$work/parallel"
for host in a b; do daemon unshare --net sleep infinity; echo "${daemons[-1]}" >"$work/$host"; done
cat >"$work/into" <<INTO
#!/bin/sh
host=\$1; shift
[ "\$1" != -- ] || shift
exec nsenter --net --target "\$(cat "$work/\$host")" sh -c "\$*"
INTO
chmod +x "$work/into"
parallel --will-cite --ssh "$work/into" --sshlogin 1/a,1/b --retries 3 --workdir "$work/parallel" --joblog "$work/joblog" \
  "${study[*]} --threads 1 --shard {}/$shards --json shard{}.json" ::: $(seq 0 $((shards - 1))) & jobs=$!
begun=$(running "$work/parallel") || failed "no shard began"
shard=$(basename "$begun" .json.progress)
pkill -KILL -f "multireach-study .*--json $shard.json" || failed "$shard did not run any more"
echo "GNU parallel: $shard was killed"
wait $jobs || failed "GNU parallel: exit code $?"
finish_study "$work/parallel" "GNU parallel"
[ "$(awk 'NR > 1 { print $2 }' "$work/joblog" | sort -u | wc -l)" -eq 2 ] || failed "one of the two hosts did nothing"
stop_daemons
finish
