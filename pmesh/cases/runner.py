"""Run a case into a directory, from its parameters to the figure and the summary."""

from __future__ import annotations

import io
import logging
import subprocess
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

from pmesh.cases.case import Case, Outcome
from pmesh.cases.fitting import refuse_too_large
from pmesh.cases.options import options
from pmesh.run import checkpoint
from pmesh.run.files import make_folder, reading, write_atomic
from pmesh.run.loop import run
from pmesh.run.protocols import Watcher
from pmesh.run.rundir import (
    CASE,
    CHECKPOINT,
    FIGURE,
    SERIES,
    SUMMARY,
    clear,
    refuse_another_run,
)
from pmesh.run.series import read_series
from pmesh.run.summary import Cost, Metric, write_summary
from remesh.errors import InputError, PmeshError

log = logging.getLogger("pmesh.cases")
FILE_KEYS = ("case", "version", "commit", "parameters")  # of case.toml; others are options
MAY_CHANGE = ("until",)  # the options that a resumed run may change


@dataclass(frozen=True, kw_only=True)
class Report:
    """A finished run: its metrics and what it cost, all its parts together."""

    outcome: Outcome
    metrics: list[Metric]
    cost: Cost


def run_case(
    name: str,
    case: Case,
    out: str | Path,
    *,
    resume: bool = False,
    overwrite: bool = False,
    watch: Sequence[Watcher] = (),
    checkpoint_every: float = 30.0,
    told: Callable[[Sequence[Metric], Cost], None] | None = None,
) -> Report:
    """Run a case into the directory ``out`` and leave there all the files of the run contract.

    Refuses, before anything is written, an ``out`` that holds another run, unless ``overwrite``;
    ``resume`` goes on from its checkpoint, with the same parameters (``until`` may change).
    Refuses too what would not fit into the memory, where that can be predicted. The summary comes
    before the figure, and ``told`` hears its numbers then; a figure that cannot be drawn is a
    warning.
    """
    folder = Path(out)
    if resume:
        _refuse_changes(name, case, folder)
    else:
        refuse_another_run(folder, overwrite=overwrite)
    refuse_too_large(case)
    flow, state = case.build()
    made = not folder.exists()
    make_folder(folder)
    try:
        if not resume:
            clear(folder)
        write_atomic(folder / CASE, case_text(name, case).encode())
        state = run(
            flow,
            state,
            until=case.until,
            watch=[*case.watchers(), *watch],
            out=folder,
            resume=True,  # of an empty directory: from the start
            checkpoint_every=checkpoint_every,
        )
    finally:
        if made and not any(folder.iterdir()):
            folder.rmdir()
    notes = checkpoint.notes(folder / CHECKPOINT)
    cost = Cost(steps=state.step, seconds=notes["seconds"], node_steps=round(notes["node_steps"]))
    outcome = Outcome(series=read_series(folder / SERIES), flow=flow, state=state, folder=folder)
    metrics = case.metrics(outcome)
    write_summary(folder / SUMMARY, name, metrics, cost)
    if told is not None:
        told(metrics, cost)
    try:
        picture = io.BytesIO()
        case.draw(outcome).savefig(picture, format="png", dpi=200)
    except PmeshError as error:
        (folder / FIGURE).unlink(missing_ok=True)  # of an earlier part of the run
        log.warning("no figure could be drawn: %s", error)
    else:
        write_atomic(folder / FIGURE, picture.getbuffer())
    return Report(outcome=outcome, metrics=metrics, cost=cost)


def case_text(name: str, case: Case) -> str:
    """The content of case.toml: the case, the version, the commit, every parameter."""
    import tomli_w

    content: dict[str, Any] = {"case": name, "version": version()}
    if found := commit():
        content["commit"] = found
    known = {key: value for key, value in case.parameters().items() if value is not None}
    return tomli_w.dumps({**content, "parameters": known})


def read_case(path: Path) -> tuple[str, dict[str, Any]]:
    """The name and the parameters in a file: ``case = "..."``, then options, in a table or not."""
    if not path.is_file():
        raise InputError(f"there is no file {path}", hint="`pmesh cases` lists the named cases")
    try:
        with reading(path):
            text = path.read_text(encoding="utf-8")
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path} is not TOML: {error}", hint='case = "cylinder"') from error
    if not isinstance(content.get("case"), str):
        raise InputError(f"{path} names no case", hint='case = "cylinder"')
    table = content.get("parameters", {})
    if not isinstance(table, dict):
        raise InputError(f"the parameters in {path} are not a table", hint="[parameters]")
    plain = {key: value for key, value in content.items() if key not in FILE_KEYS}
    if twice := sorted(set(plain) & set(table)):
        raise InputError(f"{path} gives {twice[0]!r} twice", hint="once, in [parameters] or above")
    return content["case"], {**plain, **table}


def _refuse_changes(name: str, case: Case, folder: Path) -> None:
    """Refuse to resume a run of another case or with other parameters."""
    if (folder / CHECKPOINT).exists():
        checkpoint.notes(folder / CHECKPOINT)  # it is whole
    if not (folder / CASE).exists():
        return
    other, parameters = read_case(folder / CASE)
    _warn_of_other_code(folder / CASE)
    if other != name:
        raise InputError(
            f"{folder} holds a run of {other!r}, asked to resume {name!r}",
            hint="another --out directory, or --overwrite",
        )
    for key, known in options(type(case)).items():
        kept = known.check(parameters.get(key)) if key in parameters else None
        now = getattr(case, key)
        if key not in MAY_CHANGE and kept != now:
            raise InputError(
                f"a resumed run keeps its parameters, but {key} was {kept} and is now {now}",
                hint=f"{known.flag} {kept}, or another --out directory",
            )


def _warn_of_other_code(path: Path) -> None:
    """Say so if the run was begun by other sources: then it does not go on bit for bit."""
    begun = tomllib.loads(path.read_text(encoding="utf-8"))
    before, now = (begun.get("version"), begun.get("commit")), (version(), commit())
    if before != now:
        log.warning("%s was written by pmesh %s %s, this is %s %s", path, *before, *now)


def version() -> str:
    """The version of pmesh."""
    try:
        return metadata.version("pmesh-flow")
    except metadata.PackageNotFoundError:
        return "not installed"


def commit() -> str | None:
    """The commit of pmesh's sources, with "+changes" if they differ; None outside git."""
    root = Path(__file__).parents[2]
    if not (root / ".git").exists():
        return None
    head = _git(root, "rev-parse", "HEAD")
    changed = _git(root, "status", "--porcelain", "--untracked-files=no")
    return f"{head}+changes" if head and changed else head


def _git(root: Path, *words: str) -> str | None:
    """What git answers, None where it does not."""
    try:
        answer = subprocess.run(
            ["git", "-C", str(root), *words], capture_output=True, text=True, timeout=10, check=True
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return answer.stdout.strip()


def resumed_values(folder: Path, name: str, given: Mapping[str, Any]) -> dict[str, Any]:
    """The parameters to resume with: those of the run, and what is given beside them."""
    if not (folder / CASE).exists():
        return dict(given)
    other, kept = read_case(folder / CASE)
    return {**(kept if other == name else {}), **given}
