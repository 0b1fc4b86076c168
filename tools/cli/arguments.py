"""Options of a verb: from a dataclass to ``argparse``, and from the command line to the dataclass.

The name, type and default of a field say how its option is written: ``bool`` is a flag, a sequence
takes several values, a tuple so many, ``Literal`` a choice. Its metadata have help, placeholder and
group, from ``options.json``.
"""

import argparse
import sys
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import MISSING, Field, dataclass, field, fields, is_dataclass
from inspect import get_annotations
from itertools import chain
from pathlib import Path
from types import NoneType, UnionType
from typing import TYPE_CHECKING, Any, Literal, get_args, get_origin, get_type_hints

from ...errors import read_json
from ...solver.calibration import UsageError
from ...solver.identification import data

if TYPE_CHECKING:
    from typing_extensions import dataclass_transform
else:  # Python 3.10 has none

    def dataclass_transform(**_):
        """Do nothing: the decorator is for type checkers."""
        return lambda cls: cls


POSITIVE = (5e-324, sys.float_info.max)
"""Range of any positive number."""
NOT_NEGATIVE = (0.0, sys.float_info.max)
MILLIMETRES = (1e-4, 1e4)
"""Range of a length in millimetres."""


def option(
    default: Any = None,
    text: str = "",
    metavar: str | tuple[str, ...] | None = None,
    *,
    group: str | None = None,
    **more: Any,
) -> Any:
    """Field of a dataclass that is an option of a verb.

    Args:
        default: Value where the option is not given; ``...`` if it must be given.
        text: Its help: the value, its unit, its default.
        metavar: Placeholder of the value; as many as there must be values.
        group: Title under which the help lists it.
        **more: ``choices``; ``between``, the lowest and the highest number; ``repeated``, for a
            value each time the option is given; ``usual``, what stands in its help for ``{}``;
            ``needs``, options without which it has no effect; ``unless``, options that exclude it.
    """
    metadata = {"text": text, "metavar": metavar, "group": group}
    return field(
        default=MISSING if default is ... else default, metadata=metadata | more
    )


_RANGES = {
    "positive": POSITIVE,
    "not negative": NOT_NEGATIVE,
    "millimetres": MILLIMETRES,
}
"""Ranges by their names in the table."""
_TABLE: dict[str, dict[str, dict[str, Any]]] = read_json(
    Path(__file__).with_name("options.json")
)
"""Descriptions of options by class and field, with the keywords of :func:`option`."""


