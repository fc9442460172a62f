"""The examples of the README and of the docstrings, as they stand there."""

import doctest
import importlib
import pkgutil
import re

import pytest
from conftest import REPOSITORY

import musculo_collide

MODULES = [module.name for module in pkgutil.iter_modules(musculo_collide.__path__) if module.name != "pyvista"]


@pytest.mark.parametrize("name", MODULES)
def test_examples_of_docstrings_run(name):
    found = doctest.testmod(importlib.import_module(f"musculo_collide.{name}"))
    assert found.failed == 0


def test_the_first_examples_run_one_after_the_other(monkeypatch, capsys):
    monkeypatch.chdir(REPOSITORY)
    text = (REPOSITORY / "python" / "README.md").read_text()
    check, step, *_ = re.findall(r"```python\n(.*?)```", text, re.S)
    names: dict[str, object] = {}
    exec(check, names)
    assert "1 of 2 pairs overlap" in capsys.readouterr().out
    exec(step, names)
    assert names["report"].contacts > 0
