#!/bin/bash
# One run as a Slurm job of its own, whose ranks (MPI, --set ranks=N) are the tasks of one node:
#
#   sbatch --ntasks=8 templates/slurm/run.sh workflows/icy_erosion.yaml --set dem=lammps --out runs/erosion
#
# Time, partition and account as with any job (sbatch --time=24:00:00 ...). It runs where sbatch was called, which must be the
# checkout, on a disk that the node sees; a job that was ended by its time limit is gone on with by the same line with
# `resume runs/erosion` in the place of the workflow and what follows it. The launcher forks, so all ranks are on one node.
#SBATCH --nodes=1
#SBATCH --cpus-per-task=1
set -euo pipefail
if [[ ${1-} == resume ]]; then
  exec ./sandglass "$@"
fi
exec ./sandglass run "$@" --set ranks="$SLURM_NTASKS"
