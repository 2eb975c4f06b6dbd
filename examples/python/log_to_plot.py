#!/usr/bin/env python3
"""Draws the commanded joint positions of a log over time, by gnuplot.

    examples/python/log_to_plot.py run.lcm -o plot.svg
"""
import argparse
import subprocess

import numpy as np

import multireach

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("log", help="log of a run")
parser.add_argument("-o", "--output", required=True, help="SVG file to write")
parser.add_argument("--channel", default="JOINT_COMMAND", help="channel with joint_name and joint_position")
arguments = parser.parse_args()

columns = multireach.Log(arguments.log).columns(arguments.channel, ["utime", "joint_name", "joint_position"])
seconds = (columns["utime"] - columns["utime"][0]) * 1e-6
table = np.column_stack([seconds, columns["joint_position"]])
names = columns["joint_name"][0]
curves = ", ".join(f"'-' with lines title '{name}'" for name in names)
script = f"set terminal svg size 800,400 noenhanced; set output '{arguments.output}'; set xlabel 's'; set ylabel 'rad'\nplot {curves}\n"
for joint in range(len(names)):
    script += "\n".join(f"{t} {theta}" for t, theta in table[:, [0, joint + 1]]) + "\ne\n"
subprocess.run(["gnuplot"], input=script, text=True, check=True)
print(f"{len(table)} messages of {arguments.channel}, {seconds[-1]:.2f} s: {arguments.output}")
