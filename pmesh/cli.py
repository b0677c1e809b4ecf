"""The ``pmesh`` command: list the named cases, run one, go on with one, look at what it left."""

from __future__ import annotations

import contextlib
import logging
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click

from pmesh.cases.registry import CASES
from remesh.errors import BlowUpError, InputError, PmeshError, StorageError

if TYPE_CHECKING:
    from pmesh.cases.case import Case
    from pmesh.cases.options import Option

EXIT_INPUT, EXIT_BLOW_UP, EXIT_STORAGE, EXIT_INTERRUPT = 2, 3, 4, 130


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(package_name="pmesh-flow")
def command() -> None:
    """Flows computed with particles that are remeshed onto a grid."""


@command.command()
def cases() -> None:
    """List the named cases."""
    width = max(map(len, CASES))
    for name, entry in CASES.items():
        click.echo(f"{name:{width}}  {entry.line}")


class CaseGroup(click.Group):
    """The named cases as commands; a case is imported when it is asked for, not to be listed."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """The names of the cases."""
        return list(CASES)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write a line per case, without importing it."""
        with formatter.section("Cases"):
            formatter.write_dl([(name, entry.line) for name, entry in CASES.items()])

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command:
        """The command that runs a case, or what a TOML file asks for."""
        return _case_command(cmd_name)


@command.group(
    cls=CaseGroup,
    subcommand_metavar="CASE [OPTIONS]...",
    epilog="CASE may also be a FILE.toml, such as the case.toml of a run, or a case of your own as "
    "file.py:Class. `pmesh run CASE --help` lists the options of a case.",
)
def run() -> None:
    """Run a case: a name from the list, or FILE.toml."""


def _case_command(name: str) -> click.Command:
    """The command for one case, with an option for every field of its class."""
    from pmesh.cases.options import checked, options
    from pmesh.cases.registry import find

    preset: dict[str, Any] = {}
    if name.endswith(".toml"):
        from pmesh.cases.runner import read_case

        name, preset = read_case(Path(name))
    cls = find(name)
    known, preset = options(cls), checked(cls, preset)

    def start(out: str | None, quick: bool, **rest: Any) -> None:
        texts = {key: rest.pop(key) for key in known}
        given = {key: known[key].parse(text) for key, text in texts.items() if text is not None}
        folder = Path(out or Path("out") / name.rpartition(":")[2])
        _start(cls, name, {**preset, **given}, folder, quick, **rest)

    fields = [_click_option(known[key], preset) for key in known]
    line = CASES[name].line if name in CASES else cls.source
    text = f"{(cls.__doc__ or '').strip().splitlines()[0]}\n\n{line}"
    return click.Command(name, callback=start, params=[*fields, *COMMON, _quick(cls)], help=text)


def _quick(cls: type[Case]) -> click.Option:
    """The option for a quick run, with what it sets."""
    from pmesh.cases.options import options, spelt

    known, text = options(cls), "a short, coarse run, to see that all works"
    short = " ".join(f"{known[name].flag} {spelt(value)}" for name, value in cls.short.items())
    return click.Option(["--quick"], is_flag=True, help=f"{text}: {short}" if short else text)


def _click_option(option: Option, preset: dict[str, Any]) -> click.Option:
    """An option of the command line; its text is read by the case's own rules."""
    from pmesh.cases.options import spelt

    unit = f" [{option.unit}]" if option.unit else ""
    default = preset.get(option.name, option.default)
    return click.Option(
        [option.flag, option.name],
        metavar=option.word.upper() if not option.choices else option.word,
        help=f"{option.help}{unit}  [default: {spelt(default)}]",
    )


COMMON: list[click.Parameter] = [
    click.Option(["--out"], metavar="DIR", help="run directory  [default: out/CASE]"),
    click.Option(["--resume"], is_flag=True, help="go on from the checkpoint in the directory"),
    click.Option(["--overwrite"], is_flag=True, help="replace the run in the directory"),
    click.Option(["--estimate"], is_flag=True, help="tell memory and time, take a few steps, stop"),
    click.Option(
        ["--checkpoint-every"],
        type=float,
        default=30.0,
        metavar="SECONDS",
        help="work at risk between two checkpoints  [default: 30]",
    ),
]


