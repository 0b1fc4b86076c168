"""Compiled templates are kept, and only as long as they are right."""

import sys

import pytest
from jinja2 import Environment, FileSystemLoader

from mukca.tools.report.figures.template_cache import TemplateCache


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    monkeypatch.setattr(sys, "pycache_prefix", None)
    (tmp_path / "page.j2").write_text("{{ 6 }} x {{ number }}")
    return tmp_path


def rendered(folder, compiled):
    """The page by a new environment, which puts the names of what it compiles into a list."""
    templates = Environment(loader=FileSystemLoader(folder), bytecode_cache=TemplateCache(folder))
    compile_template = templates.compile

    def compile_and_note(source, name, filename):
        compiled.append(name)
        return compile_template(source, name, filename)

    templates.compile = compile_and_note
    return templates.get_template("page.j2").render(number=7)


def test_a_template_is_compiled_once_and_anew_where_it_changed(folder):
    compiled = []
    assert rendered(folder, compiled) == rendered(folder, compiled) == "6 x 7"
    assert compiled == ["page.j2"]
    (folder / "page.j2").write_text("{{ number }} times")
    assert rendered(folder, compiled) == "7 times"
    (file,) = (folder / "__pycache__").iterdir()
    file.write_bytes(file.read_bytes()[:50])
    assert rendered(folder, compiled) == "7 times"
    assert len(compiled) == 3


def test_a_page_needs_no_place_to_keep_templates(folder):
    compiled = []
    (folder / "__pycache__").write_text("a file in its place")
    assert rendered(folder, compiled) == rendered(folder, compiled) == "6 x 7"
    assert len(compiled) == 2


def test_nothing_is_written_where_python_is_told_so(folder, monkeypatch):
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    assert rendered(folder, []) == "6 x 7"
    assert [file.name for file in folder.iterdir()] == ["page.j2"]
