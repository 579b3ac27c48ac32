#!/bin/sh
# Shows Pliant at work: installs what is missing (Debian, with apt), builds, runs the demo scenes on Pliant and on
# Bullet, measures, and ends with the path of a page with pictures, tables and plots. Needs no display. A second run
# only does what is left.
#
#   usage: sh demos/run.sh
set -eu
cd "$(dirname "$0")/.."
. cmake/bootstrap.sh

install_missing
build_preset release pliant_program
say "running the demo"
mkdir -p out
build/release/demos/app/pliant demo --out out/demo
say "measuring: agreement, speed, error against run time, stability"
build/release/demos/app/pliant report --quick --out out/report
