# size 980,420
set multiplot
set origin 0,0
set size 0.42,1
set size ratio -1
unset key
set title "the hand, seen from behind"
set xlabel "y (cm)"
set ylabel "z (cm)"
set label "start" at -9.95,-12.7 offset -1,1
set label "target" at -31.65,9 offset -1,1
set xrange [-6:-36]
set yrange [-15:13]
plot csv u "short_y":"short_z" lt 4 dt 1 lw 4, '' u "paper_y":"paper_z" lt 2, '' u "guarded_y":"guarded_z" lt 1
unset label
set origin 0.42,0
set size noratio
set size 0.58,1
set title "condition number of the matrix that is inverted"
set key outside right top
set xlabel "time (s)"
set ylabel ""
set xrange [0:2.5]
set yrange [0:23]
plot csv u "time":"literal_condition" w points pt 2 lw 2 lc "black" t "literal: two steps", \
  '' u "time":"short_condition" lt 4 dt 1 lw 4 t "literal, 0.01 mm short", '' u "time":"paper_condition" lt 2 t "paper, θ_T searched again", \
  '' u "time":"guarded_condition" lt 1 t "guarded", '' u "time":"bound" lt 5 t "bound of Eq. (32)"
