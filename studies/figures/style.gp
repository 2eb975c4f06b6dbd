# What all pictures share; figures.sh has set the terminal, the output and csv, the scene's table.
set datafile separator ","
set key autotitle columnhead noenhanced outside right top
set grid lc "#dddddd"
set xlabel "time (s)"
set style data lines
# Lines differ by their dashes, so that no picture needs colours.
set linetype 1 lc "#1f6fb4" lw 2
set linetype 2 lc "#d1495b" lw 2 dt 2
set linetype 3 lc "#3a9d5d" lw 2 dt 3
set linetype 4 lc "#8a5fb0" lw 2 dt 4
set linetype 5 lc "#777777" lw 1 dt 2
