"""The contract of a Laplace operator: one method."""

import abc
from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar

from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.domains import Domain
from geodesic_toolkit.errors import UnsupportedDomainError
from geodesic_toolkit.geometry.frames import Frames

__all__ = ["LaplaceOperator"]


class LaplaceOperator(abc.ABC):
    """Recipe for discretizing -Δ on a domain; the base class of back ends and plugins.

    Subclasses are final frozen dataclasses of keyword-only options, each with a default, so that
    ``Operator()`` works and two equal recipes are equal objects. `assemble` turns a domain into
    data; everything after it is shared.

    Attributes
    ----------
    domains : tuple of types
        The kinds of domain that `assemble` takes.
    references : tuple of str
        DOIs of the implemented methods, shown by listings and documentation.
    known_failures : mapping of str to str
        Laws of the conformance kit that it breaks by design, each with the reason.

    Examples
    --------
    >>> import geodesic_toolkit as gt
    >>> gt.PointCloudLaplacian.domains
    (<class 'geodesic_toolkit.domains.cloud.PointCloud'>,)
    """

    domains: ClassVar[tuple[type[Domain], ...]]
    references: ClassVar[tuple[str, ...]] = ()
    known_failures: ClassVar[Mapping[str, str]] = MappingProxyType({})

    @abc.abstractmethod
    def assemble(self, domain: Domain) -> Discretization:
        """Return the discretization of -Δ (positive semidefinite) on `domain`.

        Parameters
        ----------
        domain : Domain
            One of the kinds in `domains`.

        Returns
        -------
        Discretization

        Raises
        ------
        UnsupportedDomainError
            A domain of another kind.
        """

    def diffusion(self, metric: Discretization) -> Discretization:
        """Return the discretization for the heat flow: `metric` itself, unless overridden.

        An operator whose stiffness may have positive off-diagonal entries can return a Laplacian
        on the same vertices without such entries, so that heat is positive.

        Parameters
        ----------
        metric : Discretization
            The result of `assemble`.

        Returns
        -------
        Discretization
        """
        return metric

    def frames(self, domain: Domain, metric: Discretization) -> Frames:
        """Return tangent frames at the vertices, and the turns from them into the elements.

        They make vectors at different vertices comparable: the connection Laplacian is
        ``G_cᴴ W G_c``, with G_c the gradient whose coefficients are multiplied by the turns,
        Hermitian and positive semidefinite. By default turns are the least rotations from the
        normal at a vertex to that of the element, for meshes and point clouds.

        Parameters
        ----------
        domain : Domain
        metric : Discretization
            The result of `assemble` for the domain.

        Returns
        -------
        Frames

        Raises
        ------
        UnsupportedDomainError
            A graph, whose edges do not have angles; a surface with one side; elements that are
            neither triangles nor edges.
        """
        from geodesic_toolkit.laplacians.tangents import default_frames

        return default_frames(domain, metric)

    def check_domain(self, domain: object) -> None:
        """Raise unless `domain` is one of the kinds in `domains`.

        Parameters
        ----------
        domain : object
            Anything.

        Raises
        ------
        UnsupportedDomainError
            It is of another kind; the message names the accepted kinds.
        """
        if not isinstance(domain, self.domains):
            accepted = " or ".join(kind.__name__ for kind in self.domains)
            raise UnsupportedDomainError(
                f"{type(self).__name__} discretizes {accepted}, not {type(domain).__name__}"
            )
