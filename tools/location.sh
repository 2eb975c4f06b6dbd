# shellcheck shell=bash disable=SC2034  # variables are for the script that sources this
# Sourced by scripts: where the project's files are, in the source tree or in an installation (PREFIX/lib/multireach). Sets
#   installed   yes or no
#   root        the folder of robots/ and logs/
#   bin         the programs
#   guard       the library that lcm-logger is started with
#   types_jar   the message types for lcm-spy
#   me          the name of the script that was called, for messages
#   run_program the command that runs a program, for messages
me=${0##*/}
root=$(cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/.." && pwd)
if [ -e "$root/tools/setup.sh" ]; then
  installed=no
  bin=$root/build/release/bin
  guard=$bin/libmultireach-datagram-guard.so
  types_jar=$root/build/release/multireach-types.jar
  run_program=tools/multireach
else
  installed=yes
  bin=${root%/*}/bin
  guard=$root/multireach/libmultireach-datagram-guard.so
  root=${root%/*}/share/multireach
  types_jar=$root/multireach-types.jar
  run_program=multireach
fi
