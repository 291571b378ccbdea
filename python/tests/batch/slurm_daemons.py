"""One node of Slurm (slurm-wlm of Debian) in a folder of its own, for as long as a test takes."""

import contextlib
import os
import pathlib
import shutil
import socket
import subprocess
import time

READY_S = 20.0
PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "sinfo")
CONFIGURATION = """
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller}
SlurmdPort={node}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
SlurmUser=root
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmdSpoolDir={folder}/spool
StateSaveLocation={folder}/state
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SchedulerType=sched/backfill
SchedulerParameters=sched_interval=1,batch_sched_delay=0
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
ReturnToService=2
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=test Nodes={host} Default=YES MaxTime=INFINITE State=UP OverSubscribe=FORCE:1
"""


def reason_not_to_start() -> str | None:
    search = os.environ.get("PATH", "") + ":/usr/sbin:/sbin"
    missing = [program for program in PROGRAMS if shutil.which(program, path=search) is None]
    if missing:
        return f"not installed: {', '.join(missing)} (apt-get install slurm-wlm)"
    if os.geteuid() != 0:
        return "slurmd needs root"
    if not pathlib.Path("/sys/fs/cgroup").is_mount():
        return "slurmd needs /sys/fs/cgroup"
    return None


def free_port() -> int:
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        return int(listening.getsockname()[1])


@contextlib.contextmanager
def slurm_node(folder: pathlib.Path):
    """Yields run(program, *arguments) with the environment of this cluster. Raises RuntimeError if it does not start."""
    host = socket.gethostname().split(".")[0]
    for name in ("spool", "state"):
        (folder / name).mkdir(parents=True)
    folder.chmod(0o755)
    configuration = folder / "slurm.conf"
    configuration.write_text(CONFIGURATION.format(host=host, controller=free_port(), node=free_port(), folder=folder))
    key = folder / "munge.key"
    key.write_bytes(os.urandom(128))
    key.chmod(0o400)
    environment = {**os.environ, "SLURM_CONF": str(configuration)}
    environment["PATH"] += ":/usr/sbin:/sbin"

    def run(*command) -> subprocess.CompletedProcess:
        return subprocess.run(
            [str(part) for part in command], env=environment, capture_output=True, text=True, check=False, cwd=folder
        )

    munge = [f"--{name}={folder}/munge.{end}" for name, end in (("key-file", "key"), ("socket", "socket"))]
    munge += [f"--{name}={folder}/munge.{end}" for name, end in (("pid-file", "pid"), ("log-file", "log"))]
    daemons = [
        ["munged", "--foreground", "--force", f"--seed-file={folder}/munge.seed", *munge],
        ["slurmctld", "-D", "-i"],
        ["slurmd", "-D", "-N", host],
    ]
    started = []
    try:
        for command in daemons:
            with (folder / f"{command[0]}.out").open("wb") as out:
                started.append(subprocess.Popen(command, env=environment, stdout=out, stderr=out))
            if command[0] == "munged":
                wait_for(lambda: (folder / "munge.socket").exists(), started)
        wait_for(lambda: "idle" in run("sinfo", "--noheader", "--format=%t").stdout, started)
        yield run
    finally:
        for process in reversed(started):
            process.terminate()
        for process in started:
            process.wait()


def wait_for(condition, daemons) -> None:
    end = time.monotonic() + READY_S
    while not condition():
        ended = [p.args[0] for p in daemons if p.poll() is not None]
        if ended or time.monotonic() > end:
            raise RuntimeError(f"{ended[0]} has ended" if ended else "the node does not become idle")
        time.sleep(0.1)
