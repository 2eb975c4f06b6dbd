#!/usr/bin/env bash
# How late the bridge's ticks begin, in turn with cyclictest (package rt-tests) on the same processor at the same priority:
#   tests/full/jitter.sh BIN [TICKS] [SEGMENTS] [LOAD]     default 1000000 ticks of each, in 10 segments, without a load
# LOAD: a command that runs meanwhile, e.g. 'stress-ng --cpu 2 --vm 1 --quiet'. Prints the share of ticks by lateness, and the 99.9th
# percentile (interpolated in bins of a factor of 2, for both alike). Needs the right to SCHED_FIFO.
bin=$1 ticks=${2:-1000000} segments=${3:-10} load=${4:-}
. "$(dirname "$0")/../live/namespace.sh"
command -v cyclictest >/dev/null || { echo "skipped: cyclictest (package rt-tests) is not here"; exit 77; }
robot="$root/robots/hoap2/robot.yaml" core=$(($(nproc) - 1)) per=$((ticks / segments))
pids=()
stop() { for pid in "${pids[@]}"; do kill "$pid" 2>/dev/null; wait "$pid" 2>/dev/null; done; pids=(); }
if [ -n "$load" ]; then
  setsid sh -c "exec $load" >/dev/null 2>&1 & loading=$!
fi
trap 'stop; [ -z "$load" ] || kill -- "-$loading" 2>/dev/null; rm -rf "$work"' EXIT
for k in $(seq "$segments"); do
  taskset -c "$core" cyclictest --quiet --mlockall --priority=40 --threads=1 --interval=1000 --loops="$per" --histogram=100000 |
    awk '/^[0-9]/ && $2 > 0 { print $1 + 0, $2 }' >>"$work/cyclictest" || failed "cyclictest did not run"
  taskset -c "$core" "$bin/multireach-bridge" --config "$robot" 2>"$work/bridge.err" & pids+=($!)
  "$bin/multireach-controller" --config "$robot" 2>/dev/null & pids+=($!)
  "$bin/multireach-robot-sim" --config "$robot" 2>/dev/null & pids+=($!)
  "$bin/multireach-view" --robot "$robot" --wait-for controller,bridge,robot_sim --seconds 10 2>/dev/null || failed "the nodes did not start"
  lcm-logger --lcm-url='udpm://239.255.76.67:7667?ttl=0' --force --quiet --channel='NODE_STATUS' "$work/$k.lcm" & logger=$!
  lcm-logplayer --lcm-url='udpm://239.255.76.67:7667?ttl=0' --regexp='TARGET' "$root/logs/load.lcm" >/dev/null 2>&1
  sleep $((per / 1000 > 15 ? per / 1000 - 15 : 1))
  kill -INT $logger; wait $logger 2>/dev/null
  stop
  "$bin/multireach-log" report "$work/$k.lcm" --robot "$robot" --json "$work/$k.json" >/dev/null 2>&1
  tr -d ' \n' <"$work/$k.json" | grep -o '"bridge":{.*' | grep -o '"late":[0-9]*\|"lateness_bins":\[[0-9,]*' | tr -d '"[' | tr '\n' ' ' >>"$work/bridge"
  echo >>"$work/bridge"
done
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
  }' "$work/cyclictest" "$work/bridge"
finish
