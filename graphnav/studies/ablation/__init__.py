"""Ablations: swap, repeat over seeds, compare with statistics.

``study`` is what is asked, ``plan`` what is checked before anything runs, ``worker`` makes one run, ``execution`` makes
all of them, ``results`` compares them, ``report`` shows that. Imports point from the later to the earlier of these;
``execution`` and ``report`` do not know each other.
"""
