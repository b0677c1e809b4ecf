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
