"""The verb `mapless batch`."""

from __future__ import annotations

import argparse
import os
import shlex
import signal
import sys
from typing import TYPE_CHECKING, NoReturn

from mapless.batch import parts, run as local, storage
from mapless.batch.errors import BatchError, ExitCode
from mapless.batch.plan import Task, absolute, make_task, read_plan, read_task, write_plan
from mapless.batch.progress import Progress
from mapless.batch.task import MAPLESS, reader_options, run_task

if TYPE_CHECKING:
    from mapless.batch.drives import Drive

PLAN_COPY = "plan.jsonl"
DEFAULT_RETRIES = 2
UNCUT = {"--first", "--count", "--realtime", "--resume"}  # options of detect that parts have of their own, or cannot have
EPILOGUE = """exit codes: 0 all is done; 1 failure of the environment; 2 wrong usage; 3 bad data, trying again cannot help;
4 finished, not all of it trustworthy; 75 trying again can help; 130 interrupted. docs/fleet.md has engines and examples."""


def say(text: str) -> None:
    print(f"mapless: {text}", file=sys.stderr)


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise BatchError(f"{message}; see {self.prog} --help")


def _positive(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text}: expected 1 or more")
    return value


def _not_negative(text: str) -> int:
    value = int(text)
    if value < 0:
        raise argparse.ArgumentTypeError(f"{text}: expected 0 or more")
    return value


def _chunk(text: str) -> int:
    value = int(text)
    if value < parts.FEWEST_SCANS:
        raise argparse.ArgumentTypeError(f"{text}: expected {parts.FEWEST_SCANS} or more, twice what is labelled before a part")
    return value


def parser() -> argparse.ArgumentParser:
    top = _Parser(prog="mapless batch", description="Label many recordings.", epilog=EPILOGUE)
    verbs = top.add_subparsers(dest="verb", required=True, metavar="VERB")

    plan = verbs.add_parser("plan", help="find the drives below folders or URIs, one line each", epilog=EPILOGUE)
    plan.add_argument("roots", nargs="+", metavar="ROOT", help="folder, file or URI (s3://bucket/drives)")
    plan.add_argument("-o", "--output", required=True, help="the plan: JSON lines")
    plan.add_argument("--sensor", default="", help="sensor of all drives: a name or a calibration file")
    plan.add_argument(
        "--options", default="", metavar="TEXT", help="of mapless detect, for all drives: --options '--causal --odometry'"
    )
    plan.add_argument(
        "--view", type=_not_negative, default=0, metavar="SCANS",
        help="add a page of mapless view to each result, which shows SCANS scans at equal distances (default: no page)",
    )  # fmt: skip
    plan.add_argument(
        "--chunk", type=_chunk, default=0, metavar="SCANS",
        help="cut each drive that has poses into parts of SCANS scans or more, one task for each part; the task that ends "
        "last joins the labels, which are the bytes of one run. Drives without poses and drives behind URIs are not cut "
        "(default: no drive is cut)",
    )  # fmt: skip
    plan.add_argument("--evaluate", action="store_true", help="compare with the true labels of the recordings")

    run = verbs.add_parser("run", help="label the drives of a plan that are not done", epilog=EPILOGUE)
    run.add_argument("plan", help="made by mapless batch plan")
    run.add_argument("-o", "--output", required=True, metavar="RESULTS", help="folder or URI of all results")
    run.add_argument("--index", type=_not_negative, help="do one line of the plan, from 0: what every engine calls")
    run.add_argument("--jobs", type=_positive, help="drives at once (default: cores / threads, memory permitting)")
    run.add_argument("--threads", type=_positive, default=1, help="threads for each drive (default: 1)")
    run.add_argument(
        "--retries", type=_not_negative, default=DEFAULT_RETRIES, help="further tries after a kill or a full disk"
    )
    run.add_argument("--scratch", help="local folder for drives and results of URIs (default: that of TMPDIR)")
    run.add_argument(
        "--ray", nargs="?", const="", metavar="ADDRESS", help="on the workers of a Ray cluster (default: a local one)"
    )
    run.add_argument(
        "--command", metavar="TEXT", help="in place of mapless, in a container for example: 'apptainer run mapless.sif'"
    )

    sum_up = verbs.add_parser("merge", help="one table and one page over all drives", epilog=EPILOGUE)
    sum_up.add_argument("results", metavar="RESULTS", help="folder or URI that mapless batch run has filled")
    sum_up.add_argument("--plan", help="default: the copy of the plan in RESULTS")
    return top


def absolute_sensor(sensor: str) -> str:
    """Tasks run in other folders: a calibration file is named from the root."""
    return absolute(sensor) if os.path.exists(sensor) else sensor


