#!/bin/sh
# Labels the drives of a plan as a Slurm array, on shared storage:
#
#   mapless batch plan /data/drives -o plan.jsonl
#   sbatch --array=0-999%200 slurm.sh plan.jsonl /data/results
#   mapless batch merge /data/results             # or: sbatch --dependency=afterany:JOB --wrap 'mapless batch merge ...'
#
# Task k of an array of n does lines k, k + n, k + 2 n ... of the plan, so a plan may have more lines than the cluster
# allows tasks (MaxArraySize, 1001). The same command again does what is not done yet. Slurm itself starts the tasks of a
# lost node again.
#SBATCH --job-name=mapless
#SBATCH --cpus-per-task=1
#SBATCH --mem=2G
#SBATCH --requeue
#SBATCH --open-mode=append
set -u
plan=$1
results=$2
todo=$(seq "$SLURM_ARRAY_TASK_ID" "$SLURM_ARRAY_TASK_COUNT" $(($(wc -l <"$plan") - 1)))
worst=0
for try in 1 2 3; do
  again=""
  for line in $todo; do
    mapless batch run "$plan" -o "$results" --index "$line" --threads "${SLURM_CPUS_PER_TASK:-1}"
    code=$?
    if [ $code -eq 75 ] || [ $code -gt 128 ]; then
      again="$again $line" # a full disk, or killed: trying again can help
    elif [ $code -ne 0 ] && [ $code -ne 4 ]; then
      worst=$code # bad data: the other drives go on. 4: labelled, not trustworthy; the merged page says why
    fi
  done
  todo=$again
  [ -z "$todo" ] && exit $worst
done
exit 75
