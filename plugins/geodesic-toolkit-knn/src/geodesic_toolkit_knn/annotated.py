"""Neighbours from and to AnnData, known by its attributes: the package is not imported."""

from typing import Any, Literal

from geodesic_toolkit.errors import InvalidOptionError, UnsupportedDomainError
from geodesic_toolkit_knn.domain import KNNGraph

__all__ = ["from_anndata", "to_anndata"]


def from_anndata(
    data: Any,
    *,
    key: str = "distances",
    representation: str | None = None,
    dimension: int | Literal["auto"] = "auto",
    **options: Any,
) -> KNNGraph:
    """Return the observations of an AnnData as a domain.

    Parameters
    ----------
    data : AnnData
        Or what has `obsp` and `obsm` as it has.
    key : str
        The distances in `obsp`, as ``scanpy.pp.neighbors`` writes them.
    representation : str, optional
        A table in `obsm`, "X_pca" say: neighbours are found in it, and `key` is not used. Curves
        and surfaces are much more accurate with it.
    dimension, **options
        As for :class:`KNNGraph`.

    Returns
    -------
    KNNGraph

    Raises
    ------
    UnsupportedDomainError
        Something else than an AnnData.
    InvalidOptionError
        A key that is not there, the message has those that are; connectivities as `key`.
    """
    if not (hasattr(data, "obsp") and hasattr(data, "obsm")):
        raise UnsupportedDomainError(
            f"expected an AnnData, with obsp and obsm, not {type(data).__name__}"
        )
    table, name = (data.obsp, key) if representation is None else (data.obsm, representation)
    if name not in table:
        which = "obsp" if representation is None else "obsm"
        cure = "; run scanpy.pp.neighbors, or give representation=" if which == "obsp" else ""
        raise InvalidOptionError(
            f"{which} has no {name!r}; it has: {', '.join(map(str, table)) or 'nothing'}{cure}"
        )
    if representation is None:
        if name.endswith("connectivities"):
            raise InvalidOptionError(
                f"obsp[{name!r}] has affinities; give the key of the distances, as "
                f'"{name.removesuffix("connectivities")}distances"'
            )
        if options:
            raise InvalidOptionError(
                f"{', '.join(options)}: neighbours in obsp are taken as they are; give a "
                "representation to find others"
            )
        return KNNGraph.from_distances(data.obsp[key], dimension=dimension)
    return KNNGraph(data.obsm[representation], dimension=dimension, **options)


def to_anndata(data: Any, domain: KNNGraph, *, prefix: str = "") -> None:
    """Write distances and affinities into `obsp` of an AnnData, where scanpy looks for them.

    Parameters
    ----------
    data : AnnData
    domain : KNNGraph
        Of the same observations.
    prefix : str
        Before the keys ``distances`` and ``connectivities``.

    Raises
    ------
    InvalidOptionError
        Another number of observations.
    """
    if data.shape[0] != domain.n_vertices:
        raise InvalidOptionError(
            f"the AnnData has {data.shape[0]} observations, and the domain {domain.n_vertices}"
        )
    data.obsp[f"{prefix}distances"] = domain.distances.copy()
    data.obsp[f"{prefix}connectivities"] = domain.affinities().copy()
