"""Damaged files are read or refused: never a crash, never another error."""

import random
import struct
import warnings

import numpy as np
import pytest
from sample_files import OWN, POINTS, WRITTEN, place, ply_header

import geodesic_toolkit as gt
from geodesic_toolkit.errors import GeodesicError, ReadWarning
from geodesic_toolkit.io import read_mask, read_points, read_vertices

# -- damage ---------------------------------------------------------------------------------------


def damaged(data, rng):
    """Cut the file, flip bits, overwrite or insert, as broken copies and broken writers do."""
    if rng.random() < 0.2:
        return data[: rng.randrange(len(data))]
    mutated = bytearray(data)
    for _ in range(rng.choice([1, 1, 2, 8])):
        at = rng.randrange(len(mutated))
        match rng.randrange(3):
            case 0:
                mutated[at] ^= 1 << rng.randrange(8)
            case 1:
                mutated[at : at + rng.randrange(5)] = rng.choice(
                    [b"-1", b"9" * 20, b"nan", b"\xff" * 4, b"\n"]
                )
            case _:
                mutated[at] = rng.randrange(256)
    return bytes(mutated)


def check_damaged(path, data, times):
    rng = random.Random(path.name)
    for _ in range(times):
        path.write_bytes(damaged(data, rng))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ReadWarning)
            try:
                outcome = gt.read(path)
            except GeodesicError as error:
                outcome = error
        assert isinstance(outcome, gt.Domain | GeodesicError)
        assert "\n" not in str(outcome)


@pytest.mark.parametrize(("suffix", "make"), OWN, ids=[make.__name__ for _, make in OWN])
def test_a_damaged_file_is_read_or_refused(suffix, make, tmp_path):
    check_damaged(tmp_path / f"damaged.{suffix}", make(), 60)


@pytest.mark.parametrize(
    ("name", "values", "read"),
    [
        ("points.npy", POINTS, read_points),
        ("mask.npy", np.arange(6) > 2, lambda path: read_mask(path, 6)),
        ("masked.npy", np.array([5, 1]), lambda path: read_mask(path, 6)),
        ("vertices.npy", np.array([5, 1]), read_vertices),
    ],
)
def test_a_damaged_array_is_read_or_refused(name, values, read, tmp_path):
    np.save(tmp_path / name, values)
    data, rng = (tmp_path / name).read_bytes(), random.Random(name)
    for _ in range(150):
        (tmp_path / name).write_bytes(damaged(data, rng))
        try:
            outcome = read(tmp_path / name)
        except GeodesicError as error:
            outcome = error
        assert isinstance(outcome, gt.PointCloud | np.ndarray | GeodesicError)
        assert "\n" not in str(outcome) or isinstance(outcome, np.ndarray)


def test_a_signalling_nan_of_a_damaged_scan_is_a_missing_point(tmp_path):
    signalling = struct.pack("<I", 0x7FA00000)
    header = ply_header("binary_little_endian", ("vertex 6", ["float x", "float y", "float z"]))
    data = POINTS.astype("<f4").tobytes()
    cloud = gt.read(place(tmp_path, "c.ply", header + data[:24] + signalling + data[28:]))
    assert cloud.present.tolist() == [True, True, False, True, True, True]
    points = np.frombuffer(data[:24] + signalling + data[28:], "<f4").reshape(-1, 3)
    assert gt.PointCloud(points).present.sum() == 5


@pytest.mark.slow
@pytest.mark.parametrize("name", WRITTEN)
def test_a_damaged_file_of_another_package_is_read_or_refused(name, tmp_path):
    package, make = WRITTEN[name]
    pytest.importorskip(package)
    check_damaged(tmp_path / f"damaged.{name.split()[0]}", make(tmp_path), 40)
