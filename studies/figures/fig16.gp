# size 980,760
set multiplot
joints = "SFE SAA SHR EB"
do for [row=0:1] {
  what = word("displaced measured", row + 1)
  name = row == 0 ? "paper, the state displaced" : "guarded, the simulated robot pushed"
  bottom = 0.5 - 0.5 * row
  set origin 0.10, bottom
  set size 0.34, 0.5
  set title name . ": the hand" noenhanced
  set key at screen 0.02, bottom + 0.02 left bottom vertical Left reverse samplen 2
  set xtics 4
  set size ratio -1
  set xlabel "y (cm), seen from behind"
  set ylabel "z (cm)"
  set xrange [-6:-23]
  set yrange [-11:13]
  set label "start" at -16.7,-8.8 offset 1,0
  set label "target" at -12,10 offset 1,0.7
  plot csv u "calm_y":"calm_z" lt 5 t "without a push", '' u what."_y":what."_z" lt 1 t "pushed", \
    '' u (abs(column("time") - 0.4) < 1e-3 ? column(what."_y") : NaN):what."_z" w points pt 6 ps 1.4 lw 2 lc "#d1495b" t "the push begins"
  unset label
  set size noratio
  set origin 0.44, bottom
  set size 0.56, 0.5
  set title name . ": joint angles" noenhanced
  set key outside right top vertical noreverse Right samplen 4
  set rmargin at screen 0.86
  set xlabel "time (s)"
  set ylabel "angle (°)"
  set xrange [0:2.5]
  set xtics 0.5
  set yrange [*:*]
  set arrow 1 from 0.4,graph 0 to 0.4,graph 1 nohead lc "#777777" dt 2
  if (row == 1) { set arrow 2 from 0.65,graph 0 to 0.65,graph 1 nohead lc "#777777" dt 2 }
  if (row == 0) {
    plot for [i=0:3] csv every ::0::250 u "time":sprintf("%s_%d", what, i) w linespoints lt i+1 dt 1 pt (0 + word("4 6 8 12", i + 1)) ps 0.8 pi 30 t word(joints, i + 1)
  } else {
    plot for [i=0:3] csv every ::0::250 u "time":sprintf("%s_%d", what, i) w linespoints lt i+1 dt 1 pt (0 + word("4 6 8 12", i + 1)) ps 0.8 pi 30 t word(joints, i + 1), \
      for [i=0:3] '' every ::0::250 u "time":sprintf("command_%d", i) lc "black" lw 1.2 dt 2 t (i == 0 ? "set-points" : "")
  }
  unset arrow
  unset rmargin
}