def _in_tuples(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return a row of the table with tuples for lists, and the range that it names."""
    about = dict(row)
    for key, value in row.items():
        if isinstance(value, list):
            about[key] = tuple(value)  # pyright: ignore[reportUnknownArgumentType]
        elif key == "between":
            about[key] = _RANGES[value]
    return about


def argument(text: str, metavar: str | None = None, **more: Any) -> Any:
    """Field of a dataclass that is an argument without a name; of several if it is a sequence."""
    return option(..., text, metavar, positional=True, **more)


def part(options: type[Any], names: str = "", group: str | None = None) -> Any:
    """Field of a dataclass that holds another one, of which the options named are offered."""
    all_names = [entry.name for entry in fields(options)]
    return field(
        default_factory=options,
        metadata={"names": names.split() or all_names, "group": group},
    )


@dataclass_transform(kw_only_default=True, frozen_default=True)
class Options:
    """Base of the options of a verb: each subclass is a frozen dataclass, made by keywords.

    The help lists the options of a subclass under the title of its ``group``. ``options.json``
    describes the fields of mukca's own classes, by their names, where :func:`option` does not.
    """

    def __init_subclass__(cls, group: str | None = None) -> None:
        cls._group = group
        rows = (
            _TABLE.get(cls.__name__.strip("_"), {})
            if cls.__module__.startswith("mukca.")
            else {}
        )
        for name, row in rows.items():
            default = vars(cls).get(name, ...)
            setattr(cls, name, option(default, **_in_tuples(row)))
        dataclass(frozen=True, kw_only=True)(cls)


def option_names(options: Any) -> list[str]:
    """Return the options of a dataclass, or of a union of them, as they are typed."""
    kinds = get_args(options) if isinstance(options, UnionType) else (options,)
    rows = chain.from_iterable(map(_described, kinds))
    return [_typed(e.name) for e, _, about in rows if not about.get("positional")]


def add_options(
    parser: argparse.ArgumentParser, options: Any, names: Collection[str] | None = None
) -> None:
    """Add the options of a dataclass; or of a union of them, each an experiment with a name.

    The help has those ``names`` alone, None for all.
    """
    if isinstance(options, UnionType):
        kinds = parser.add_subparsers(
            dest="experiment", metavar="EXPERIMENT", required=True
        )
        for kind in get_args(options):
            line = kind.line
            sub = kinds.add_parser(kind.experiment, help=line, description=line)
            add_options(sub, kind)
        return
    groups: dict[str | None, Any] = {None: parser}
    for entry, kind, about in _described(options):
        title = about["group"]
        if title not in groups:
            groups[title] = parser.add_argument_group(title)
        name = entry.name
        keywords = _keywords(kind, about)
        if not about.get("positional"):
            name = _typed(name)
            if entry.default is MISSING:
                keywords["required"] = True
            if names is not None and name.removeprefix("--") not in names:
                keywords["help"] = argparse.SUPPRESS
        groups[title].add_argument(name, **keywords)
    parser.set_defaults(options=options)


def read_options(arguments: argparse.Namespace) -> Any:
    """Return the dataclass of the parsed options.

    Raises:
        UsageError: A number out of its range, or an option that would have no effect.
    """
    values = vars(arguments)
    for entry, _, about in _described(arguments.options):
        if entry.name not in values:
            continue
        typed_name = _typed(entry.name)
        for name in about.get("needs", "").split():
            if name not in values:
                words = f"{typed_name} goes with {_typed(name)}"
                raise UsageError(f"{words}, which is not given")
        for name in about.get("unless", "").split():
            if name in values:
                raise UsageError(
                    f"{typed_name} and {_typed(name)}: give one of the two"
                )
    return _read(arguments.options, values)


def _read(options: type[Any], given: Mapping[str, Any]) -> Any:
    values: dict[str, Any] = {}
    for entry in fields(options):
        if is_dataclass(entry.type):
            nested = {n: given[n] for n in entry.metadata["names"] if n in given}
            values[entry.name] = _read(entry.type, nested)  # pyright: ignore[reportArgumentType]
        elif entry.name in given:
            value = given[entry.name]
            values[entry.name] = tuple(value) if isinstance(value, list) else value  # pyright: ignore[reportUnknownArgumentType]
            _check_range(entry, values[entry.name])
    return options(**values)


def _described(
    options: type[Any], names: Sequence[str] = (), group: str | None = None
) -> Iterator[tuple["Field[Any]", Any, Mapping[str, Any]]]:
    """Yield fields, types and descriptions, those of the class before those of its bases."""
    hints = get_type_hints(options)
    by_name = {entry.name: entry for entry in fields(options)}
    groups: dict[str, str | None] = {}
    for base in options.__mro__:
        for name in get_annotations(base):
            groups[name] = groups.get(name) or vars(base).get("_group")
    for name, group_of_class in groups.items():
        if name not in by_name or (names and name not in names):
            continue
        entry = by_name[name]
        kind = hints[name]
        about = dict(entry.metadata)
        about["group"] = group or about["group"] or group_of_class
        if "names" in about:
            yield from _described(kind, about["names"], about["group"])
        else:
            yield entry, kind, about | {"text": _help(about, entry.default)}


def _keywords(kind: Any, about: Mapping[str, Any]) -> dict[str, Any]:
    """Return the keywords of ``add_argument`` for a type and a description."""
    keywords: dict[str, Any] = {
        "help": about["text"].replace("%", "%%"),
        "default": argparse.SUPPRESS,
    }
    kinds = [member for member in get_args(kind) if member is not NoneType]
    if get_origin(kind) is UnionType or NoneType in get_args(kind):
        kind = next(
            (member for member in kinds if get_origin(member) is Sequence), kinds[0]
        )
    if kind is bool:
        return {**keywords, "action": "store_true"}
    if get_origin(kind) in (tuple, Sequence):
        if about.get("repeated"):
            keywords["action"] = "append"
        else:
            words: tuple[str, ...] | str = about["metavar"]
            keywords["nargs"] = len(words) if isinstance(words, tuple) else "+"
            if get_origin(kind) is Sequence:
                keywords["action"] = "extend"  # typed twice, it adds to what it had
        kind = get_args(kind)[0]
        kind = get_args(kind)[0] if get_origin(kind) is UnionType else kind
    if kind is float:
        kind = {"M": data.metres, "MM": data.millimetres}.get(about["metavar"], float)
    choices = get_args(kind) if get_origin(kind) is Literal else about.get("choices")
    keywords |= {"choices": choices} if choices else {"type": kind}
    return {**keywords, "metavar": about["metavar"]}


def _help(about: Mapping[str, Any], default: Any) -> str:
    text: str = about["text"].replace("{}", str(about.get("usual")))
    default = about.get("default", default)
    if default in (MISSING, None, False, "", ()) or "(default: " in text:
        return text
    words = (f"{v:g}" if isinstance(v, float) else str(v) for v in _each(default))
    return f"{text} (default: {' '.join(words)})".strip()


def _check_range(entry: "Field[Any]", value: Any) -> None:
    if "between" not in entry.metadata or value is None:
        return
    low, high = entry.metadata["between"]
    words = {POSITIVE: "a positive number", NOT_NEGATIVE: "0 or more"}
    expected = words.get((low, high), f"{low:g} to {high:g}")
    is_length = entry.name.endswith("distance")
    for number in _each(value):
        if not low <= number <= high:
            advice = " metres" * is_length
            if is_length and low <= number / 1e3 <= high:
                advice += f"; did you mean {number / 1e3:g}?"
            raise UsageError(
                f"{_typed(entry.name)} {number:g}: expected {expected}{advice}"
            )


def _each(value: Any) -> Sequence[Any]:
    return value if isinstance(value, tuple) else (value,)  # pyright: ignore[reportUnknownVariableType]


def _typed(name: str) -> str:
    return f"--{name.replace('_', '-')}"