def _start(
    cls: Any,
    name: str,
    values: dict[str, Any],
    folder: Path,
    quick: bool,
    *,
    resume: bool,
    overwrite: bool,
    estimate: bool,
    checkpoint_every: float,
) -> None:
    """Run the case with a progress line, and close with the metrics table."""
    if resume and overwrite:
        raise InputError("--resume and --overwrite exclude each other", hint="one of them")
    from pmesh.cases.runner import resumed_values, run_case
    from pmesh.run.progress import Progress
    from pmesh.run.summary import show

    if resume:
        values = resumed_values(folder, name, values)
    case = cls.make(values, quick=quick)
    if estimate:
        click.echo(_forecast(case))
        return
    run_case(
        name,
        case,
        folder,
        resume=resume,
        overwrite=overwrite,
        watch=[Progress()],
        checkpoint_every=checkpoint_every,
        told=lambda metrics, cost: show(case.title, metrics, cost),
    )
    names = ("figure.png", "fields.vtkhdf", "series.csv", "summary.json")
    click.echo(f"{folder}/: {', '.join(name for name in names if (folder / name).exists())}")


def _forecast(case: Case) -> str:
    """What a run of the case would take, and the size that would fit if it does not."""
    from pmesh.cases.fitting import advice, forecast

    told = forecast(case)
    return str(told) if told.fits else f"{told}\n  try: {advice(case, told.free or 0)}"


@command.command()
@click.argument("folder", metavar="DIR")
@click.option("--field", metavar="NAME", help="which  [default: vorticity, else the interface]")
@click.option("--fps", default=12.0, metavar="N", help="snapshots a second  [default: 12]")
@click.option("--format", "kind", default="gif", metavar="gif|mp4", help="[default: gif]")
@click.option("--follow", is_flag=True, help="keep the bodies in the middle")
@click.option("--limit", type=float, metavar="X", help="where colours saturate  [default: by run]")
@click.option("--pixels", default=640, metavar="N", help="along the longer side  [default: 640]")
@click.option("--mesh", is_flag=True, help="outline the blocks of an adaptive run")
@click.option(
    "--level", metavar="X[,X]", help="in space: of the surfaces  [default: a share of the extreme]"
)
@click.option(
    "--colour", "colour_by", metavar="NAME", help="in space: field of the colours, or none"
)
@click.option(
    "--view", metavar="A,E", help="in space: azimuth, elevation  [default: -55,22 degrees]"
)
@click.option("--slice", "cut", metavar="z=0", help="in space: a plane instead of surfaces")
@click.option("--snapshots", "name", metavar="NAME", help="such as fields-2  [default: fields]")
@click.option("--out", metavar="FILE", help="[default: DIR/movie.gif]")
def movie(folder: str, out: str | None, level: str | None, view: str | None, **given: Any) -> None:
    """Make a movie of a run from its snapshots.

    In space it shows lit surfaces, of the size of the vorticity or, with bodies, of lambda2, in the
    colours of another field; --field may be lambda2, q, helicity, and any scalar, vector (its size)
    or component (vorticity_x) that the snapshots hold.
    """
    from pmesh.cases.movie import movie as make

    given["level"] = None if level is None else _numbers("--level", level)
    given["view"] = None if view is None else _numbers("--view", view, 2)
    click.echo(make(folder, out, **given))


def _numbers(flag: str, text: str, count: int | None = None) -> tuple[float, ...]:
    """Numbers with commas between them."""
    try:
        found = tuple(float(word) for word in text.replace(",", " ").split())
    except ValueError:
        found = ()
    if not found or (count is not None and len(found) != count):
        some = f"{count} numbers" if count else "numbers"
        raise InputError(f"{flag} takes {some}, got {text!r}", hint=f"{flag}=-55,22")
    return found


@command.command()
@click.argument("folder", metavar="DIR")
@click.option("--time", type=float, metavar="T", help="of the points  [default: the last snapshot]")
@click.option(
    "--span", type=float, metavar="T", help="to look; < 0: back  [default: - a quarter of the run]"
)
@click.option("--nodes", default=300, metavar="N", help="along the longer side  [default: 300]")
@click.option("--out", metavar="FILE", help="[default: DIR/ftle.png]")
def ftle(folder: str, out: str | None, **given: Any) -> None:
    """Draw a finite-time Lyapunov exponent: ridges that attract (span < 0) or repel."""
    from pmesh.cases.structures import ftle_picture

    click.echo(ftle_picture(folder, out, **given))


