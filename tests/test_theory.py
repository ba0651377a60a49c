"""Every citation of the theory resolves: section numbers, equation numbers and the keys of sources."""

from __future__ import annotations

from pathlib import Path

import pytest
from theory_support import (
    citations,
    declared_equations,
    declared_keys,
    declared_sections,
    duplicates,
    files,
    theory_of,
    uncited,
    unresolved,
)

ROOT = Path(__file__).resolve().parents[1]
THEORY = (ROOT / "docs" / "theory.md").read_text("utf-8")
REFERENCES = (ROOT / "docs" / "references.md").read_text("utf-8")


@pytest.fixture(scope="module")
def cited():
    return [c for path in files(ROOT) for c in citations(path, path.relative_to(ROOT))]


def test_every_citation_resolves(cited):
    # Fewer than a hundred would mean that they are no longer found.
    assert len(cited) > 100
    wrong = unresolved(cited, theory_of(ROOT))
    assert not wrong, "\n".join(["docs/theory.md and docs/references.md do not have:", *wrong])


def test_every_source_is_cited(cited):
    assert not uncited(cited, theory_of(ROOT))


def test_every_equation_is_cited_by_code(cited):
    code = {c.value for c in cited if c.form == "equation" and c.path.parts[0] in ("src", "python")}
    assert not [number for number, _ in declared_equations(THEORY) if number not in code]


def test_numbers_and_keys_are_declared_once():
    assert not duplicates([number for number, _ in declared_equations(THEORY)])
    assert not duplicates(declared_sections(THEORY))
    assert not duplicates(declared_keys(REFERENCES))


def test_equations_stand_in_their_sections():
    for number, section in declared_equations(THEORY):
        assert number.strip("()").split(".")[0] == section.split(".")[0], f"{number} stands in section {section}"


def test_the_contents_name_every_chapter():
    contents = THEORY.split("**Contents.**")[1].split("**Notation.**")[0]
    for chapter in (s for s in declared_sections(THEORY) if "." not in s):
        assert f"[{chapter} " in contents, chapter


WRONG = {
    "a.rs": (
        '//! Source: theory.md 5.2, 5.9 and\n//! 77; `[nobody1999]`.\nlet u = "// (9.9)"; // (6.77)\n',
        (1, 2, 2, 3),
    ),
    "b.py": ('"""Of theory.md (6.2) and\n(6.78)."""\n\nx = "theory.md 88"  # E.5: a stale form\n', (2, 4)),
    "c.wgsl": ("// theory 5.2\nlet x = 1.0; // equation 9.1\n", (1, 2)),
    "d.md": ("See theory.md E.1 to E.8.\n\n[nobody1999] and [wimmer2004]\n", (1, 3)),
    "e.rs": ("/* theory.md\n 5.2, (0.1) and (0.9) */\n//! Source: Wimmer and others 2004; Reeves 1987.\n", (2, 3)),
    "f.py": ('"""Fine.\n\nSource: Wimmer 2004 [wimmer2004]; theory.md 5.1 to 5.4, (5.1) and E.2.\n"""\n', ()),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_citation_is_listed_with_file_and_line(name, tmp_path):
    text, lines = WRONG[name]
    path = tmp_path / name
    path.write_text(text, "utf-8")
    listed = unresolved(citations(path), theory_of(ROOT))
    assert [line.split(": ")[0] for line in listed] == [f"{path}:{line}" for line in sorted(lines)], listed


def test_one_changed_number_is_found(cited, tmp_path):
    """A real file, one digit of it changed."""
    of_warp = ROOT / "src" / "techniques" / "kit" / "warp_space.rs"
    assert not unresolved(citations(of_warp), theory_of(ROOT))
    changed = tmp_path / "warp_space.rs"
    changed.write_text(of_warp.read_text("utf-8").replace("theory.md 5.4", "theory.md 5.7", 1), "utf-8")
    (wrong,) = unresolved(citations(changed), theory_of(ROOT))
    assert wrong.endswith("section 5.7")


def test_a_source_that_nothing_cites_and_a_number_declared_twice_are_found(cited, tmp_path):
    docs = tmp_path / "docs"
    docs.mkdir()
    (docs / "references.md").write_text(f"{REFERENCES}\n- **nobody1999** Nobody 1999.\n", "utf-8")
    (docs / "theory.md").write_text(THEORY, "utf-8")
    assert uncited(cited, theory_of(tmp_path)) == ["nobody1999"]
    twice = THEORY.replace("## 2. Uniform\n", "## 2. Uniform\n```\nx = 1     (0.1)\n```\n", 1)
    assert duplicates([number for number, _ in declared_equations(twice)]) == ["(0.1)"]
    assert ("(0.1)", "2") in declared_equations(twice)


def test_strings_and_arguments_are_no_citations(tmp_path):
    path = tmp_path / "a.rs"
    path.write_text("let (a, b): (&'static str, char) = (r#\"// (9.9)\"#, '\"');\n// sin(9.8), x(9.7)\n", "utf-8")
    assert citations(path) == []
