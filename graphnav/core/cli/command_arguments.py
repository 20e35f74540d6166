"""The arguments of a command, and what is made of those that several commands share."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from graphnav.core.catalog import Catalog
    from graphnav.core.cli.type_names import KnownTypes
    from graphnav.core.graph import Graph, Override
    from graphnav.core.trust import Trust


class CommandArguments(argparse.Namespace):
    """The parsed arguments of a command, by the names of its parameters.

    A method is for commands that declare what it reads: see `Options`.
    """

    def trusted(self, *, runs_all: bool = False) -> Trust:
        """Return which plugin files may run: those of ``--trust``, else of the user's answers, or with ``runs_all``."""
        from graphnav.core.cli.trust import trust_of

        return trust_of(self, runs_all=runs_all)

    def catalog(self, *, runs_all: bool = False) -> Catalog:
        """Return the catalog with the ``--plugin`` files, and the trust in others: of ``--trust``, or ``runs_all``."""
        from graphnav.core.catalog import Catalog

        return Catalog(self.trusted(runs_all=runs_all)).add_files(self.plugins)

    def load_types(self, catalog: Catalog | None = None) -> dict[str, type]:
        """Register the types of ``--types``, of ``--plugin`` and of installed packages for decoding; return the first.

        ``catalog``: the command's own, with the ``--plugin`` files. The types are returned by LCM name.

        Raises
        ------
        UserError
            They do not exist, or cannot be used.
        """
        (self.catalog() if catalog is None else catalog).load_types()
        if not self.types:
            return {}
        from graphnav.core.typeinfo import load_types

        return load_types(self.types)

    def known_types(self) -> KnownTypes:
        """Return the types of ``--plugin``, of ``--types`` and of installed packages, which are decoded from now on.

        Raises
        ------
        UserError
            They do not exist, or cannot be used.
        """
        from graphnav.core.cli.type_names import KnownTypes

        catalog = self.catalog()
        return KnownTypes(catalog, self.load_types(catalog))

    def lcm_url(self) -> str:
        """Return the LCM URL to publish on: ``--url``, ``LCM_DEFAULT_URL``, or this machine's group.

        Raises
        ------
        UserError
            The URL does not reach other programs.
        """
        from graphnav.core.lcm_url import lcm_url

        return lcm_url(("--url", self.url))

    def overrides(self) -> tuple[Override, ...]:
        """Return the overrides of ``--set``.

        Raises
        ------
        UserError
            Every option that is not an override.
        """
        from graphnav.core.errors import Problem, UserError
        from graphnav.core.graph import Override

        problems: list[Problem] = []
        overrides = Override.parse_all(self.set, problems)
        if problems:
            raise UserError(problems)
        return overrides

    def load_graph(
        self, name: str | None = None, *, runs: bool = False, partial: bool = False, makes_stages: bool = True
    ) -> tuple[Catalog, Graph]:
        """Return the catalog with the ``--plugin`` files and the checked graph with its swaps, seed and end.

        ``name``: the graph, by default GRAPH. ``runs``: whether the command runs the graph because the user says so,
        and with it the plugins that the graph names. ``partial``: the graph may lack plugins that are not trusted
        (`Graph.left_out`), which are told. ``makes_stages``: whether the stages will be made, so that what they miss is
        reported with the other errors.

        Raises
        ------
        UserError
            Everything that is wrong with the graph or the options.
        """
        from graphnav.core.interrupts import ended_by_interrupt

        with ended_by_interrupt(owns_process=self.owns_process):
            from graphnav.core.api.load import load_with, with_run_options
            from graphnav.core.api.parameters import Shared
            from graphnav.core.errors import Problem
            from graphnav.core.graph import Override
            from graphnav.core.notices import print_notice

            catalog = self.catalog(runs_all=runs)
            problems: list[Problem] = []
            overrides = Override.parse_all(self.set, problems)
            options = {"partial": partial, "makes_stages": makes_stages}
            graph = load_with(catalog, name or self.graph, overrides, self.plugins, problems, **options)
            for problem in graph.left_out:
                print_notice(str(problem))
            given = {option.name: getattr(self, option.name, None) for option in Shared.RUN_OPTIONS}
            return catalog, with_run_options(graph, given, {option.name: option.flag for option in Shared.RUN_OPTIONS})

    def notices_of(self, graph: Graph) -> tuple[str, ...]:
        """Return the notices of a graph: with ``-v`` also the swaps that its own files make."""
        return (*graph.file_notices, *graph.notices) if self.verbose else graph.notices
