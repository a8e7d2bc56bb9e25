#!/usr/bin/env bash
# Draws of a study as tasks of HyperQueue that share a folder:
#
#     hq submit --array 1-16 --cpus 2 examples/job-array/hyperqueue.sh 16 designs/n80cb.toml /shared/draws -n 256 --structures
#     nailnoise study designs/n80cb.toml -n 256 --structures --store /shared/draws --collect
set -euo pipefail
tasks=$1 design=$2 store=$3
shift 3
exec nailnoise study "$design" "$@" --store "$store" --threads "${HQ_NUM_CPUS:-1}" --task "$HQ_TASK_ID/$tasks"
