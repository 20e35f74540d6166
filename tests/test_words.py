"""Words that were replaced stay replaced: in names, docstrings, comments, messages, documentation and graphs."""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from fnmatch import fnmatch
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).resolve().parent.parent

FOLDERS = ("graphnav", "plugins", "graphs", "lcmtypes", "tools", "tests", "docs")
FILES = ("README.md", "CHANGELOG.md", "ARCHITECTURE.md", "CONTRIBUTING.md")
SKIPPED = (
    "tests/test_words.py",
    "tests/errors/*",
    "tests/fixtures/v0_1_0/*",
    "lcmtypes/graphnav_lcm/*",
    "plugins/graphnav_adapters/lcmtypes/*",
    "docs/_*",
)
"""This list itself, files that are wrong on purpose, records of an old version, and generated files."""
NAME, TEXT, DOC = "name", "text", "doc"
"""Identifiers and names of modules, as words with spaces between; sentences; the beginnings of docstrings."""


class Rule(NamedTuple):
    """A pattern of entire words, what to write, where it counts, a bad example and good ones, files that may use it."""

    pattern: str
    instead: str
    kinds: tuple[str, ...]
    bad: str
    good: tuple[str, ...] = ()
    allowed_in: tuple[str, ...] = ()


# A word is listed only if every use of it is wrong: the control force and `control.*` are not here.
RULES = (
    Rule("mend(s|ed|ing)?", "fix", (NAME, TEXT), "the command that mends it", ("recommended", "amended")),
    Rule("torn|unwhole", "truncated, incomplete", (NAME, TEXT), "the log is torn"),
    Rule("whole numbers?", "integer", (TEXT,), "a whole number"),
    Rule("whole(?! number)", "complete, entire", (NAME, TEXT), "the log is whole"),
    Rule(
        "(?<!at )(least|most) (?!squares|common)[a-z0-9]+|^(least|most)$",
        "min, max",
        (NAME,),
        "least_clearance_m",
        ("least_squares", "most_common", "at_least", "at_most_two", "almost", "what_matters_most"),
    ),
    Rule(
        "the least(?! squares)|greatest",
        "minimum, maximum",
        (TEXT,),
        "the greatest",
        ("at least 2", "the least squares fit"),
    ),
    Rule(
        "(?<!there )is no (?!longer|more|less|better)[a-z]+",
        "is not a ...",
        (TEXT,),
        "it is no number",
        ("there is no log", "it is no longer", "it is no better than chance"),
    ),
    Rule("nobody|somebody|anybody|whoever", "no stage, another program, the caller", (TEXT, NAME), "nobody reads it"),
    Rule("strangers?", "third-party", (NAME, TEXT), "a stranger's plugin", ("strange",)),
    Rule("(for|by|that|to|as) (people|persons?|a person)", "user, readable", (TEXT,), "JSON for people"),
    Rule("a text(?! file)|texts", "string", (TEXT,), "not a text", ("a text file",)),
    Rule(
        "figures",
        "metrics",
        (NAME,),
        "figures",
        ("figure", "FigureCanvas"),
        allowed_in=("plugins/graphnav_view/*", "tests/plugins/view/*", "graphnav/watch/commands/figure.py"),
    ),
    Rule(
        "(whose|its|their|which|that) figures",
        "metrics",
        (TEXT,),
        "a stage and its figures",
        ("graphnav figure", "a figure of Matplotlib"),
    ),
    Rule(
        "(a|negative) controls? that",
        "baseline",
        (TEXT,),
        "a control that a method has to beat",
        ("control.guard", "the control force"),
    ),
    Rule("What|Who", "a verb or a noun as the first word", (DOC,), "What a run holds.", ("Whether it is new.",)),
    Rule("stands? here", "duplicate entry, is not allowed here", (TEXT,), "'x' stands here twice"),
    Rule(
        "(is|are|was) over(?=[,.;:)]| before| and|$)",
        "finished",
        (TEXT,),
        "the run is over.",
        ("the mean is over 8 seeds",),
    ),
    Rule("what (is|was) (there|over|to be)", "existing, finished, pending", (TEXT,), "what is to be made"),
    Rule("(is|are|was|were) said", "specified, reported", (TEXT,), "where it is said"),
    Rule("stands inside what it stands for", "recursive alias", (TEXT,), "an alias stands inside what it stands for"),
    Rule("anew", "again, restart", (NAME, TEXT), "it begins anew"),
    Rule("(let|lets|letting) go of", "close, release", (TEXT,), "let go of the file"),
    Rule("seldom", "rarely", (NAME, TEXT), "it seldom arrives"),
    Rule("nothing but", "only", (TEXT,), "nothing but scalars"),
    Rule("but for", "except", (TEXT,), "all but for the stamp"),
    Rule("says? no [a-z]+", "declares no ..., names no ...", (TEXT,), "the stage says no metrics"),
    Rule("beside|dead|crew|telling|ink", "a name that says what is in the module", ("module",), "crew", ("inked",)),
)


class Found(NamedTuple):
    """A piece of a file: its line, kind and words."""

    line: int
    kind: str
    words: str


