"""The options of a case: fields with a default, help and unit; read from text, TOML and Python."""

from __future__ import annotations

import dataclasses
import difflib
import math
import types
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

from remesh.errors import InputError

T = TypeVar("T")
LONG, WHOLE = 8, 10_000  # characters of a number to leave as it is, the largest denominator
EXAMPLES = {"float": "0.5", "int": "128", "bool": "true", "float ...": "0.5,1.0"}


def option(default: T, help: str, *, unit: str = "", choices: Iterable[str] = ()) -> T:
    """A field of a case with its default, help, unit such as "L/T", and the words it may be."""
    metadata = {"help": help, "unit": unit, "choices": tuple(choices)}
    return dataclasses.field(default=default, metadata=metadata)


@dataclass(frozen=True)
class Option:
    """What is known about one option of a case."""

    name: str
    kind: Any  # float, int, bool, str, or tuple[one of them, ...]
    optional: bool  # whether it may be None
    default: Any
    help: str
    unit: str
    choices: tuple[str, ...]

    @property
    def flag(self) -> str:
        """How the command line spells it."""
        return "--" + self.name.replace("_", "-")

    @property
    def word(self) -> str:
        """What kind of value it takes, in a word or two."""
        if self.choices:
            return "|".join(self.choices)
        return f"{_item(self.kind).__name__} ..." if _many(self.kind) else str(self.kind.__name__)

    def parse(self, text: str) -> Any:
        """The value that a text on the command line means; fractions such as 1/64 are numbers."""
        if self.optional and text.lower() in ("none", "auto"):
            return None
        try:
            if _many(self.kind):
                parts = text.replace(",", " ").split()
                return self.check(tuple(_parse(_item(self.kind), part) for part in parts))
            return self.check(_parse(self.kind, text))
        except (ValueError, ZeroDivisionError) as error:
            if isinstance(error, InputError):
                raise
            raise self.refusal(text) from error

    def check(self, value: Any) -> Any:
        """The value in the option's type: an int is a float, a list a tuple, and no more."""
        if value is None and self.optional:
            return None
        if _many(self.kind):
            if not isinstance(value, tuple | list):
                raise self.refusal(value)
            value = tuple(self._fit(_item(self.kind), part) for part in value)
            counts = [kind for kind in get_args(self.kind) if kind is not Ellipsis]
            if Ellipsis not in get_args(self.kind) and len(value) != len(counts):
                raise self.refusal(value)
            return value
        value = self._fit(self.kind, value)
        if self.choices and value not in self.choices:
            raise InputError(
                f"{self.name} must be one of {', '.join(self.choices)}, got {value!r}",
                hint=f"{self.flag} {closest(str(value), self.choices) or self.choices[0]}",
            )
        return value

    def _fit(self, kind: type, value: Any) -> Any:
        whole = isinstance(value, int) and not isinstance(value, bool)
        if kind is float and (whole or isinstance(value, float)):
            if not math.isfinite(value):
                raise self.refusal(value)
            return float(value)
        if kind is int and whole:
            return value
        if kind in (bool, str) and isinstance(value, kind):
            return value
        raise self.refusal(value)

    def refusal(self, value: Any) -> InputError:
        """The error for a value of the wrong kind."""
        example = (
            spelt(self.default) if self.default is not None else EXAMPLES.get(self.word, self.word)
        )
        return InputError(
            f"{self.name} must be {self.kinds}, got {value!r}", hint=f"{self.flag} {example}"
        )

    @property
    def kinds(self) -> str:
        """What kind of value it takes, in a sentence."""
        if not _many(self.kind):
            return KINDS[self.kind]
        parts = get_args(self.kind)
        count = "any number of" if Ellipsis in parts else str(len(parts))
        return f"{count} {'words' if _item(self.kind) is str else 'numbers'}"


KINDS = {float: "a finite number", int: "a whole number", bool: "true or false", str: "a word"}


def options(cls: type) -> dict[str, Option]:
    """The options of a case's class by name, in the order of their definition."""
    hints = get_type_hints(cls)
    return {part.name: _option(part, hints[part.name]) for part in dataclasses.fields(cls)}


def _option(part: dataclasses.Field[Any], kind: Any) -> Option:
    optional = get_origin(kind) in (Union, types.UnionType) and type(None) in get_args(kind)
    if optional:
        (kind,) = (arg for arg in get_args(kind) if arg is not type(None))
    choices = tuple(part.metadata.get("choices", ()))
    if get_origin(kind) is Literal:
        kind, choices = str, get_args(kind)
    return Option(
        part.name,
        kind,
        optional,
        part.default,
        part.metadata.get("help", ""),
        part.metadata.get("unit", ""),
        choices,
    )


def checked(cls: type, values: Mapping[str, Any]) -> dict[str, Any]:
    """The values for a class in the types of its options; refuses unknown names and bad values."""
    known = options(cls)
    for name in values:
        if name not in known:
            raise unknown("option", name, known)
    return {name: known[name].check(value) for name, value in values.items()}


def unknown(what: str, name: str, known: Iterable[str]) -> InputError:
    """The error for a name that is none of the known ones, with the closest of them."""
    known = list(known)
    best = closest(name, known)
    return InputError(
        f"there is no {what} {name!r}" + (f", did you mean {best!r}?" if best else ""),
        hint=best or f"one of {', '.join(known)}",
    )


def closest(name: str, known: Iterable[str]) -> str | None:
    """The known name that looks most like this one, if any does."""
    best = difflib.get_close_matches(name, list(known), n=1, cutoff=0.55)
    return best[0] if best else None


def spelt(value: Any) -> str:
    """The text that means a value on the command line, such as 1/12 for that fraction."""
    if isinstance(value, tuple | list):
        return ",".join(spelt(part) for part in value)
    if value is None or isinstance(value, bool):
        return "auto" if value is None else str(value).lower()
    if isinstance(value, float):
        return _number(value)
    return str(value) or '""'


def _number(value: float) -> str:
    """Twelve digits, or the fraction that a long number is to round-off."""
    text = f"{value:.12g}"
    if len(text) <= LONG or not math.isfinite(value):
        return text
    part = Fraction(value).limit_denominator(WHOLE)
    return str(part) if part and abs(float(part) / value - 1.0) < 4e-16 else text


def _parse(kind: type, text: str) -> Any:
    if kind is float:
        return float(Fraction(text)) if "/" in text else float(text)
    if kind is int:
        return int(text)
    if kind is bool:
        words = {"true": True, "yes": True, "on": True, "false": False, "no": False, "off": False}
        if text.lower() not in words:
            raise ValueError(text)
        return words[text.lower()]
    return text


def _many(kind: Any) -> bool:
    return get_origin(kind) is tuple


def _item(kind: Any) -> Any:
    return get_args(kind)[0]
