"""Labels many recordings on one machine or a cluster: `mapless batch plan`, `run`, `merge` (docs/fleet.md).

One drive is one task and nothing is shared between tasks. plan.py finds the drives; task.py labels one, the same way
under every engine; run.py keeps the cores of one machine busy; merge.py sums the results; engines/ has what Slurm,
Kubernetes, Ray and Snakemake need. storage.py is the only file that knows where results and recordings lie.
"""

from mapless.batch.errors import BatchError, ExitCode

__all__ = ["BatchError", "ExitCode"]
