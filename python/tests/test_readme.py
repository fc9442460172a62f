"""The README's examples, as they stand there."""

import re

from conftest import REPOSITORY


def test_the_first_examples_run_one_after_the_other(monkeypatch, capsys):
    monkeypatch.chdir(REPOSITORY)
    text = (REPOSITORY / "python" / "README.md").read_text()
    check, step, *_ = re.findall(r"```python\n(.*?)```", text, re.S)
    names: dict[str, object] = {}
    exec(check, names)
    assert "1 of 2 pairs overlap" in capsys.readouterr().out
    exec(step, names)
    assert names["report"].contacts > 0
