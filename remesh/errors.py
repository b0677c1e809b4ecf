"""The errors that pmesh raises: each says what was asked, what was given and what to do."""

from __future__ import annotations


class PmeshError(Exception):
    """Base of every error that pmesh raises on purpose."""

    def __init__(self, problem: str, *, hint: str | None = None) -> None:
        self.problem = problem
        self.hint = hint
        super().__init__(problem if hint is None else f"{problem}\n  try: {hint}")


class InputError(PmeshError, ValueError):
    """The user's input cannot be used; nothing was computed or written."""


def as_number(name: str, value: object, *, hint: str | None = None) -> float:
    """The value as a float, NaN and infinity included; refuses what is not a real number."""
    if isinstance(value, str | bytes | complex):
        raise InputError(f"{name} must be a number, got {value!r}", hint=hint)
    try:
        return float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} must be a number, got {value!r}", hint=hint) from error


def as_whole(name: str, value: object, *, least: int, hint: str | None = None) -> int:
    """The value as an int; refuses what is no whole number, booleans, and less than ``least``."""
    number = as_number(name, value, hint=hint)
    if isinstance(value, bool) or not number.is_integer() or number < least:
        raise InputError(f"{name} must be a whole number >= {least}, got {value}", hint=hint)
    return int(number)


class BlowUpError(PmeshError, ArithmeticError):
    """A running computation broke; ``kept`` says where the last good state is."""

    state: object = None  # the last good state itself, where the error knows it

    def __init__(self, problem: str, *, hint: str | None = None, kept: str | None = None) -> None:
        super().__init__(problem, hint=hint)
        if kept is not None:
            advice = "" if hint is None else f"  try: {hint}"
            self.args = (f"{problem}\n  Last good state: {kept}.{advice}",)


class StorageError(PmeshError, OSError):
    """A file could not be read or written as asked."""
