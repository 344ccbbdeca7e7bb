#!/bin/bash
# A sweep as a Slurm job array: each task renders its shard, and may be requeued at any time.
#
#   sbatch --array=1-40 scripts/slurm/sweep.sh SCRIPT.lua [ARGS for lampyris run…]
#   lampyris merge out/NAME         # when all tasks are done
#
# Submit it where the script is to run; the folder has to be shared by all nodes. LAMPYRIS names the
# program, if it is not on the PATH. A task that is requeued goes on where it was.
#SBATCH --job-name=lampyris
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --output=lampyris-%a.log
set -euo pipefail

if [ -z "${SLURM_ARRAY_TASK_ID:-}" ] || [ "${SLURM_ARRAY_TASK_MIN:-}" != 1 ]; then
    echo "submit this with sbatch --array=1-N" >&2
    exit 2
fi
threads=${SLURM_CPUS_PER_TASK:-1}
exec "${LAMPYRIS:-lampyris}" run "$@" --quiet --threads "$threads" \
    --shard "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT"
