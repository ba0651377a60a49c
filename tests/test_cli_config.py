"""Configurations in TOML: each key has its line, and each mistake one line with file, line, key and what to write."""

from __future__ import annotations

import sys

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shadowlab.cli.config import LARGEST_CONFIG, read_config
from shadowlab.cli.config_lines import key_lines

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

DOCUMENT = '''# a = "[
a = 1
b.c = [1, # ] "
  2]
s = """x
[no] = 1
y"""""
[t]
"k y" = 'q"#'
[[check]]
scene = "@r"   # [
bounds.x = {max = 1, min = 2}
[check.path]
frames = 2
[[check]]
scene = "\\"["
[check.bounds]
share = { max = 1 }
l = \'\'\'
\\\'\'\'
z = 1'''


def test_each_key_has_its_line():
    assert tomllib.loads(DOCUMENT)
    lines = key_lines(DOCUMENT)
    of = {key: number for number, key in enumerate(DOCUMENT.splitlines(), 1)}
    assert lines["a",] == 2
    assert lines["b", "c"] == 3
    assert lines["s",] == 5
    assert lines["t", "k y"] == 9
    assert lines["check", 0, "scene"] == 11
    assert lines["check", 0, "bounds", "x"] == 12
    assert lines["check", 0, "path", "frames"] == of["frames = 2"] == 14
    assert lines["check", 1] == 15
    assert lines["check", 1, "bounds", "share"] == 18
    assert lines["check", 1, "bounds", "z"] == len(of) + 1
    assert ("no",) not in lines


KEYS = st.sampled_from(["a", "b", '"c d"', "'e#'"])
LEAVES = st.sampled_from(
    ['"x"', "'[y'", '"""m\n]"""', "'''\n#'''", "3", "[1, 2]", "[\n 1, # '\n]", "{ q = 1 }", '"\\""']
)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(KEYS, LEAVES), unique_by=lambda pair: pair[0]), st.sampled_from(["", "\n", "# '''\n"]))
def test_lines_are_those_where_the_keys_were_written(pairs, between):
    text, wanted = "[[t]]\n", {}
    for key, leaf in pairs:
        text += between
        wanted[key.strip("\"'")] = text.count("\n") + 1
        text += f"{key} = {leaf} # ]\n"
    assert set(tomllib.loads(text)["t"][0]) == set(wanted)
    lines = key_lines(text)
    assert {key: lines["t", 0, key] for key in wanted} == wanted


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"a = \n", "a.toml: no valid TOML: "),
        (b"a = 1\na = 2\n", "a.toml: no valid TOML: "),
        (b"\xff", "a.toml: expected text in UTF-8, got other bytes at 0"),
        (b"a = 0\n" + b"#" * LARGEST_CONFIG, "a.toml: expected at most 4,194,304 bytes"),
        (b"a = " + b"[" * 20_000, "a.toml: no valid TOML: "),
    ],
)
def test_what_is_no_configuration_is_an_error(tmp_path, monkeypatch, content, says):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.toml").write_bytes(content)
    with pytest.raises((ValueError, OSError), match=says):
        read_config("a.toml")


def test_a_file_that_is_missing_or_a_folder_is_an_error(tmp_path):
    for path in (tmp_path / "none.toml", tmp_path, "nul\0l.toml"):
        with pytest.raises(OSError, match=r"cannot read it \(.*check the path"):
            read_config(str(path))


def test_lines_of_windows_count_alike(tmp_path):
    path = tmp_path / "a.toml"
    path.write_bytes(b"\xef\xbb\xbfa = 1\r\nb = 2\r\n")
    assert read_config(str(path)).lines == {("a",): 1, ("b",): 2}


def test_a_table_answers_with_line_and_nearest_key(tmp_path):
    path = tmp_path / "a.toml"
    path.write_text("[t]\nfov-deg = 3\nsise = 1\n[[c]]\nx = 1\n[[c]]\nx = 1\nx_y = 1\nx-y = 2\n")
    top = read_config(str(path))
    table = top.table("t", "{}")
    assert (table.get("fov_deg"), table.number("fov-deg", "a number"), "fov_deg" in table) == (3, 3, True)
    with pytest.raises(ValueError, match=r"a\.toml:3: t\.sise: unknown key; did you mean 'size'\? expected one of fov"):
        table.only(("fov_deg", "size"))
    second = top.tables("c")[1]
    with pytest.raises(ValueError, match=r"a\.toml:7: c\.x: expected a text, got 1"):
        second.text("x", "a text")
    with pytest.raises(ValueError, match=r"a\.toml:9: c\.x-y: given twice, with - and with _"):
        second.only(("x", "x_y"))
    with pytest.raises(ValueError, match=r"a\.toml:6: c\.z: gone"):
        raise second.wrong("z", "gone")