@command.command()
@click.argument("folder", metavar="DIR")
@click.option("--line", metavar="X,Y,X,Y", help="that dye leaves  [default: before the bodies]")
@click.option("--sources", default=21, metavar="N", help="points on it  [default: 21]")
@click.option("--releases", default=200, metavar="N", help="times  [default: 200]")
@click.option(
    "--start", type=float, metavar="T", help="of the dye  [default: a quarter of the run earlier]"
)
@click.option("--time", type=float, metavar="T", help="of the picture  [default: last snapshot]")
@click.option("--out", metavar="FILE", help="[default: DIR/dye.png]")
def dye(folder: str, out: str | None, line: str | None, **given: Any) -> None:
    """Draw dye that leaves a line (streaklines) over the vorticity."""
    from pmesh.cases.structures import dye_picture

    try:
        ends = None if line is None else [float(x) for x in line.replace(",", " ").split()]
    except ValueError as error:
        raise InputError(f"a line is x,y,x,y, got {line!r}", hint="--line=-2,-1,-2,1") from error
    click.echo(dye_picture(folder, out, line=ends, **given))


@command.command()
@click.argument("folder", metavar="DIR")
@click.option("--movie", default="gif", metavar="gif|mp4|none", help="[default: gif]")
@click.option("--out", metavar="FILE", help="[default: DIR/report.html]")
def report(folder: str, out: str | None, movie: Any) -> None:
    """Write one HTML page about a run, with everything in it."""
    from pmesh.cases.report import report as write

    click.echo(write(folder, out, movie=movie))


def main(arguments: list[str] | None = None) -> NoReturn:
    """The command: an error is a message and an exit status, never a traceback.

    0 done, 2 input that cannot be used, 3 a run that broke, 4 a file that could not be read or
    written, 130 interrupted.
    """
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # a batch system's end is a Ctrl-C
    try:
        with _speaking():
            sys.exit(command.main(arguments, prog_name="pmesh", standalone_mode=False) or 0)
    except PmeshError as error:
        _fail(error, _status(error))
    except click.NoSuchOption as error:
        _fail(_no_such_option(error), EXIT_INPUT)
    except click.ClickException as error:
        where = error.ctx.command_path if isinstance(error, click.UsageError) and error.ctx else ""
        _fail(InputError(error.format_message(), hint=f"{where or 'pmesh'} --help"), EXIT_INPUT)
    except (KeyboardInterrupt, click.Abort) as error:
        said = str(error.__cause__ or error) or "stopped"  # click wraps what the loop says
        click.echo(f"{said}\n  try: the same command with --resume", err=True)
        sys.exit(EXIT_INTERRUPT)


def _status(error: PmeshError) -> int:
    if isinstance(error, BlowUpError):
        return EXIT_BLOW_UP
    return EXIT_STORAGE if isinstance(error, StorageError) else EXIT_INPUT


def _fail(error: PmeshError, status: int) -> NoReturn:
    click.echo(f"{type(error).__name__}: {error}", err=True)
    sys.exit(status)


def _no_such_option(error: click.NoSuchOption) -> InputError:
    """The refusal of an unknown option, with the one that was probably meant."""
    from pmesh.cases.options import closest

    known = [flag for p in error.ctx.command.params for flag in p.opts] if error.ctx else []
    best = closest(error.option_name, known)
    where = error.ctx.command_path if error.ctx else "pmesh"
    return InputError(
        f"{where} has no option {error.option_name}" + (f", did you mean {best}?" if best else ""),
        hint=best or f"{where} --help",
    )


@contextlib.contextmanager
def _speaking() -> Iterator[None]:
    """Let the loggers of pmesh, and only those, speak on stderr for the time of a command."""
    log, handler = logging.getLogger("pmesh"), logging.StreamHandler()
    handler.setFormatter(logging.Formatter("%(message)s"))
    before = log.level, log.propagate
    log.addHandler(handler)
    log.setLevel(logging.INFO)
    log.propagate = False
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.level, log.propagate = before
