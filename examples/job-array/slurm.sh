#!/usr/bin/env bash
#SBATCH --job-name=nailnoise
#SBATCH --array=1-16
#SBATCH --cpus-per-task=2
#SBATCH --mem-per-cpu=2G
#SBATCH --time=02:00:00
# Draws of a study as an array of jobs that share a folder:
#
#     sbatch examples/job-array/slurm.sh designs/n80cb.toml /shared/draws -n 256 --structures
#     nailnoise study designs/n80cb.toml -n 256 --structures --store /shared/draws --collect
set -euo pipefail
design=$1 store=$2
shift 2
exec nailnoise study "$design" "$@" --store "$store" --threads "${SLURM_CPUS_PER_TASK:-1}" \
    --task "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT"
