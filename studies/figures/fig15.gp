# size 980,760
set multiplot
joints = "SFE SAA SHR EB"
do for [row=0:1] {
  law = word("paper guarded", row + 1)
  bottom = 0.5 - 0.5 * row
  set origin 0, bottom
  set size 0.45, 0.5
  unset key
  set title law . ": the hand, seen from behind" noenhanced
  set size ratio -1
  set xlabel "y (cm)"
  set ylabel "z (cm)"
  set xtics 4
  set xrange [-6:-23]
  set yrange [-11:13]
  set label "start" at -16.7,-8.8 offset 1,0
  set label "0" at -12,10 offset 1,0
  set label "1" at -20,8 offset 1,0
  set label "2" at -8,4 offset -0.4,-1.2
  plot csv u "target_y":"target_z" w points pt 4 ps 1.4 lw 2 lc "black", '' u law."_y":law."_z" lt 1, \
    '' u (abs(column("time") - 0.3) < 1e-3 || abs(column("time") - 0.7) < 1e-3 ? column(law."_y") : NaN):law."_z" w points pt 6 ps 1.4 lw 2 lc "#d1495b"
  unset label
  set size noratio
  set origin 0.45, bottom
  set size 0.55, 0.5
  set title law . ": joint speeds" noenhanced
  set key outside right top
  set xlabel "time (s)"
  set ylabel "rad/s"
  set xrange [0:2]
  set xtics 0.5
  set yrange [-5:4]
  set arrow 1 from 0.3,graph 0 to 0.3,graph 1 nohead lc "#777777" dt 2
  set arrow 2 from 0.7,graph 0 to 0.7,graph 1 nohead lc "#777777" dt 2
  plot for [i=0:3] csv u "time":sprintf("%s_%d", law, i) lt i+1 t word(joints, i + 1)
  unset arrow
}
