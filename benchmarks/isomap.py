"""Isomap on a roll: errors and time of GeodesicIsomap and scikit-learn's Isomap in one run.

python benchmarks/isomap.py            10,000 samples, some minutes
python benchmarks/isomap.py --write    also into docs/_tables

A roll is a rectangle without stretch, so that the true distances are those in the rectangle, and
the embedding should be the rectangle. Errors are of distances from the same landmarks, and of the
embedding after the best rotation.
"""

import argparse
import time

import numpy as np
from measuring.tables import TABLES, markdown
from sklearn.datasets import make_swiss_roll
from sklearn.manifold import Isomap

import geodesic_toolkit as gt
from geodesic_toolkit.sklearn import GeodesicIsomap

NOISE = 0.05
"""Standard deviation of the noise in each of ten coordinates. The roll is 21 wide; of 10,000
samples the nearest is 0.2 away in the median."""

HEADINGS = [
    "samples", "estimator", "neighbours", "landmarks", "distances, %", "embedding, %", "CPU, s",
]  # fmt: skip
NOTE = (
    "Mean error of distances from the landmarks over the mean distance; root mean square error of "
    "the embedding, after the best rotation, over its size. CPU time of `fit_transform`, in one "
    "process. *In ten dimensions*: the roll is turned into them, and every coordinate has noise of "
    f"{NOISE} on a roll that is 21 wide."
)


def arc_length(angle):
    return (angle * np.sqrt(1 + angle**2) + np.arcsinh(angle)) / 2


def roll(n_samples):
    """Return samples of a roll, and where they are in the rectangle."""
    samples, angle = make_swiss_roll(n_samples, random_state=0)
    return samples, np.column_stack([arc_length(angle), samples[:, 1]])


def turned_with_noise(samples):
    rng = np.random.default_rng(0)
    frame = np.linalg.qr(rng.normal(size=(10, 3)))[0]
    return samples @ frame.T + NOISE * rng.normal(size=(len(samples), 10))


def error_of_embedding(found, flat):
    """Return the root mean square distance after the best rotation, over the size."""
    one, other = found - found.mean(axis=0), flat - flat.mean(axis=0)
    left, _, right = np.linalg.svd(one.T @ other)
    off = one @ left @ right - other
    return np.sqrt((off**2).sum() / (other**2).sum())


def error_of_distances(found, landmarks, flat):
    truth = np.linalg.norm(flat[landmarks][:, None] - flat, axis=2)
    return np.abs(found - truth).sum() / truth.sum()


def estimators(in_space):
    """Yield names, estimators, and their neighbours and landmarks as words."""
    for k in (5, 12, 20):
        yield "Isomap of scikit-learn", Isomap(n_neighbors=k), str(k), "all"
    for k, count in ((12, 32), (12, 100), (20, 100)):
        yield "GeodesicIsomap", GeodesicIsomap(n_neighbors=k, landmarks=count), str(k), str(count)
    for name in ("pointcloud", "knn") if in_space else ("knn",):
        if name in gt.operators:
            model = GeodesicIsomap(operator=name, landmarks=100)
            yield f'GeodesicIsomap, operator="{name}"', model, "", "100"


def rows(name, samples, flat):
    landmarks = None
    found = []
    for title, model, neighbours, count in reversed([*estimators(samples.shape[1] == 3)]):
        begin = time.process_time()
        embedding = model.fit_transform(samples)
        seconds = time.process_time() - begin
        if isinstance(model, GeodesicIsomap):
            landmarks, distances = model.landmarks_, model.distances_
        else:
            distances = model.dist_matrix_[landmarks]
        errors = [
            error_of_distances(distances, landmarks, flat),
            error_of_embedding(embedding, flat),
        ]
        figures = [f"{100 * error:.2f}" for error in errors]
        found.append([name, title, neighbours, count, *figures, f"{seconds:.1f}"])
        print(*found[-1], sep=" | ", flush=True)
    return found[::-1]


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--samples", type=int, default=10_000)
    parser.add_argument("--write", action="store_true", help="also into docs/_tables")
    arguments = parser.parse_args()
    samples, flat = roll(arguments.samples)
    size = f"{arguments.samples:,}"
    table = markdown(
        HEADINGS,
        [
            *rows(f"{size} in space", samples, flat),
            *rows(f"{size} in ten dimensions", turned_with_noise(samples), flat),
        ],
        NOTE,
        names=2,
    )
    print(table)
    if arguments.write:
        (TABLES / "isomap.md").write_text(table, encoding="utf-8")


if __name__ == "__main__":
    main()
