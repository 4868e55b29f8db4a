"""Plugins by name: lazy, isolated, deterministic.

Plugins are imported on demand; a broken plugin does not affect others; a name that two
distributions claim is an error only when it is requested.
"""

import inspect
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from threading import RLock
from typing import Any, Generic, TypeVar

from geodesic_toolkit.errors import (
    InvalidOptionError,
    PluginConflictError,
    PluginLoadError,
    UnknownPluginError,
)

__all__ = ["PluginStatus", "Registry"]

Plugin = TypeVar("Plugin")

LOCAL = "registered in this process"

CORE = "geodesic-toolkit"
"""The distribution whose readers come last."""


@dataclass(frozen=True)
class PluginStatus:
    """The status of one plugin, as listings show it.

    Attributes
    ----------
    name : str
        The name that finds it: its own, or ``"distribution:name"`` if several claim that name.
    distribution, version : str
        The distribution that provides it.
    target : str
        Its import path, ``"module:attribute"``.
    error : str or None
        The reason why it does not load; None if it does.
    references : tuple of str
        The DOIs that it declares.
    """

    name: str
    distribution: str
    version: str
    target: str
    error: str | None
    references: tuple[str, ...]

    @property
    def usable(self) -> bool:
        """True if the plugin loads."""
        return self.error is None


@dataclass
class _Entry:
    """A registration, and the outcome of loading it."""

    name: str
    distribution: str
    version: str
    target: str
    load: Callable[[], object]
    loaded: Any = None


