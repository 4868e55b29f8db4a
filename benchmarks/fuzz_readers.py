"""Check that damaged files are read or refused, without a crash, a hang or an untyped error.

A thousand damaged copies of every kind of file that tests/helpers/sample_files.py makes, and of
every file of ../shared/data: cut, bits flipped, bytes overwritten, pieces inserted, repeated or
zeroed, half of it in the header. Each file has a process of its own, with a limit of time for every
copy and of memory altogether; if that process dies, the next continues after the copy that killed
it. Copies depend only on their number: a fault can be repeated by name and number.

python benchmarks/fuzz_readers.py                      everything, about twenty minutes
python benchmarks/fuzz_readers.py ply bunny            files whose names hold one of these words
python benchmarks/fuzz_readers.py --copies 100         fewer damaged copies of each
python benchmarks/fuzz_readers.py --keep FOLDER        keep the copies that show a fault
"""

import argparse
import io
import json
import random
import resource
import signal
import struct
import subprocess
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT.parent / "shared" / "data"

LARGE = 2_000_000
"""Bytes from which a file is cropped, where its format lets it be."""

CROPPED = 2_000
"""Vertices, or facets, of a cropped file."""

MEMORY = 8 << 30
"""Bytes of address space that reading may take."""

HEADER = 600
"""Bytes in which half of the damage is done: there are the counts."""

TOKENS = (
    *(b"-1", b"0", b"9" * 20, b"nan", b"inf", b"1e999", b"2147483648", b"-9223372036854775808"),
    *(b"\xff\xff\xff\xff", b"\0\0\0\x80", b"\0", b"\n", b" ", b"<", b'"', b"#"),
)


# -- damage ----------------------------------------------------------------------------------------


def damaged(data: bytes, rng: random.Random) -> bytes:
    """Return a copy with the damage of broken transfers, disks and writers."""
    if rng.random() < 0.15:
        return data[: rng.randrange(len(data))]
    copy = bytearray(data)
    for _ in range(rng.choice([1, 1, 1, 2, 5, 20])):
        end = min(len(copy), HEADER) if rng.random() < 0.5 else len(copy)
        if end == 0:
            break
        at, length = rng.randrange(end), rng.randrange(1, 40)
        match rng.randrange(6):
            case 0:
                copy[at] ^= 1 << rng.randrange(8)
            case 1:
                copy[at] = rng.randrange(256)
            case 2:
                copy[at : at + rng.randrange(6)] = rng.choice(TOKENS)
            case 3:
                start = rng.randrange(len(copy))
                copy[at:at] = copy[start : start + length]
            case 4:
                del copy[at : at + length]
            case _:
                copy[at : at + length] = bytes(min(length, len(copy) - at))
    return bytes(copy)


# -- files to damage -------------------------------------------------------------------------------


def files(folder: Path, words: list[str]) -> Iterator[tuple[str, str, bytes]]:
    """Yield names, suffixes and contents: samples of every format, then real files."""
    sys.path.insert(0, str(ROOT / "tests" / "helpers"))
    from sample_files import SAMPLES, WRITTEN

    def wanted(name: str) -> bool:
        return not words or any(word in name for word in words)

    for suffix, makers in SAMPLES.items():
        for make in makers:
            if wanted(make.__name__):
                yield make.__name__, suffix, make()
    for name, (_, write) in WRITTEN.items():
        if wanted(name):
            yield name, name.split()[0], write(folder)
    for name, content in tables().items():
        if wanted(name):
            yield name, name.rpartition(".")[2], content
    for path in sorted(DATA.glob("*"), key=lambda path: path.stat().st_size):
        if path.suffix != ".md" and wanted(path.name):
            yield path.name, path.suffix[1:], cropped(path)


def tables() -> dict[str, bytes]:
    """Return what `read_points`, `read_mask` and `read_vertices` take besides shapes."""
    from sample_files import POINTS

    def array(values: np.ndarray) -> bytes:
        file = io.BytesIO()
        np.save(file, values)
        return file.getvalue()

    text = "\n".join(",".join(map(str, row)) for row in POINTS.tolist())
    return {
        "points .npy": array(POINTS),
        "points .csv": f"x,y,z\n{text}\n".encode(),
        "mask .npy": array(np.arange(6) > 2),
        "mask of numbers .npy": array(np.array([5, 1, 4])),
        "mask .txt": b"0 # open\n1 1 0\n1 0\n",
        "mask .csv": b"5,1,4\n",
        "vertices .npy": array(np.array([5, 1, 4])),
        "vertices .csv": b"vertex\n5\n1\n4\n",
    }


def cropped(path: Path) -> bytes:
    """Return a file, or the beginning of what it holds where it is large."""
    data = path.read_bytes()
    if len(data) < LARGE:
        return data
    if path.suffix == ".obj":
        return cropped_obj(data)
    if path.suffix.lower() == ".stl":
        return data[:80] + struct.pack("<I", CROPPED) + data[84 : 84 + 50 * CROPPED]
    return data


