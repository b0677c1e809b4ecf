"""The loop: clock, watchers, checkpoints, output and progress; ``pmesh.run(...)`` calls it."""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any


class _CallableModule(ModuleType):
    """A package that can be called: ``pmesh.run(flow, state, ...)``."""

    def __call__(self, *args: Any, **options: Any) -> Any:
        """Run the loop, see :func:`pmesh.run.loop.run`."""
        from pmesh.run.loop import run

        return run(*args, **options)


# The public name `pmesh.run` is a function and a package at once; for type checkers the face of
# pmesh declares it as the function `pmesh.run.loop.run`.
sys.modules[__name__].__class__ = _CallableModule
