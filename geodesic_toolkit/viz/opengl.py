"""A probe, in a separate process, of whether the system can draw."""

import contextlib
import ctypes.util
from collections.abc import Iterator

from geodesic_toolkit.core.optional import require
from geodesic_toolkit.errors import MissingDependencyError

__all__ = ["check_opengl", "quiet"]


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Suppress VTK's message on stderr that there is no X server."""
    logger = require("vtkmodules.vtkCommonCore", "viz", "Pictures need").vtkLogger
    before = logger.GetCurrentVerbosityCutoff()
    logger.SetStderrVerbosity(logger.VERBOSITY_OFF)
    try:
        yield
    finally:
        logger.SetStderrVerbosity(before)


def check_opengl() -> None:
    """Raise if drawing would end the process: VTK without OpenGL dereferences a null pointer.

    Its factory tries X, then EGL, then returns an OSMesa window without testing it.

    Raises
    ------
    MissingDependencyError
        All three are missing; the message names the system packages.
    """
    require("vtkmodules.vtkRenderingOpenGL2", "viz", "Pictures need")  # it registers the windows
    window = require("vtkmodules.vtkRenderingCore", "viz", "Pictures need").vtkRenderWindow()
    if window.GetClassName() != "vtkOSOpenGLRenderWindow" or ctypes.util.find_library("OSMesa"):
        return
    raise MissingDependencyError(
        "OpenGL is not available: the system library libEGL or its driver is "
        "missing; install it (Debian, Ubuntu: apt-get install libegl1 libgl1 libgl1-mesa-dri; "
        "Fedora: dnf install mesa-libEGL mesa-dri-drivers)"
    )
