# size 760,480
set multiplot layout 2,1 margins 0.12,0.72,0.12,0.96 spacing 0,0.12  # axes begin and end at one place
set xlabel ""
set ylabel "SAA (rad)"
plot csv u 1:4 t "the arm" lt 5, '' u 1:2 t "command, open" lt 2, '' u 1:3 t "command, measured" lt 1
set xlabel "time (s)"
set ylabel "arm's hand to target (m)"
plot csv u 1:8 t "the arm" lt 1
