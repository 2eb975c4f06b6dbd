# size 900,640
set multiplot layout 2,2 margins 0.08,0.98,0.10,0.90 spacing 0.10,0.13
set logscale x
set format x "10^{%L}"
set xrange [10:10000]
set xlabel ""
set key at screen 0.98,0.99 right top horizontal
set ylabel "reaches that fail (%)"
set yrange [-0.5:*]
plot csv u 1:2 w linespoints pt 7 ps 0.5 lt 2 dt 1 t "paper", '' u 1:3 w linespoints pt 4 ps 0.8 lt 1 t "guarded"
unset key
set ylabel "beyond a limit (%); dashed: of speed"
plot csv u 1:4 w linespoints pt 7 ps 0.5 lt 2 dt 1, '' u 1:6 w linespoints pt 7 ps 0.5 lc "#d1495b" dt 2, '' u 1:5 w linespoints pt 4 ps 0.8 lt 1, '' u 1:7 w linespoints pt 4 ps 0.8 lc "#1f6fb4" dt 2
set xlabel "γ (rad²/m²)"
set yrange [0.95:*]
set ylabel "path / distance; dashed: 95th percentile"
plot csv u 1:8 w linespoints pt 7 ps 0.5 lt 2 dt 1, '' u 1:10 w linespoints pt 7 ps 0.5 lc "#d1495b" dt 2, '' u 1:9 w linespoints pt 4 ps 0.8 lt 1, '' u 1:11 w linespoints pt 4 ps 0.8 lc "#1f6fb4" dt 2
set yrange [0:*]
set ylabel "within 1 mm after (s), median"
plot csv u 1:12 w linespoints pt 7 ps 0.5 lt 2 dt 1, '' u 1:13 w linespoints pt 4 ps 0.8 lt 1
