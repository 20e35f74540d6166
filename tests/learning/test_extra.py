"""Without Gymnasium one line says what to install."""

from __future__ import annotations

import subprocess
import sys

import pytest

WITHOUT = """
import sys
sys.modules["gymnasium"] = None
import graphnav
try:
    {}
except graphnav.UserError as error:
    print(error)
"""


@pytest.mark.parametrize(
    ("line", "who"),
    [
        ('graphnav.make_env("corridor_ccw")', "graphnav.make_env"),
        ('graphnav.make_vec_env("corridor_ccw", 2)', "graphnav.make_vec_env"),
        ("import graphnav.gym", "graphnav.gym"),
    ],
)
def test_what_lacks_is_told(line: str, who: str) -> None:
    done = subprocess.run([sys.executable, "-c", WITHOUT.format(line)], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == [f"{who} needs gymnasium", "  pip install 'gymnasium>=1.1'"]


def test_graphnav_alone_loads_no_gymnasium() -> None:
    line = "import sys, graphnav; graphnav.load; graphnav.make_env; sys.exit('gymnasium' in sys.modules)"
    subprocess.run([sys.executable, "-c", line], check=True)
