"""Ray: one remote function for each line of the plan, which starts the process that every engine starts.

Plan, recordings and results must be reachable from every worker: shared storage or URIs."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from typing import Any

from mapless.batch.errors import BatchError, ExitCode, can_succeed_later
from mapless.batch.task import end_with_parent


def _execute(command: list[str]) -> int:
    quiet = {"stdin": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    code = subprocess.run(command, **quiet, preexec_fn=end_with_parent, check=False).returncode  # type: ignore[call-overload]
    return code if code >= 0 else 128 - int(code)


class RayRun:
    def __init__(self, command: Callable[[int], list[str]], address: str, threads: int, retries: int) -> None:
        """address: of the cluster's head ("auto", "ray://host:10001"); empty: a local cluster for this run."""
        try:
            import ray
        except ImportError:
            raise BatchError("--ray: the package ray is not installed: pip install 'mapless[ray]'") from None
        self._ray: Any = ray
        self._command = command
        self._retries = retries
        if not ray.is_initialized():
            ray.init(address=address or None, log_to_driver=False, include_dashboard=False if not address else None)
        # max_retries: after a worker or its node is lost.
        self._remote = ray.remote(num_cpus=threads, max_retries=retries)(_execute)

    def run(self, lines: list[int], finished: Callable[[int, int], None]) -> None:
        tries = dict.fromkeys(lines, 1)
        pending = {self._remote.remote(self._command(k)): k for k in lines}
        try:
            while pending:
                (reference, *_), _ = self._ray.wait(list(pending), num_returns=1)
                k = pending.pop(reference)
                code = self._code(reference)
                if can_succeed_later(code) and tries[k] <= self._retries:
                    tries[k] += 1
                    pending[self._remote.remote(self._command(k))] = k
                else:
                    finished(k, code)
        except KeyboardInterrupt:
            for reference in pending:
                self._ray.cancel(reference, force=True)
            raise

    def _code(self, reference: Any) -> int:
        try:
            return int(self._ray.get(reference))
        except self._ray.exceptions.RayTaskError:  # raised by _execute: the command cannot be started
            return int(ExitCode.FAILURE)
        except self._ray.exceptions.RayError:  # a worker or a node is lost, after all retries of Ray
            return 128 + 9
