# size 980,760
set multiplot
joints = "SFE SAA SHR EB"
do for [row=0:1] {
  law = word("paper guarded", row + 1)
  bottom = 0.5 - 0.5 * row
  set key top left inside width -2 samplen 2
  set origin 0, bottom
  set size 0.5, 0.5
  set title law . ": the hand" noenhanced
  set xlabel "x (cm)" offset 0,-0.3
  set ylabel "y (cm)" offset 1,-0.5
  set zlabel "z (cm)" rotate by 90 offset 1,0
  set xyplane relative 0.05
  set view 65, 50
  set xtics 4 offset 0,-0.2
  set ytics 2 offset 0.5,-0.2
  set ztics 5
  set xrange [0:12]
  set yrange [-18:-10]
  set zrange [-10:12]
  splot csv u law."_arm_x":law."_arm_y":law."_arm_z" w lines lt 1 t "executed", '' u law."_x":law."_y":law."_z" w lines lt 2 t "computed"
  set origin 0.5, bottom
  set title law . ": joint angles" noenhanced
  set key outside right top
  set rmargin 17
  set xlabel "time, without the delay (s)" offset 0,0
  set ylabel "angle (°)" offset 0,0
  set xtics autofreq offset 0,0
  set ytics autofreq offset 0,0
  set xrange [0:2]
  set yrange [*:*]
  plot for [i=0:3] csv u "time":sprintf("%s_arm_%d", law, i) w linespoints lt i+1 dt 1 pt (0 + word("4 6 8 12", i + 1)) ps 0.8 pi 15 t word(joints, i + 1), \
    for [i=0:3] '' u "time":sprintf("%s_%d", law, i) lt 5 dt 2 lw 1.5 lc "black" t (i == 0 ? "computed" : "")
  set xrange [*:*]
  set rmargin -1
}
