"""The time step t of the heat method, in squared length.

The shorter it is, the closer the heat follows distance, down to the length of an edge, below which
it follows edges instead: t = h² is the paper's choice.

K. Crane, C. Weischedel, M. Wardetzky, *Geodesics in Heat*, 2013,
https://doi.org/10.1145/2516971.2516977
"""

import numpy as np

from geodesic_toolkit.core.checks import real_number
from geodesic_toolkit.core.types import FloatArray
from geodesic_toolkit.discretization.data import Discretization
from geodesic_toolkit.errors import InvalidOptionError

__all__ = ["time_steps"]

MAX_RELATIVE_TIME_STEP = 1e12
"""Maximum time step, in squared mean edge lengths, for which the mass is not lost in rounding.
Measured: distances are correct up to 1e14, and 0 everywhere from 1e16 on."""


def time_steps(
    time: float | None, time_factor: float, metric: Discretization, diffusion: Discretization
) -> float | FloatArray:
    """Return the time step: a number, or (N,) if components have different scales.

    Parameters
    ----------
    time : float, optional
        The step itself, for all components.
    time_factor : float
        The step in units of the squared scale of each component.
    metric, diffusion : Discretization
        On the same vertices.

    Raises
    ------
    InvalidOptionError
        A value that is not positive and finite, or so long that the mass is lost in rounding; both
        a `time` and a `time_factor`.
    """
    given = {
        "time": None if time is None else real_number(time, "time"),
        "time_factor": real_number(time_factor, "time_factor"),
    }
    for name, value in given.items():
        if value is not None and not (np.isfinite(value) and value > 0):
            raise InvalidOptionError(f"{name} must be positive and finite, not {value}")
    if time is not None and time_factor != 1.0:
        raise InvalidOptionError("give time or time_factor, not both")
    least = float(metric.scales.min())
    longest = time_factor if time is None else float(time) / least**2
    if not longest <= MAX_RELATIVE_TIME_STEP:
        raise InvalidOptionError(
            f"the time step is {longest:.3g} squared mean edge lengths: so long that the heat "
            "becomes uniform; usual values are 1 to 100"
        )
    if time is not None:
        return float(time)
    first = float(metric.scales[0])
    if (metric.scales == first).all():
        return float(time_factor) * first**2
    # Heat may flow between components of the metric, and t has to be one number for all of these.
    largest = np.zeros(int(diffusion.components.max()) + 1)
    np.maximum.at(largest, diffusion.components, metric.scales)
    return np.asarray(float(time_factor) * largest[diffusion.components] ** 2)