def cropped_obj(data: bytes) -> bytes:
    """Return the first vertices, and the faces that need no others."""
    kept, count = [], 0
    for line in data.splitlines(keepends=True):
        kind, *rest = line.split() or [b""]
        count += kind == b"v"
        corners = [int(word.partition(b"/")[0]) for word in rest] if kind == b"f" else []
        if max(corners, default=0) <= CROPPED and not (kind == b"v" and count > CROPPED):
            kept.append(line)
    return b"".join(kept)


# -- reading damaged copies ------------------------------------------------------------------------


def work(source: Path, name: str, first: int, copies: int, limit: int, log: Path) -> None:
    """Read damaged copies from number `first` on; run in a process that may die of it."""
    import geodesic_toolkit as gt
    from geodesic_toolkit.io import read_mask, read_points, read_vertices

    readers = {
        "points": read_points,
        "mask": lambda path: read_mask(path, 6),
        "vertices": read_vertices,
    }
    reader = readers.get(name.partition(" ")[0], gt.read)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    data, target = source.read_bytes(), source.with_name(f"damaged{source.suffix}")
    with log.open("a", buffering=1) as told, warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        for number in range(first, copies):
            target.write_bytes(damaged(data, random.Random(f"{name} {number}")))
            told.write(json.dumps({"number": number}) + "\n")
            signal.alarm(limit)  # not caught: the process dies at once
            started = time.process_time()
            try:
                outcome = type(reader(target)).__name__
            except gt.errors.GeodesicError as error:
                outcome = type(error).__name__
                if "\n" in str(error) or "damaged" not in str(error):
                    outcome += " of many lines" if "\n" in str(error) else " without the name"
            except BaseException as error:  # its kind is the measurement
                outcome = f"bare {type(error).__name__}"
            signal.alarm(0)
            foreign = [w for w in caught if not issubclass(w.category, gt.errors.GeodesicWarning)]
            caught.clear()
            told.write(
                json.dumps(
                    {
                        "outcome": outcome,
                        "seconds": time.process_time() - started,
                        "foreign": [f"{w.category.__name__}: {w.message}" for w in foreign],
                    }
                )
                + "\n"
            )


def examine(
    name: str, suffix: str, data: bytes, copies: int, limit: int, folder: Path, keep: Path | None
) -> bool:
    """Damage one file `copies` times, print the outcomes, and return whether all are right."""
    source, log = folder / f"source.{suffix}", folder / "log"
    source.write_bytes(data)
    log.unlink(missing_ok=True)
    first, deaths = 0, []
    while first < copies:
        words = ["--work", source, name, first, copies, limit, log]
        done = subprocess.run(
            [sys.executable, __file__, *map(str, words)], capture_output=True, check=False
        )
        if done.returncode == 0:
            break
        told = [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []
        if not any("number" in line for line in told):
            raise RuntimeError(done.stderr.decode(errors="replace"))
        number = next(line["number"] for line in reversed(told) if "number" in line)
        hung = done.returncode == -signal.SIGALRM
        deaths.append((number, "hang" if hung else f"crash ({done.returncode})"))
        first = number + 1
    lines = [json.loads(line) for line in log.read_text().splitlines()]
    outcomes = [line for line in lines if "outcome" in line]
    numbers = [line["number"] for line, then in pairwise(lines) if "outcome" in then]
    faults = deaths + [
        (number, line["outcome"] if " " in line["outcome"] else line["foreign"][0])
        for number, line in zip(numbers, outcomes, strict=True)
        if " " in line["outcome"] or line["foreign"]
    ]
    counts = Counter(line["outcome"] for line in outcomes)
    print(
        f"{name:40s} {', '.join(f'{count} {kind}' for kind, count in counts.most_common())}; "
        f"slowest {max(line['seconds'] for line in outcomes):.2f} s of work",
        flush=True,
    )
    for number, fault in faults[:5]:
        print(f"    copy {number}: {fault[:200]}", flush=True)
        if keep is not None:
            keep.mkdir(parents=True, exist_ok=True)
            copy = damaged(data, random.Random(f"{name} {number}"))
            (keep / f"{name.replace(' ', '_')}-{number}.{suffix}").write_bytes(copy)
    if len(faults) > 5:
        print(f"    and {len(faults) - 5} more")
    return not faults


def main() -> None:
    """Run the benchmark of the command line."""
    if sys.argv[1:2] == ["--work"]:
        source, name, first, copies, limit, log = sys.argv[2:]
        work(Path(source), name, int(first), int(copies), int(limit), Path(log))
        return
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("words", nargs="*", help="parts of names")
    parser.add_argument("--copies", type=int, default=1000, help="damaged copies of each file")
    parser.add_argument("--limit", type=int, default=20, help="seconds that a copy may take")
    parser.add_argument("--keep", type=Path, help="where copies that show a fault are kept")
    arguments = parser.parse_args()
    well = []
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for name, suffix, data in files(folder, arguments.words):
            options = (arguments.copies, arguments.limit, folder, arguments.keep)
            well.append(examine(name, suffix, data, *options))
    print(f"\n{sum(well)} of {len(well)} files without a fault")
    sys.exit(not all(well))


if __name__ == "__main__":
    main()
