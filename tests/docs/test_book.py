"""The book: commands run and print what the pages show, drives end as they say, generated pages are fresh."""

from __future__ import annotations

import json
import re
import shutil
import socket
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from .conftest import DOCS, blocks, page_script, shell, write_files

ELSEWHERE = {"howto/robot.md", "howto/adapters.md", "howto/teach.md", "reference/maps.md"}
"""Pages whose commands run in tests of their own."""
RUN = [
    page
    for page in sorted(str(path.relative_to(DOCS)) for path in DOCS.glob("*/*.md"))
    if page not in ELSEWHERE and blocks(DOCS / page, "sh")
]
NEEDS_FILES_OF = {"tutorial/own-study.md": ("tutorial/own-stage.md", "tutorial/own-map.md")}
NEEDS_PROGRAMS = {"howto/other-languages.md": ("cc", "javac", "java")}
ENDS = {
    "tutorial/first-drive.md": {"first": "goal", "swapped": "timeout"},
    "tutorial/own-stage.md": {"blind": "contact", "mine": "goal"},
    "tutorial/own-map.md": {"room": "goal", "oracle": "goal"},
}
"""How the tutorial says that its drives end, by run folder."""


@pytest.mark.long
@pytest.mark.parametrize("page", RUN)
def test_the_commands_of_the_page_run(page: str, tmp_path: Path, group: str) -> None:
    for program in NEEDS_PROGRAMS.get(page, ()):
        if shutil.which(program) is None:
            pytest.skip(f"there is no {program}")
    for other in NEEDS_FILES_OF.get(page, ()):
        write_files(DOCS / other, tmp_path)
    printed = shell(_shorter(page_script(DOCS / page)), tmp_path, group, timeout_s=600)
    assert [line for line in _shown(page) if not _is_printed(line, printed)] == []
    ends = {name: json.loads((tmp_path / name / "summary.json").read_text())["outcome"] for name in ENDS.get(page, {})}
    assert ends == ENDS.get(page, {})
    shutil.rmtree(tmp_path)  # logs of complete drives


def _shown(page: str) -> list[str]:
    """Return the lines of output that a page shows, in its ``text`` blocks."""
    return [line for block in blocks(DOCS / page, "text") for line in block.splitlines() if line.strip()]


def _is_printed(line: str, printed: str) -> bool:
    """Whether a line was printed, numbers and spaces apart; of a line with "..." what stands before."""
    wanted, dots, _ = _without_numbers(line).partition("...")
    lines = map(_without_numbers, printed.splitlines())
    return any(found.startswith(wanted) if dots else found == wanted for found in lines)


def _without_numbers(line: str) -> str:
    return re.sub(r"[-+]?\d[\d.]*", "0", " ".join(line.split()))


def _shorter(script: str) -> str:
    """Return a script that shows the same in less time, with a port of this machine that is free.

    Studies have fewer worlds and drives of a second, one process, and draw no failures; drives that a page cuts short
    end after two seconds, where it looks at none of their later times; recordings are half as long.
    """
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        port = listener.getsockname()[1]
    script = re.sub(r"--seeds 0:(10|12)\b", lambda seeds: f"--seeds 0:{1 if seeds[1] == '10' else 2}", script)
    script = re.sub(r"(graphnav ablate [\w/]+(?:\.yaml)?)(?!.*until_s)", r"\1 --set run.until_s=1", script)
    script = re.sub(r"(run\.until_s=)4\b", r"\g<1>1", script)
    script = re.sub(r"^graphnav ablate (?!--)", "graphnav ablate --gallery 0 ", script, flags=re.MULTILINE)
    if "--cluster" not in script:
        script = re.sub(r"^graphnav (ablate|tune) (?!--(?!gallery))", r"graphnav \1 -j 1 ", script, flags=re.MULTILINE)
    if not re.search(r"--(at|from|pace) ", script):
        script = re.sub(r"--until \d+\b", "--until 2", script)
    script = re.sub(r"(until_s: )(60|30)\b", lambda until: f"{until[1]}{int(until[2]) // 2}", script)
    return script.replace(":8786", f":{port}").replace("--port 8786", f"--port {port}")


def test_the_pages_that_run_elsewhere_exist() -> None:
    assert all((DOCS / page).is_file() for page in ELSEWHERE | NEEDS_FILES_OF.keys() | NEEDS_PROGRAMS.keys())


def test_the_generated_pages_are_fresh() -> None:
    """In a process of its own: message classes that other tests declare would be in the list."""
    generator = Path(__file__).parents[2] / "tools" / "gen_docs.py"
    done = subprocess.run([sys.executable, generator, "--check"], capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("fresh\n", "")


def test_every_page_is_in_the_contents() -> None:
    contents = yaml.safe_load((DOCS / "_toc.yml").read_text())
    entries = [entry for part in contents["subtrees"] for entry in part["entries"]]
    entries += [inner for entry in entries for inner in entry.get("entries", ())]
    listed = {entry["file"] for entry in entries if "file" in entry} | {contents["root"]}
    listed |= {
        str(path.relative_to(DOCS).with_suffix(""))
        for e in entries
        if "glob" in e
        for path in DOCS.glob(f"{e['glob']}.md")
    }
    assert listed == {str(path.relative_to(DOCS).with_suffix("")) for path in DOCS.rglob("*.md")}
