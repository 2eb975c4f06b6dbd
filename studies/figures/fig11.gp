# size 980,760
set multiplot layout 2,3 margins 0.06,0.87,0.08,0.94 spacing 0.07,0.13
joints = "SFE SAA SHR EB"
set xrange [0:1.6]
set xtics 0.4
do for [row=0:1] {
  law = word("paper guarded", row + 1)
  set xlabel (row == 1 ? "time (s)" : "")
  unset key
  set title law . ": θ, and θ_T dashed" noenhanced
  set ylabel "angle (°)" offset 1,0
  set yrange [*:*]
  plot for [i=0:3] csv every 2 u "time":sprintf("%s_%d", law, i) w linespoints lt i+1 dt 1 pt (0 + word("4 6 8 12", i + 1)) ps 0.8 pi 10, for [i=0:3] '' every 4 u "time":sprintf("%s_target_%d", law, i) lt i+1 lw 1.5 dt 2
  set title law . ": hand speed (m/s)" noenhanced
  set ylabel ""
  set yrange [0:0.7]
  set key inside top right
  plot csv u "time":law."_arm_speed" lc "#bbbbbb" lw 1.5 t "executed", '' u "time":law."_speed" lt 1 t "computed"
  set title law . ": joint speeds (rad/s)" noenhanced
  set yrange [-5:4]
  set key outside right top
  plot for [i=0:3] csv every 2 u "time":sprintf("%s_rate_%d", law, i) w linespoints lt i+1 dt 1 pt (0 + word("4 6 8 12", i + 1)) ps 0.8 pi 10 t word(joints, i + 1)
}
