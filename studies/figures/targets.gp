# size 900,640
set multiplot layout 3,1 margins 0.10,0.83,0.09,0.97 spacing 0,0.10  # axes begin and end at one place
set xtics 2
set xlabel ""
set ylabel "y in W (m)"
set label "rests" at 1,graph 0.92 center
set label "moves" at 6,graph 0.92 center
set label "jumps" at 10,graph 0.92 center
set label "noisy" at 12.5,graph 0.92 center
set label "lost" at 15,graph 0.92 center
set label "returns" at 17,graph 0.92 center
set label "out of\nreach" at 19,graph 0.92 center
set label "returns" at 21,graph 0.92 center
set yrange [-0.23:-0.06]
plot csv u 1:3 t "target" lt 2, '' u 1:6 t "hand" lt 1
unset label
set ylabel "hand to target (m)"
set yrange [1e-5:1]
set logscale y
set format y "10^{%L}"
plot csv u 1:8 t "distance" lt 1
unset logscale y
set format y "%g"
set yrange [0:*]
set xlabel "time (s)"
set ylabel "fastest joint (rad/s)"
plot csv u 1:9 t "guarded" lt 1
