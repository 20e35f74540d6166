"""Results of other code do not compare: what is hashed, and what counts as a difference."""

from __future__ import annotations

from pathlib import Path

from graphnav.core.runner import difference, difference_here, provenance


def test_packages_and_files_are_known_by_what_they_hold(tmp_path: Path) -> None:
    plugin = tmp_path / "mine.py"
    plugin.write_text("one = 1\n")
    first = provenance(["plane", "world", "foreign"], [str(plugin)])
    assert {"python", "numpy", "graphnav", "code of plane", "code of world", str(plugin)} <= first.keys()
    assert "code of foreign" not in first
    plugin.write_text("one = 2\n")
    second = provenance(["plane", "world"], [str(plugin)])
    assert {name for name in second if second[name] != first[name]} == {str(plugin)}
    assert str(difference(first, second)) == f"another {plugin}: {first[str(plugin)]}, now {second[str(plugin)]}"


def test_what_only_one_of_them_has_is_no_difference() -> None:
    assert difference({"numpy": "2", "code of plane": "a"}, {"numpy": "2", "code of flow": "b"}) is None


def test_this_process_is_compared_by_all_that_it_is_asked_for() -> None:
    wanted = provenance(["plane"], [])
    assert difference_here(wanted, ()) is None
    old = {**wanted, "code of plane": "0123456789ab"}
    assert str(difference_here(old, ())).startswith("another code of plane: 0123456789ab, now ")
