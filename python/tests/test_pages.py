"""Programs of the guide that import the package run as they stand there."""

import re
from pathlib import Path

import pytest

GUIDE = Path(__file__).parents[2] / "docs" / "guide"
pytestmark = [pytest.mark.compiled, pytest.mark.slow]


@pytest.mark.skipif(not GUIDE.is_dir(), reason="the guide is beside the package in a checkout alone")
@pytest.mark.parametrize("page", ["diffrax", "heyoka", "openmm", "python", "rebound", "sciml"])
def test_programs_of_the_guide(cache, page):
    text = (GUIDE / f"from-{page}.md").read_text(encoding="utf-8")
    programs = [each for each in re.findall(r"```python\n(.*?)```", text, re.S) if "wzvi" in each]
    assert programs
    scope: dict = {}
    for program in programs:
        exec(compile(program.replace("paths=10**6", "paths=10**4"), f"from-{page}.md", "exec"), scope)