def _compiled(rule: Rule) -> re.Pattern[str]:
    spaced = rule.pattern.replace(" ", r"\s+")
    pattern = re.sub(r"\(\?<![^)]*\)", lambda behind: behind[0].replace(r"\s+", " "), spaced)
    return re.compile(rf"^(?:{pattern})\b" if DOC in rule.kinds else rf"(?<!\w)(?:{pattern})(?!\w)", re.IGNORECASE)


COMPILED = {rule: _compiled(rule) for rule in RULES}


def words_of(name: str) -> str:
    """Return the words of an identifier: ``least_px`` and ``leastPx`` are ``least px``."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|_+", " ", name).strip().lower()


def in_python(source: str, names_of_fields: frozenset[str]) -> Iterator[Found]:
    """Yield every identifier once, comments, docstrings, and strings with a space in them, which users may see."""
    known = set(names_of_fields)
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.NAME and token.string not in known:
            known.add(token.string)
            yield Found(token.start[0], NAME, words_of(token.string))
        elif token.type == tokenize.COMMENT:
            yield Found(token.start[0], TEXT, token.string)
    docstrings = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            docstrings.add(node.value)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value.strip():
            yield Found(node.lineno, TEXT, node.value)
            if node in docstrings:
                yield Found(node.lineno, DOC, node.value)


def pieces_of(path: Path, names_of_fields: frozenset[str]) -> Iterator[Found]:
    """Yield what a file says, by its suffix."""
    text = path.read_text(encoding="utf-8", errors="replace")
    if path.suffix == ".py":
        yield Found(1, "module", path.stem)
        yield from in_python(text, names_of_fields)
    elif path.name == "CHANGELOG.md":
        yield Found(1, TEXT, "\n## ".join(re.split(r"^## ", text, flags=re.MULTILINE)[:2]))
    elif path.suffix == ".lcm":
        for number, line in enumerate(text.splitlines(), 1):
            yield Found(number, TEXT, line.partition("//")[2])
    else:
        yield Found(1, TEXT, text)
        if path.suffix == ".yaml":
            for match in re.finditer(r"^[ -]*(\w+):", text, re.MULTILINE):
                yield Found(1 + text.count("\n", 0, match.start(1)), NAME, words_of(match[1]))


def faults_in(pieces: Iterator[Found], file: str) -> Iterator[str]:
    """Yield a line for each replaced word: file, line, the word, and what to use."""
    for piece in pieces:
        for rule, pattern in COMPILED.items():
            if piece.kind in rule.kinds and not any(fnmatch(file, allowed) for allowed in rule.allowed_in):
                for match in pattern.finditer(piece.words):
                    line = piece.line + piece.words.count("\n", 0, match.start())
                    yield f"{file}:{line}: '{' '.join(match[0].split())}' in a {piece.kind}: use {rule.instead}"


def names_of_lcm_fields() -> frozenset[str]:
    """Return the names of fields and types of LCM, which keep theirs."""
    texts = (path.read_text() for path in sorted((ROOT / "lcmtypes").glob("*.lcm")))
    return frozenset(name for text in texts for name in re.findall(r"^\s*\w+\s+(\w+)[\[\];\w]*;", text, re.MULTILINE))


def scanned_files() -> Iterator[Path]:
    """Yield every file that people read."""
    yield from (ROOT / name for name in FILES)
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in {".py", ".md", ".yaml", ".lcm", ".js"} and path.is_file():
                yield path


def test_replaced_words_stay_replaced() -> None:
    fields = names_of_lcm_fields()
    faults: list[str] = []
    for path in scanned_files():
        file = path.relative_to(ROOT).as_posix()
        if not any(fnmatch(file, pattern) for pattern in SKIPPED):
            faults += faults_in(pieces_of(path, fields), file)
    assert not faults, "\n" + "\n".join(faults)


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.pattern)
def test_a_rule_finds_its_bad_example_and_leaves_the_good_ones(rule: Rule) -> None:
    def found(words: str) -> list[str]:
        pieces = (Found(1, kind, words_of(words) if kind == NAME else words) for kind in rule.kinds)
        return list(faults_in(pieces, "graphnav/core/bus.py"))

    assert len(found(rule.bad)) == len(rule.kinds)
    assert not [text for good in rule.good for text in found(good)]


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("least_px = 1", "m.py:1: 'least px' in a name: use min, max"),
        ("class LeastPx: ...", "m.py:1: 'least px' in a name: use min, max"),
        ('"""Reads.\n\nThe log is\nwhole."""', "m.py:4: 'whole' in a text: use complete, entire"),
        ('"""What it reads."""', "m.py:1: 'What' in a doc: use a verb or a noun as the first word"),
        ("x = 1  # nobody reads it", "m.py:1: 'nobody' in a text: use no stage, another program, the caller"),
        ('error = f"{1} is no number"', "m.py:1: 'is no number' in a text: use is not a ..."),
        ('word = "torn"', None),
        ("message.least_m", None),
    ],
)
def test_python_is_read_by_token_and_syntax_tree(source: str, expected: str | None) -> None:
    assert list(faults_in(in_python(source, frozenset({"least_m"})), "m.py")) == ([expected] if expected else [])


def test_fields_of_lcm_types_keep_their_names() -> None:
    assert {"control", "utime", "repulsive"} <= names_of_lcm_fields()
