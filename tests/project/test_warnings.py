"""Warnings: where they point, and that they can be collected without the rest of the process."""

import threading
import warnings

import pytest

from geodesic_toolkit.core.warning import collected_warnings, warn
from geodesic_toolkit.errors import CoarseMeshWarning, GeodesicWarning, ReadWarning


def test_warnings_of_a_kind_are_collected_and_others_are_issued():
    with collected_warnings(CoarseMeshWarning) as collected:
        warn("the mesh is coarse", CoarseMeshWarning)
        with pytest.warns(ReadWarning, match="polygons"):
            warn("polygons were split", ReadWarning)
    assert collected == [("the mesh is coarse", CoarseMeshWarning)]
    with pytest.warns(CoarseMeshWarning):
        warn("the mesh is coarse", CoarseMeshWarning)


def test_the_innermost_collector_of_a_kind_has_them():
    with collected_warnings(GeodesicWarning) as outer, collected_warnings(ReadWarning) as inner:
        warn("polygons were split", ReadWarning)
        warn("the mesh is coarse", CoarseMeshWarning)
    assert [text for text, _ in inner] == ["polygons were split"]
    assert [text for text, _ in outer] == ["the mesh is coarse"]


def test_a_thread_collects_its_own_warnings_and_leaves_those_of_others():
    issued = []

    def elsewhere():
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            warn("the mesh is coarse", CoarseMeshWarning)
        issued.extend(str(warning.message) for warning in caught)

    with collected_warnings(GeodesicWarning) as collected:
        thread = threading.Thread(target=elsewhere)
        thread.start()
        thread.join()
    assert issued == ["the mesh is coarse"]
    assert collected == []
