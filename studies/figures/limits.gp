# size 760,640
set multiplot layout 3,1 margins 0.12,0.76,0.09,0.97 spacing 0,0.10  # axes begin and end at one place
set xlabel ""
set ylabel "angle (rad)"
plot csv u 1:2 t "paper" lt 2, '' u 1:3 t "guarded" lt 1, '' u 1:4 t "limit" lt 5
set ylabel "speed (rad/s)"
set yrange [-7:7]
plot csv u 1:6 t "paper" lt 2, '' u 1:7 t "guarded" lt 1, '' u 1:8 t "limit" lt 5, '' u 1:(-$8) t "" lt 5
set xlabel "time (s)"
set ylabel "acceleration (rad/s²)"
set yrange [-24:24]
set ytics 10
plot csv u 1:9 t "guarded" lt 1, '' u 1:10 t "limit" lt 5, '' u 1:(-$10) t "" lt 5
