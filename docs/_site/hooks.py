"""What the documentation's builder adds: the messages and the examples, taken from the code."""

import ast
import re
from collections.abc import Iterator
from html import unescape
from pathlib import Path
from typing import Any

from latex2mathml.converter import convert as latex_to_mathml

from mukca.solver.calibration import OPTION_TABLE, Option

ROOT = Path(__file__).parents[2]
ROOMS = {
    "drivers": "Drivers: the connection to the arm",
    "recorder": "Recorder: recordings and their files",
    "solver": "Solver: models, data and fits",
    "tools": "Tools: options, files and reports",
}
MESSAGES = "<!-- every message -->"
BY_HAND = "<!-- where the site has them -->"
OPTIONS = "<!-- every option -->"
EXAMPLES = "<!-- every example -->"
SOUGHT_LESS = {
    "architecture.md",
    "benchmarks.md",
    "causes/index.md",
    "examples.md",
    "gallery.md",
    "messages.md",
    "model.md",
    "recipes.md",
    "versions.md",
}
"""Pages with many words: a search names them after those that say what to do."""
SAID = {"Diagnostic", "warn"}
CODE = ast.FunctionDef | ast.Assign | ast.Call
BARE = {
    "ValueError",
    "TypeError",
    "RuntimeError",
    "OSError",
    "AttributeError",
    "AssertionError",
}


def on_startup(**_: Any) -> None:
    """Lay the package out for the API reference, whatever the folder of the clone is called."""
    package = ROOT / "build/api/mukca"
    package.mkdir(parents=True, exist_ok=True)
    for name in ("__init__.py", "__init__.pyi", "_version.py", "errors.py", *ROOMS):
        link = package / name
        if not link.exists():
            link.symlink_to(ROOT / name)


def on_page_markdown(markdown: str, *, page: Any, **_: Any) -> str:
    """Fill in what is taken from the code, and lead links to examples to their page."""
    if page.file.src_uri in SOUGHT_LESS:
        page.meta["search"] = {"boost": 0.3}
    markdown = re.sub(
        r"\]\(\.\./examples/plugin[^)]*\)", "](examples.md#plugin)", markdown
    )
    markdown = re.sub(r"\]\(\.\./examples/(\w+)\.py\)", r"](examples.md#\1)", markdown)
    markdown = re.sub(r"\[([^\]]+)\]\(\.\./([^)#]+)\)", _outside, markdown)
    if MESSAGES in markdown:
        before, _, after = markdown.partition(MESSAGES)
        markdown = before.partition(BY_HAND)[0] + "\n".join(_messages()) + after
    if OPTIONS in markdown:
        options = OPTION_TABLE.items()
        rows = [f"- `{name}`: {_safe(_described(option))}" for name, option in options]
        markdown = markdown.replace(OPTIONS, "\n".join(rows))
    if EXAMPLES in markdown:
        markdown = markdown.replace(EXAMPLES, "\n".join(_examples()))
    return markdown


def _described(option: Option) -> str:
    """Return the text of an option with its default, and before it the method that alone has it."""
    words = f"({option.method}) {option.text}" if option.method else option.text
    if option.default in (None, True, False):
        return words
    return f"{words} (default: {option.default})"


def on_page_content(html: str, **_: Any) -> str:
    """Write formulas as MathML, and take off the roles of docstrings, :func: and the like."""
    html = re.sub(
        r'<(div|span) class="arithmatex">(.*?)</\1>', _mathml, html, flags=re.S
    )
    return re.sub(r":(?:attr|class|func|meth|mod):(?=<code>)", "", html)


def _mathml(formula: re.Match[str]) -> str:
    """Convert LaTeX to MathML, which browsers draw by themselves: no script, no network."""
    display = "block" if formula[1] == "div" else "inline"
    latex = unescape(formula[2]).strip()[2:-2]  # between \\[ and \\], or \\( and \\)
    return f'<{formula[1]} class="formula">{latex_to_mathml(latex, display=display)}</{formula[1]}>'


def _outside(link: re.Match[str]) -> str:
    """Name a file of the project that is no page; one that is missing stays, and is reported."""
    text, path = link[1], link[2]
    if not (ROOT / path).exists():
        return link[0]
    return f"`{path}`" if text.strip("`") in path else f"{text} (`{path}`)"


def _messages() -> Iterator[str]:
    for room, title in ROOMS.items():
        yield f"\n### {title}\n"
        for file in sorted((ROOT / room).rglob("*.py")):
            if "emulators" in file.parts:
                continue
            texts = list(dict.fromkeys(_told(ast.parse(file.read_text()))))
            if texts:
                yield f"\n**{file.relative_to(ROOT)}**\n"
            for text in texts:
                yield f"- {_safe(text)}"


def _told(tree: ast.AST) -> Iterator[str]:
    """Yield what the code says to users: errors, warnings, and findings with their advice."""
    raised = {id(node.exc) for node in ast.walk(tree) if isinstance(node, ast.Raise)}
    nodes = [node for node in ast.walk(tree) if isinstance(node, CODE)]
    variables: dict[str, str] = {}
    for node in sorted(nodes, key=lambda node: (node.lineno, node.col_offset)):
        match node:
            case ast.FunctionDef():
                variables = {}
            case ast.Assign(targets=[ast.Name(id=variable)], value=value):
                variables[variable] = _text(value)
        if not isinstance(node, ast.Call):
            continue
        name = ast.unparse(node.func).rpartition(".")[2]
        said = id(node) in raised or name.endswith("Error") or name in SAID
        texts = (variables.get(ast.unparse(word), _text(word)) for word in node.args)
        words = [text for text in texts if text]
        if name not in BARE and said and words and len(words[-1]) > 12:
            yield "; ".join(words[-2:]) if name == "Diagnostic" else words[-1]


def _text(node: ast.expr) -> str:
    """Return a text as it is written, with an ellipsis for what is put in."""
    match node:
        case ast.Constant(value=str(value)):
            return value
        case ast.JoinedStr(values=values):
            return "".join(_text(value) for value in values)
        case ast.FormattedValue():
            return "\N{HORIZONTAL ELLIPSIS}"
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            return _text(left) + _text(right)
        case _:
            return ""


def _safe(text: str) -> str:
    return re.sub(r"([<>*_`\[\]|])", r"\\\1", " ".join(text.split()))


def _examples() -> Iterator[str]:
    for file in sorted((ROOT / "examples").glob("*.py")):
        yield f"\n## {file.stem} {{ #{file.stem} }}\n\n```python\n{file.read_text()}```"
    yield "\n## A plug-in for an arm of your own { #plugin }\n"
    for file in sorted((ROOT / "examples/plugin").rglob("*")):
        if file.suffix in {".py", ".toml"}:
            kind = "python" if file.suffix == ".py" else "toml"
            name = file.relative_to(ROOT)
            yield f"\n`{name}`\n\n```{kind}\n{file.read_text()}```"
