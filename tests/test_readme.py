"""The README tells the truth: its example runs, its tables are those of the registries, its links lead somewhere."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path

import matplotlib as mpl
import pytest

ROOT = Path(__file__).resolve().parents[1]
README = ROOT / "README.md"


def script(name):
    """A script of docs as a module."""
    spec = importlib.util.spec_from_file_location(name, ROOT / "docs" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def generate():
    return script("generate")


def test_the_first_screen_is_what_the_command_prints(shared_scenes):
    text = README.read_text(encoding="utf-8")
    city = shared_scenes / "kenney_city.glb"
    assert script("first_screen").written(text, city) == text, "run: python docs/first_screen.py kenney_city.glb"
    assert "$ shadowlab advise city.glb\n" in text[:2000]


def test_tables_are_up_to_date(generate):
    text = README.read_text(encoding="utf-8")
    assert generate.generated(text) == text, "run: make docs"


def test_a_stale_table_is_noticed(generate):
    text = README.read_text(encoding="utf-8")
    stale = text.replace("| `lispsm` |", "| `lispsn` |")
    assert stale != text
    assert generate.generated(stale) == text


def test_python_examples_run_as_written(tmp_path, monkeypatch):
    mpl.use("Agg")
    monkeypatch.chdir(tmp_path)
    examples = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    assert examples
    for example in examples:
        exec(compile(example, str(README), "exec"), {"__name__": "__main__"})
    assert (tmp_path / "report" / "report.html").is_file()


@pytest.mark.parametrize("page", ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs/ARCHITECTURE.md"])
def test_links_lead_somewhere(page):
    path = ROOT / page
    targets = re.findall(r"\]\((?!https?:|#)([^)#]+)", path.read_text(encoding="utf-8"))
    assert [target for target in targets if not (path.parent / target).exists()] == []