class Registry(Mapping[str, Plugin], Generic[Plugin]):
    """A mapping from names to plugins, filled by the entry points of installed distributions.

    Iterating, ``len`` and ``in`` import nothing; ``registry[name]`` imports that one plugin.

    Parameters
    ----------
    group : str
        Entry-point group, such as ``"geodesic_toolkit.operators"``.
    kind : str
        Name of its members in messages: "operator".
    accepts : callable
        Returns why a loaded object is not a member, or None if it is one.
    install_hints : mapping, optional
        For names that are not installed: the distributions that provide them.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> gt.operators["cotan"]
    <class 'geodesic_toolkit.laplacians.cotan.CotanLaplacian'>
    >>> "geodesic-toolkit:cotan" in gt.operators
    True
    """

    def __init__(
        self,
        group: str,
        kind: str,
        accepts: Callable[[object], str | None],
        install_hints: Mapping[str, str] | None = None,
    ) -> None:
        self.group = group
        self.kind = kind
        self._accepts = accepts
        self.install_hints = dict(install_hints or {})
        self._local: list[_Entry] = []
        self._discovered: list[_Entry] | None = None
        self._lock = RLock()

    # -- the mapping ---------------------------------------------------------------------------

    def __getitem__(self, name: str) -> Plugin:
        """Return the plugin called `name`, or ``"distribution:name"``, importing it if necessary.

        Raises
        ------
        UnknownPluginError
            Nothing is registered under `name`.
        PluginConflictError
            Two distributions register it.
        PluginLoadError
            It does not import, or does not fit the group.
        """
        found = self._find(name)
        if not found:
            raise UnknownPluginError(self._unknown(name))
        if len(found) > 1:
            choices = " or ".join(f'"{entry.distribution}:{entry.name}"' for entry in found)
            raise PluginConflictError(
                f"{len(found)} distributions register the {self.kind} {name!r}; ask for {choices}"
            )
        return self._load(found[0])

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names, sorted; qualified ones if several distributions share one."""
        entries = self._entries()
        names = [entry.name for entry in entries]
        for entry in sorted(entries, key=lambda entry: (entry.name, entry.distribution)):
            shared = names.count(entry.name) > 1
            yield f"{entry.distribution}:{entry.name}" if shared else entry.name

    def __len__(self) -> int:
        return len(self._entries())

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and bool(self._find(name))

    def candidates(self, name: str) -> list[Plugin]:
        """Return the plugins called `name`, those of other distributions before the core's own.

        Parameters
        ----------
        name : str

        Returns
        -------
        list
            Not empty.

        Raises
        ------
        UnknownPluginError, PluginConflictError, PluginLoadError
            As for looking up one plugin; two distributions other than the core are in conflict.
        """
        found = self._find(name)
        others = [entry for entry in found if entry.distribution != CORE]
        if len(others) == len(found) or len(others) > 1:
            return [self[name]]
        return [self._load(entry) for entry in (*others, *(e for e in found if e not in others))]

    # -- other methods -------------------------------------------------------------------------

    def register(self, name: str, plugin: Plugin) -> None:
        """Register `plugin` under `name` for this process, before or instead of packaging it.

        Raises
        ------
        PluginLoadError
            It does not fit the group.
        PluginConflictError
            The name is registered in this process already.
        """
        reason = self._accepts(plugin)
        if reason is not None:
            raise PluginLoadError(f"{plugin!r} cannot be registered as {self.kind}: {reason}")
        with self._lock:
            if any(entry.name == name for entry in self._local):
                raise PluginConflictError(f"the {self.kind} {name!r} is registered already")
            target = f"{getattr(plugin, '__module__', '?')}:{getattr(plugin, '__qualname__', '?')}"
            self._local.append(_Entry(name, LOCAL, "", target, lambda: plugin, plugin))

    def unregister(self, name: str) -> None:
        """Undo a :meth:`register`.

        Parameters
        ----------
        name : str

        Raises
        ------
        UnknownPluginError
            Nothing was registered under `name` in this process.
        """
        with self._lock:
            kept = [entry for entry in self._local if entry.name != name]
            if len(kept) == len(self._local):
                raise UnknownPluginError(f"no {self.kind} {name!r} was registered in this process")
            self._local = kept

    def refresh(self) -> None:
        """Forget the discovered plugins, to find distributions installed since."""
        with self._lock:
            self._discovered = None

    def resolve(self, choice: object, **options: Any) -> Any:
        """Return an instance for a name, a class or an instance.

        Parameters
        ----------
        choice : str, class or instance
        **options
            Options of the constructor, for a name or class; an instance has its own.

        Returns
        -------
        object

        Raises
        ------
        InvalidOptionError
            The object is none of the three, options are given with an instance, or the constructor
            does not accept the options.
        """
        plugin = self[choice] if isinstance(choice, str) else choice
        if isinstance(plugin, type) and self._accepts(plugin) is None:
            try:
                inspect.signature(plugin).bind(**options)
            except TypeError as error:
                raise InvalidOptionError(f"{self.kind} {plugin.__name__}: {error}") from error
            return plugin(**options)
        if isinstance(plugin, type) or self._accepts(type(plugin)) is not None:
            raise InvalidOptionError(
                f"{choice!r} is not {_article(self.kind)} {self.kind}: give a name "
                f"({', '.join(self)}), "
                "a class or an instance"
            )
        if options:
            raise InvalidOptionError(
                f"{plugin!r} has its options already; give {', '.join(options)} when making it"
            )
        return plugin

    def status(self) -> list[PluginStatus]:
        """Return one row per registration, including broken and conflicting ones; imports all."""
        rows = []
        for entry, name in zip(
            sorted(self._entries(), key=lambda entry: (entry.name, entry.distribution)),
            self,
            strict=True,
        ):
            error, references = None, ()
            try:
                plugin = self._load(entry)
                references = tuple(getattr(plugin, "references", ()))
            except PluginLoadError as failure:
                error = str(failure)
            rows.append(
                PluginStatus(
                    name, entry.distribution, entry.version, entry.target, error, references
                )
            )
        return rows

    def __repr__(self) -> str:
        return f"<{self.kind} registry: {', '.join(self) or 'empty'}>"

    # -- implementation ------------------------------------------------------------------------

    def _entries(self) -> list[_Entry]:
        with self._lock:
            if self._discovered is None:
                self._discovered = _discover(self.group)
            return self._discovered + self._local

    def _find(self, name: str) -> list[_Entry]:
        distribution, colon, short = name.rpartition(":")
        return [
            entry
            for entry in self._entries()
            if (entry.name == short and entry.distribution == distribution)
            or (not colon and entry.name == name)
        ]

    def _load(self, entry: _Entry) -> Plugin:
        if entry.loaded is None:
            try:
                loaded = entry.load()
            except Exception as error:  # a third party's import may raise anything
                raise PluginLoadError(
                    f"the {self.kind} {entry.name!r} of {entry.distribution} does not load "
                    f"({entry.target}): {type(error).__name__}: {error}"
                ) from error
            reason = self._accepts(loaded)
            if reason is not None:
                raise PluginLoadError(
                    f"the {self.kind} {entry.name!r} of {entry.distribution} is not one: {reason}"
                )
            entry.loaded = loaded
        plugin: Plugin = entry.loaded  # checked by `accepts`
        return plugin

    def _unknown(self, name: str) -> str:
        names = list(self)
        message = f"no {self.kind} {name!r}"
        import difflib

        near = difflib.get_close_matches(name, names, n=3, cutoff=0.5)
        if near:
            message += f"; did you mean {' or '.join(repr(match) for match in near)}?"
        message += f" (installed: {', '.join(names) or 'none'})"
        if name in self.install_hints:
            message += f"; it comes with: pip install {self.install_hints[name]}"
        return message


def _article(noun: str) -> str:
    return "an" if noun[0] in "aeiou" else "a"


def _discover(group: str) -> list[_Entry]:
    """Return the entry points of a group, in an order that depends only on names.

    A distribution found twice on the path (an editable install beside its wheel) counts once.
    """
    from importlib import metadata  # scans all installed distributions: only on demand

    found: dict[tuple[str, str], _Entry] = {}
    for point in metadata.entry_points(group=group):
        distribution = point.dist.name if point.dist is not None else "unknown"
        version = point.dist.version if point.dist is not None else ""
        key = (distribution, point.name)
        found.setdefault(key, _Entry(point.name, distribution, version, point.value, point.load))
    return [found[key] for key in sorted(found)]
