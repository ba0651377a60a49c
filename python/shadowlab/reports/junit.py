"""Results as JUnit's XML, which services for continuous integration show: suites of cases that passed or failed.

The form is the one that Jenkins, GitLab and GitHub's report actions read: `testsuites`, in it `testsuite` with counts,
in it `testcase` with `failure` (what was expected did not hold) or `error` (there was nothing to hold it against).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from xml.etree import ElementTree


@dataclass(frozen=True)
class Case:
    """One thing that was checked.

    Attributes
    ----------
    name : str
    group : str
        What it belongs to, shown before its name.
    seconds : float
    failure, error : str
        Why it did not hold, or why it could not be held against anything; empty where it did.
    """

    name: str
    group: str
    seconds: float
    failure: str = ""
    error: str = ""


def junit_xml(name: str, suites: Mapping[str, Sequence[Case]]) -> bytes:
    """The document of suites by their names, in UTF-8."""
    cases = [case for suite in suites.values() for case in suite]
    top = ElementTree.Element("testsuites", {"name": clean(name), **counts_of(cases)})
    for title, suite in suites.items():
        counts = {"skipped": "0", **counts_of(suite)}
        part = ElementTree.SubElement(top, "testsuite", {"name": clean(title), **counts})
        for case in suite:
            named = {"classname": clean(case.group), "name": clean(case.name), "time": f"{case.seconds:.3f}"}
            one = ElementTree.SubElement(part, "testcase", named)
            for kind, said in (("failure", case.failure), ("error", case.error)):
                if said:
                    ElementTree.SubElement(one, kind, {"message": clean(said), "type": kind}).text = clean(said)
    ElementTree.indent(top)
    document: bytes = ElementTree.tostring(top, encoding="utf-8", xml_declaration=True)
    return document + b"\n"


def counts_of(cases: Sequence[Case]) -> dict[str, str]:
    """How many cases there are, how many did not hold, and their time."""
    return {
        "tests": str(len(cases)),
        "failures": str(sum(bool(case.failure) for case in cases)),
        "errors": str(sum(bool(case.error) for case in cases)),
        "time": f"{sum(case.seconds for case in cases):.3f}",
    }


def clean(text: str) -> str:
    """The text without the characters that XML 1.0 has no way to write."""
    return "".join(letter if letter >= " " or letter in "\t\n\r" else "\N{REPLACEMENT CHARACTER}" for letter in text)
