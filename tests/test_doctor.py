"""The doctor: says what is here, offers a command for what is not, and notices a core that does not work."""

from __future__ import annotations

import numpy as np
import pytest

import shadowlab as sl
from shadowlab import doctor


def test_the_core_works_here():
    found = sl.report()
    assert found.works
    text = str(found)
    assert sl.__version__ in text
    assert "agrees with traced truth" in text
    assert "The core works." in text
    assert "<table>" in found._repr_html_()


def test_what_is_missing_comes_with_a_command(monkeypatch):
    monkeypatch.setattr(doctor, "version_of", lambda package: None if package in ("moderngl", "tqdm") else "1.0")
    found = sl.report()
    fixes = {finding.name: finding for finding in found.findings}
    assert fixes["moderngl"].state == "optional"
    assert fixes["moderngl"].fix == 'pip install "shadowlab[peers]"'
    assert fixes["tqdm"].state == "missing"
    assert fixes["tqdm"].fix == "pip install tqdm"
    assert not found.works
    assert "does not work" in str(found)


def test_no_adapter_is_no_failure(monkeypatch):
    def no_renderer(backend):
        error = sl.errors.DeviceError(f"no graphics adapter: found none; install a driver for {backend}")
        error.fix = f"install a driver for {backend}"
        raise error

    monkeypatch.setattr("shadowlab._core.adapters", list)
    monkeypatch.setattr("shadowlab._core.Renderer", no_renderer)
    finding = doctor.adapters()
    assert finding.state == "optional"
    assert finding.fix == "install a driver for gpu"


@pytest.mark.parametrize("wrong", ["all lit", "all dark", "inverted"])
def test_a_truth_that_disagrees_is_noticed(monkeypatch, wrong):
    real = sl.trace.shadow_mask

    def broken(*arguments, **keywords):
        truth = real(*arguments, **keywords)
        seen = truth >= 0
        if wrong == "inverted":
            return np.where(seen, 1 - truth, truth).astype(np.int8)
        return np.where(seen, 1 if wrong == "all lit" else 0, truth).astype(np.int8)

    monkeypatch.setattr(sl.trace, "shadow_mask", broken)
    finding = doctor.core()
    assert finding.state == "failed"
    assert finding.fix


def test_an_error_of_the_core_is_reported(monkeypatch):
    def broken(*_, **__):
        raise sl.errors.InternalError("out of order")

    monkeypatch.setattr(sl.trace, "shadow_mask", broken)
    assert doctor.core().text == "out of order"
