#!/usr/bin/env bash
# Runs the scripts of examples/job-array as SLURM and HyperQueue do, by the variables that these set for a task, and collects the draws.
#
#     job_array.sh NAILNOISE DESIGN FOLDER
set -euo pipefail
program=$(realpath "$1") design=$(realpath "$2") folder=$3
scripts=$(realpath "$(dirname "$0")/../../examples/job-array")
rm -rf "$folder" && mkdir -p "$folder/bin" && cd "$folder"
ln -s "$program" bin/nailnoise
export PATH=$PWD/bin:$PATH NAILNOISE_CACHE=$PWD/cache
printf 'base = "%s"\n[study]\nrequire = ["drives", "underdriven", "overdriven", "strikes_bumper"]\n' "$design" > drawn.toml

for task in 1 2 3; do
    SLURM_ARRAY_TASK_ID=$task SLURM_ARRAY_TASK_COUNT=3 SLURM_CPUS_PER_TASK=1 bash "$scripts/slurm.sh" drawn.toml slurm -n 6 &
done
wait
for task in 1 2 3; do
    HQ_TASK_ID=$task HQ_NUM_CPUS=1 bash "$scripts/hyperqueue.sh" 3 drawn.toml hyperqueue -n 6 &
done
wait
for store in slurm hyperqueue; do
    nailnoise study drawn.toml -n 6 --store $store --collect --json --out $store-out > $store.json
done
nailnoise study drawn.toml -n 6 --no-cache --json --out alone-out > alone.json
cmp slurm.json alone.json
cmp hyperqueue.json alone.json
cmp slurm-out/study/draws.csv alone-out/study/draws.csv
echo "tasks of both arrays state the study of one process, to the byte"
