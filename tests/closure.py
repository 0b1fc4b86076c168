"""The closure of a module: the files that it needs by its imports, and their tokens."""

import ast
import tokenize
from functools import cache

from project import ROOT

ROOMS = ("drivers", "recorder", "solver", "tools")
NO_CODE = {
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENCODING,
    tokenize.ENDMARKER,
}


@cache
def parsed(file):
    return ast.parse(file.read_text(encoding="utf-8"))


@cache
def tokens(file):
    """Number of tokens without comments and docstrings."""
    docstrings = set()
    for node in ast.walk(parsed(file)):
        match node:
            case ast.Expr(value=ast.Constant(value=str())):
                docstrings.update(range(node.lineno, node.end_lineno + 1))
    with file.open(encoding="utf-8") as text:
        code = [t for t in tokenize.generate_tokens(text.readline) if t.type not in NO_CODE]
    return sum(token.start[0] not in docstrings for token in code)


def relative_imports(file):
    """Yield the path that each relative import names, anywhere in a file, and its names."""
    for node in ast.walk(parsed(file)):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = file.parents[node.level - 1]
            yield base.joinpath(*(node.module or "").split(".")), node.names


@cache
def face(folder):
    """The names that a folder offers, each with the path and the name that it stands for."""
    file = folder / "__init__.pyi"
    if not file.exists():
        return {}
    rows = relative_imports(file)
    return {
        alias.asname or alias.name: (path, alias.name) for path, names in rows for alias in names
    }


def origin(path, name):
    """The file that a name comes from; None for a folder."""
    for file in (path.with_suffix(".py"), path / f"{name}.py"):
        if file.exists():
            return file
    return origin(*face(path)[name]) if name in face(path) else None


@cache
def needs(file):
    """The files that a file imports from, by faces, too."""
    files, folders = set(), {}
    for path, names in relative_imports(file):
        for alias in names:
            files.add(origin(path, alias.name))
            folders[alias.asname or alias.name] = path / alias.name
    for node in ast.walk(parsed(file)):
        match node:
            case ast.Attribute(value=ast.Name(id=name), attr=attribute) if name in folders:
                files.add(origin(folders[name], attribute))
    return files - {None, file}


def closure(start):
    """The files that a file needs, itself among them."""
    files, waiting = set(), {ROOT / start}
    while waiting:
        files |= waiting
        waiting = set().union(*map(needs, waiting)) - files
    return files