def parts_of(drive: Drive, options: tuple[str, ...], chunk: int) -> int:
    """Along own odometry no two runs of different starts agree to the byte, so a drive without poses stays whole."""
    flags = {option.split("=")[0] for option in options}
    if chunk and flags & UNCUT:
        raise BatchError(f"--chunk: not with {', '.join(sorted(flags & UNCUT))} among --options")
    poses = "--odometry" not in flags and (drive.poses or bool(flags & {"--trajectory", "--stationary"}))
    if not chunk or drive.scans is None or drive.scans < 2 * chunk:
        return 1
    if not poses:
        say(f"not cut: {drive.path}: it has no poses")
        return 1
    return drive.scans // chunk


def plan_verb(given: argparse.Namespace) -> int:
    from mapless.batch.drives import find_drives  # loads every reader; a task needs none

    options = tuple(shlex.split(given.options))
    if given.sensor:
        options = ("--sensor", absolute_sensor(given.sensor), *options)
    drives, refused = find_drives(given.roots, given.sensor, reader_options(options))
    for refusal in refused:
        reason = refusal.reason.removeprefix(f"{refusal.path}: ")
        say(f"refused: {refusal.path}: {reason}")
    if not drives:
        raise BatchError(f"{', '.join(given.roots)}: no drive that can be read", ExitCode.BAD_INPUT)
    tasks = [
        part
        for drive in drives
        for part in make_task(drive, options, given.evaluate, given.view).cut(parts_of(drive, options, given.chunk))
    ]
    write_plan(given.output, tasks)
    lines = f" ({len(tasks)} tasks)" if len(tasks) > len(drives) else ""
    print(f"{len(drives)} drives{lines} in {given.output}" + (f", {len(refused)} refused" if refused else ""))
    return ExitCode.NOT_TRUSTED if refused else ExitCode.SUCCESS


def keep_plan(plan: str, results: str) -> None:
    """A copy for `merge`."""
    storage.require_place(results)
    content = storage.read_bytes(plan)
    place = storage.joined(results, PLAN_COPY)
    if content is not None and storage.read_bytes(place) != content:
        storage.write_bytes(place, content)


def flags_of(given: argparse.Namespace) -> list[str]:
    """Options that every task of a run gets too."""
    flags = ["--threads", str(given.threads)]
    for name in ("scratch", "command"):
        if getattr(given, name):
            flags += [f"--{name}", getattr(given, name)]
    return flags


def run_verb(given: argparse.Namespace) -> int:
    given.plan, given.output = absolute(given.plan), absolute(given.output)
    command = shlex.split(given.command) if given.command else MAPLESS
    if given.index is not None:
        task = read_task(given.plan, given.index)
        storage.require_place(given.output)
        return run_task(task, given.output, scratch=given.scratch, threads=given.threads, command=command)
    plan: list[Task] = read_plan(given.plan)
    keep_plan(given.plan, given.output)
    index_command = local.index_command(given.plan, given.output, flags_of(given))
    run: local.Engine
    if given.ray is not None:
        from mapless.batch.engines.ray import RayRun

        run = RayRun(index_command, given.ray, given.threads, given.retries).run
    else:
        jobs = given.jobs or max(1, local.usable_cores() // given.threads)
        run = local.LocalRun(index_command, jobs, given.retries).run
    counts = local.run_plan(plan, given.output, run, Progress())
    for line in counts.lines():
        say(line)
    return counts.exit_code()


def merge_verb(given: argparse.Namespace) -> int:
    from mapless.batch.merge import merge

    results = absolute(given.results)
    plan = read_plan(given.plan or storage.joined(results, PLAN_COPY))
    rows, sums = merge(plan, results)
    states = ", ".join(f"{count} {state}" for state, count in sums["states"].items())
    print(f"{len(rows)} drives: {states}\n{storage.joined(results, 'index.html')}")
    return ExitCode.SUCCESS


def main(arguments: list[str]) -> int:
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        given = parser().parse_args(arguments)
        verbs = {"plan": plan_verb, "run": run_verb, "merge": merge_verb}
        return int(verbs[given.verb](given))
    except BatchError as error:
        print(f"mapless: error: {error}", file=sys.stderr)
        return error.exit_code
    except OSError as error:
        place = error.filename2 or error.filename
        what = f"{place}: {error.strerror}; check the path and its permissions" if place else error
        print(f"mapless: error: {what}", file=sys.stderr)
        return int(ExitCode.TEMPORARY if error.errno in (28, 122) else ExitCode.FAILURE)
    except KeyboardInterrupt:
        say("interrupted; what is done is kept, the same command goes on with the rest")
        return int(ExitCode.INTERRUPTED)
