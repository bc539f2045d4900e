#!/bin/sh
# A local Slurm cluster with three nodes, for tests and first experiments:
#   tools/slurm_local.sh start [DIR]     starts it and prints the settings: eval "$(tools/slurm_local.sh start)"
#   tools/slurm_local.sh stop [DIR]      stops it
#   tools/slurm_local.sh lose DIR NODE   simulates a power failure: kills all processes of the node
# DIR (default: $TMPDIR/gaitslam-slurm-UID) contains configuration, keys, logs and process ids; /etc is not touched. munge, slurmctld
# and the slurmd daemons listen only on 127.0.0.1. Needs Debian's slurm-wlm and munge, and root. $GAITSLAM_SLURM_PORT is the first
# of five ports (default 26817).
set -eu

command=${1:-} dir=${2:-${TMPDIR:-/tmp}/gaitslam-slurm-$(id -u)}
port=${GAITSLAM_SLURM_PORT:-26817}
nodes="n1 n2 n3"

fail() { echo "slurm_local: $*" >&2; exit 2; }

alive() { [ -s "$dir/run/$1.pid" ] && kill -0 "$(cat "$dir/run/$1.pid")" 2>/dev/null; }

write_configuration() {
  cpus=$(nproc)
  cat >"$dir/slurm.conf" <<END
ClusterName=gaitslam
SlurmctldHost=localhost(127.0.0.1)
SlurmctldPort=$port
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
AuthType=auth/munge
AuthInfo=socket=$dir/munge/munge.socket,cred_expire=5
SlurmUser=root
SlurmdUser=root
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/spool.%n
SlurmctldPidFile=$dir/run/slurmctld.pid
SlurmdPidFile=$dir/run/%n.pid
SlurmctldLogFile=$dir/log/slurmctld.log
SlurmdLogFile=$dir/log/%n.log
ProctrackType=proctrack/linuxproc
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
MaxArraySize=10001
MaxJobCount=20000
SlurmdTimeout=30
KillWait=5
SchedulerParameters=batch_sched_delay=0,sched_min_interval=1000,sched_interval=5,bf_interval=5,default_queue_depth=1000
NodeName=n[1-3] NodeHostname=localhost NodeAddr=127.0.0.1 Port=[$((port + 2))-$((port + 4))] CPUs=$cpus State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
END
  echo CgroupPlugin=cgroup/v1 >"$dir/cgroup.conf"
}

# start_daemon NAME COMMAND...: starts it in the background and writes its id to run/NAME.pid.
start_daemon() {
  name=$1
  shift
  setsid "$@" </dev/null >>"$dir/log/$name.out" 2>&1 &
  echo $! >"$dir/run/$name.pid"
}

await() {  # await WHAT COMMAND...
  what=$1
  shift
  for _ in $(seq 150); do
    if "$@" >/dev/null 2>&1; then return; fi
    sleep 0.2
  done
  stop
  fail "$what did not start within 30 s; see $dir/log"
}

three_idle() { [ "$(sinfo -h -N -t idle -o %N | wc -l)" = 3 ]; }

start() {
  for program in munged slurmctld slurmd sbatch; do
    command -v "$program" >/dev/null || fail "$program is not installed (apt-get install slurm-wlm munge)"
  done
  [ "$(id -u)" = 0 ] || fail "needs root, because munge and Slurm's nodes run as the user who starts them"
  if alive slurmctld; then settings; return; fi
  umask 022
  for folder in . munge run log state spool.n1 spool.n2 spool.n3; do mkdir -p "$dir/$folder"; done
  chmod 0755 "$dir" "$dir/munge"
  write_configuration
  [ -s "$dir/munge/munge.key" ] || (umask 077 && head -c 1024 /dev/urandom >"$dir/munge/munge.key")
  chmod 0400 "$dir/munge/munge.key"
  start_daemon munged munged --foreground --key-file="$dir/munge/munge.key" --socket="$dir/munge/munge.socket" \
    --pid-file="$dir/munge/munged.pid" --log-file="$dir/munge/munged.log" --seed-file="$dir/munge/munged.seed" --num-threads=2
  await munged munge -n -S "$dir/munge/munge.socket"
  export SLURM_CONF="$dir/slurm.conf"
  start_daemon slurmctld slurmctld -D -c -f "$SLURM_CONF"
  for node in $nodes; do start_daemon "$node" slurmd -D -N "$node" -f "$SLURM_CONF"; done
  await "the cluster" three_idle
  settings
}

settings() { echo "export SLURM_CONF='$dir/slurm.conf'"; }

any_alive() { for name in $nodes slurmctld munged; do if alive "$name"; then return; fi; done; return 1; }

stop() {
  for signal in TERM KILL; do
    for name in $nodes slurmctld munged; do
      if alive "$name"; then kill -$signal "$(cat "$dir/run/$name.pid")" 2>/dev/null || true; fi
    done
    for _ in $(seq 50); do if any_alive; then sleep 0.1; fi; done
  done
  rm -f "$dir"/run/*.pid
}

# Prints the processes of the node's jobs and their parent steps.
processes_of() {
  for process in $(grep -lzsx "SLURMD_NODENAME=$1" /proc/[0-9]*/environ | cut -d/ -f3); do
    echo "$process"
    parent=$(cut -d' ' -f4 "/proc/$process/stat" 2>/dev/null) || continue
    [ "$(cat "/proc/$parent/comm" 2>/dev/null)" != slurmstepd ] || echo "$parent"
  done
}

lose() {
  alive "$1" || fail "node $1 is not running"
  kill -KILL "$(cat "$dir/run/$1.pid")" $(processes_of "$1" | sort -u) 2>/dev/null || true
  SLURM_CONF=$dir/slurm.conf scontrol update NodeName="$1" State=DOWN Reason=lost
}

case $command in
  start) dir=$(mkdir -p "$dir" && readlink -f "$dir") && start ;;
  stop) [ ! -d "$dir/run" ] || stop ;;
  lose) [ $# = 3 ] || fail "expected DIR and NODE"; lose "$3" ;;
  *) sed -n '2,8s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
esac
