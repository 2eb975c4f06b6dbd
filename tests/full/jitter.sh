#!/usr/bin/env bash
# How late the bridge's ticks begin, in turn with cyclictest (package rt-tests) on the same processor at the same priority, without other work
# and beside a load. Prints, for each, a table of docs/safety.md: the share of ticks by lateness, and percentiles (interpolated in bins of a factor of
# 2, for both alike). Needs the right to SCHED_FIFO.
#   tests/full/jitter.sh BIN [--ticks N] [--segments K] [--load COMMAND] [--reserve]
# N ticks of each (default 200000, some 14 minutes in all), in K segments (10); COMMAND: 'stress-ng --cpu 2 --vm 1 --quiet', or none.
# --reserve: the other nodes, the logger and the load on the other processors, as `launch.sh --reserve` has them.
arguments=("$@")
bin=$1 ticks=200000 segments=10 shared=() reserved="" load='stress-ng --cpu 2 --vm 1 --quiet'
shift
while [ $# -gt 0 ]; do
  case "$1" in
    --ticks) ticks=$2 ;;
    --segments) segments=$2 ;;
    --load) load=$2 ;;
    --reserve) shared=(taskset -c "0-$(($(nproc) - 2))") reserved=", with a processor reserved"; shift; continue ;;
    *) echo "jitter.sh: unknown option '$1'" >&2; exit 2 ;;
  esac
  shift 2
done
[ "$load" != none ] || load=""
set -- "${arguments[@]}"  # for the network namespace, in which this script runs again
. "$(dirname "$0")/../live/namespace.sh"
command -v cyclictest >/dev/null || { echo "skipped: cyclictest (package rt-tests) is not here"; exit 77; }
[ -z "$load" ] || command -v "${load%% *}" >/dev/null || { echo "skipped: ${load%% *} is not here"; exit 77; }
robot="$root/robots/hoap2/robot.yaml" core=$(($(nproc) - 1)) per=$((ticks / segments))
pids=() loading=""
stop() { for pid in "${pids[@]}"; do kill "$pid" 2>/dev/null; wait "$pid" 2>/dev/null; done; pids=(); }
end_load() { [ -z "$loading" ] || kill -- "-$loading" 2>/dev/null; loading=""; }
trap 'stop; end_load; rm -rf "$work"' EXIT

# measure FOLDER: writes the ticks there, by lateness.
measure() {
  local k logger
  mkdir "$1"
  for k in $(seq "$segments"); do
    taskset -c "$core" cyclictest --quiet --mlockall --priority=40 --threads=1 --interval=1000 --loops="$per" --histogram=100000 |
      awk '/^[0-9]/ && $2 > 0 { print $1 + 0, $2 }' >>"$1/cyclictest" || failed "cyclictest did not run"
    taskset -c "$core" "$bin/multireach-bridge" --config "$robot" 2>"$work/bridge.err" & pids+=($!)
    "${shared[@]}" "$bin/multireach-controller" --config "$robot" 2>/dev/null & pids+=($!)
    "${shared[@]}" "$bin/multireach-robot-sim" --config "$robot" 2>/dev/null & pids+=($!)
    "${shared[@]}" "$bin/multireach-view" --robot "$robot" --wait-for controller,bridge,robot_sim --seconds 10 2>/dev/null || failed "the nodes did not start"
    "${shared[@]}" lcm-logger --lcm-url='udpm://239.255.76.67:7667?ttl=0' --force --quiet --channel='NODE_STATUS' "$work/$k.lcm" & logger=$!
    "${shared[@]}" lcm-logplayer --lcm-url='udpm://239.255.76.67:7667?ttl=0' --regexp='TARGET' "$root/logs/load.lcm" >/dev/null 2>&1
    sleep $((per / 1000 > 15 ? per / 1000 - 15 : 1))
    kill -INT $logger; wait $logger 2>/dev/null
    stop
    "$bin/multireach-log" report "$work/$k.lcm" --robot "$robot" --json "$work/$k.json" >/dev/null 2>&1
    tr -d ' \n' <"$work/$k.json" | grep -o '"bridge":{.*' | grep -o '"late":[0-9]*\|"lateness_bins":\[[0-9,]*' | tr -d '"[' | tr '\n' ' ' >>"$1/bridge"
    echo >>"$1/bridge"
  done
}

# print FOLDER: the table of what was measured.
print() {
  awk '
    function bin_of(us,  b) { for (b = 0; b < 11 && us >= 16 * 2 ^ b; ++b); return b }
    function quantile(n, total, share,  b, sum, low) {
      for (b = 0; b < 12; ++b) {
        low = b == 0 ? 0 : 8 * 2 ^ b
        if (sum + n[b] >= share * total) return low + (16 * 2 ^ b - low) * (share * total - sum) / n[b]
        sum += n[b]
      }
    }
    FILENAME ~ /cyclictest$/ { peer[bin_of($1)] += $2; peers += $2; peer_missed += $2 * int($1 / 1000); next }
    { for (f = 1; f <= NF; ++f) {
        if ($f ~ /^late:/) missed += substr($f, 6)
        if ($f ~ /^lateness_bins:/) { count = split(substr($f, 15), part, ","); for (b = 1; b <= count; ++b) { own[b - 1] += part[b]; owns += part[b] } }
      } }
    END {
      if (!owns || !peers) { print "no ticks were counted"; exit 1 }
      print "| began late by less than, us | cyclictest | bridge |"; print "|---|---|---|"
      for (b = 0; b < 12; ++b) {
        peer_sum += peer[b]; own_sum += own[b]
        printf "| %s | %.4f %% | %.4f %% |\n", b == 11 ? "any" : 16 * 2 ^ b, 100 * peer_sum / peers, 100 * own_sum / owns
      }
      printf "| 99th percentile, us | %.0f | %.0f |\n", quantile(peer, peers, 0.99), quantile(own, owns, 0.99)
      printf "| 99.9th percentile, us | %.0f | %.0f |\n", quantile(peer, peers, 0.999), quantile(own, owns, 0.999)
      printf "| missed periods | %.4f %% | %.4f %% |\n| ticks | %d | %d |\n", 100 * peer_missed / peers, 100 * missed / (owns + missed), peers, owns
    }' "$1/cyclictest" "$1/bridge"
}

printf '## Without other work%s\n\n' "$reserved"
measure "$work/idle"
print "$work/idle" || failed "no table"
if [ -n "$load" ]; then
  setsid "${shared[@]}" sh -c "exec $load" >/dev/null 2>&1 & loading=$!
  printf '\n## Beside a load%s\n\n`%s`\n\n' "$reserved" "$load"
  measure "$work/loaded"
  end_load
  print "$work/loaded" || failed "no table"
fi
finish
