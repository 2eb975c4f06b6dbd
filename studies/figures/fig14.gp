# size 980,780
set multiplot
joints = "SFE SAA SHR EB"
unset key
set lmargin at screen 0.11; set rmargin at screen 0.40
set tmargin at screen 0.95; set bmargin at screen 0.57
set size ratio -1
set title "the hand, seen from the right"
set xlabel "x (cm)"
set ylabel "z (cm)"
set label "start" at -11.5,14.6 offset -4,1
set label "target" at 12,-6 offset 1,-0.5
set xrange [-22:22]
set yrange [-14:32]
plot csv u "without_x":"without_z" lt 3 dt 4, '' u "with_x":"with_z" lt 2, '' u "guarded_x":"guarded_z" lt 1, '' u "default_x":"default_z" lt 1 dt 3
unset label
set tmargin at screen 0.46; set bmargin at screen 0.08
set title "the hand, seen from above"
set ylabel "y (cm)"
set yrange [-36:8]
set label "start" at -11.5,-1.1 offset -1,1
set label "target" at 12,-12 offset 1,-0.5
plot csv u "without_x":"without_y" lt 3 dt 4, '' u "with_x":"with_y" lt 2, '' u "guarded_x":"guarded_y" lt 1, '' u "default_x":"default_y" lt 1 dt 3
unset label
set size noratio
set ylabel "angle (°)"
set yrange [*:*]
set xrange [0:5]
set key at screen 0.995,0.97 right top vertical
do for [i=0:3] {
  set lmargin at screen 0.54; set rmargin at screen 0.80
  set tmargin at screen 0.96 - 0.24 * i; set bmargin at screen 0.80 - 0.24 * i
  set title word(joints, i + 1) offset 0,-0.7
  set ytics 50
  set xlabel (i == 3 ? "time (s)" : "")
  if (i > 0) { unset key }
  plot csv u "time":sprintf("without_%d", i) lt 3 dt 4 t "paper, without", '' u "time":sprintf("with_%d", i) lt 2 t "paper, with", \
    '' u "time":sprintf("guarded_%d", i) lt 1 t "guarded", '' u "time":sprintf("default_%d", i) lt 1 dt 3 t "guarded, default γ", '' every 139 u "time":sprintf("lower_%d", i) lt 5 t "limits", '' every 139 u "time":sprintf("upper_%d", i) lt 5 t ""
}
