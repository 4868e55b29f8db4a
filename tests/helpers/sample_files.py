"""Files to read: an octahedron in every format, as bytes, made without the code under test."""

import io
import struct
from pathlib import Path

import numpy as np
from scipy import sparse

import geodesic_toolkit as gt

POINTS = np.array(
    [[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]], dtype=np.float64
) * [1.0, 0.5, 0.25]
FACES = np.array(
    [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
)
EDGES = np.array([[0, 1], [1, 2], [0, 2], [3, 4], [4, 5]])
LENGTHS = np.array([1.0, 0.1, 2.5, 1e-3, 7.0])


def rows(table, separator=" "):
    return "\n".join(separator.join(map(repr, row)) for row in np.asarray(table).tolist()) + "\n"


def off(points=POINTS, faces=FACES):
    polygons = np.column_stack([np.full(len(faces), 3), faces])
    return f"OFF\n{len(points)} {len(faces)} 0\n{rows(points)}{rows(polygons)}".encode()


def write_off(path, mesh):
    """Write a mesh, and give its path."""
    path.write_bytes(off(mesh.vertices, mesh.faces))
    return path


def obj():
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in POINTS.tolist()]
    lines += [f"f {a}//1 {b}//1 {c}//1" for a, b, c in (FACES + 1).tolist()]
    return "\n".join(["# an octahedron", "vn 0 0 1", *lines, ""]).encode()


def stl():
    facets = b"".join(
        struct.pack("<12fH", 0, 0, 0, *POINTS[face].astype("f4").ravel(), 0) for face in FACES
    )
    return b"solid, though binary".ljust(80) + struct.pack("<I", len(FACES)) + facets


def stl_text():
    facets = "".join(
        "facet normal 0 0 0\n outer loop\n"
        + "".join(f"  vertex {x!r} {y!r} {z!r}\n" for x, y, z in POINTS[face].tolist())
        + " endloop\nendfacet\n"
        for face in FACES
    )
    return f"solid octahedron\n{facets}endsolid octahedron\n".encode()


def ply_header(form, *elements):
    lines = ["ply", f"format {form} 1.0", "comment an octahedron"]
    for element, properties in elements:
        lines += [f"element {element}", *(f"property {each}" for each in properties)]
    return "\n".join([*lines, "end_header", ""]).encode()


XYZ = ["double x", "double y", "double z"]
LISTS = ["list uchar int vertex_indices"]


def ply():
    faces = np.column_stack([np.full(len(FACES), 3), FACES])
    header = ply_header("ascii", ("vertex 6", XYZ), ("face 8", LISTS))
    return header + (rows(POINTS) + rows(faces)).encode()


def ply_binary(order="<"):
    name = {"<": "binary_little_endian", ">": "binary_big_endian"}[order]
    header = ply_header(name, ("vertex 6", XYZ), ("face 8", LISTS))
    faces = b"".join(struct.pack(order + "B3i", 3, *face) for face in FACES.tolist())
    return header + POINTS.astype(order + "f8").tobytes() + faces


def ply_big_endian():
    return ply_binary(">")


def ply_cloud():
    header = ply_header("ascii", ("vertex 6", [*XYZ, "float nx", "float ny", "float nz"]))
    return header + rows(np.column_stack([POINTS, np.sign(POINTS)])).encode()


def pcd_header(form, kinds="F F F", sizes="8 8 8"):
    return (
        f"# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE {sizes}\nTYPE {kinds}\nCOUNT 1 1 1\n"
        f"WIDTH 6\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 6\nDATA {form}\n"
    ).encode()


def pcd():
    return pcd_header("ascii") + rows(POINTS).encode()


def pcd_binary():
    return pcd_header("binary") + POINTS.tobytes()


def lzf(data):
    """Compress: zero runs become repetitions that run into themselves, all else is literal."""
    packed, at = bytearray(), 0
    while at < len(data):
        zeros = len(data[at:]) - len(data[at:].lstrip(b"\0"))
        if zeros > 4 and at > 0 and data[at - 1] == 0:
            length = min(zeros, 264) - 2
            packed += bytes([length << 5, 0]) if length < 7 else bytes([7 << 5, length - 7, 0])
            at += length + 2
        else:
            packed += bytes([0, data[at]])
            at += 1
    return bytes(packed)


def pcd_compressed():
    packed = lzf(POINTS.T.tobytes())
    return pcd_header("binary_compressed") + struct.pack("<II", len(packed), 6 * 24) + packed


def xyz():
    return b"# x y z\n" + rows(POINTS).encode()


def csv():
    return (
        b'"id";"z [m]";"x [m]";"y [m]"\n'
        + "".join(
            f"{number};{z};{x};{y}\n".replace(".", ",")
            for number, (x, y, z) in enumerate(POINTS.tolist())
        ).encode()
    )


def pts():
    return b"6\n" + rows(np.column_stack([POINTS, np.full((6, 4), 255)])).encode()


def mtx():
    entries = rows(np.column_stack([EDGES + 1, LENGTHS]).astype(object)).replace(".0 ", " ")
    return f"%%MatrixMarket matrix coordinate real general\n6 6 5\n{entries}".encode()


def edges():
    return (
        b"# i j length\n"
        + "".join(
            f"{i} {j} {length!r}\n"
            for (i, j), length in zip(EDGES.tolist(), LENGTHS.tolist(), strict=True)
        ).encode()
    )


def npz_of(**arrays):
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    return buffer.getvalue()


def npz():
    matrix = sparse.csr_array((LENGTHS, tuple(EDGES.T)), shape=(6, 6))
    buffer = io.BytesIO()
    sparse.save_npz(buffer, matrix)
    return buffer.getvalue()


def npz_mesh():
    return npz_of(vertices=POINTS, faces=FACES)


def npz_cloud():
    return npz_of(points=POINTS, normals=np.sign(POINTS))


def vtk():
    faces = np.column_stack([np.full(len(FACES), 3), FACES])
    return (
        "# vtk DataFile Version 3.0\nan octahedron\nASCII\nDATASET POLYDATA\n"
        f"POINTS 6 double\n{rows(POINTS)}POLYGONS 8 32\n{rows(faces)}POINT_DATA 6\n"
    ).encode()


SAMPLES = {
    "off": [off],
    "obj": [obj],
    "ply": [ply, ply_binary, ply_big_endian, ply_cloud],
    "stl": [stl, stl_text],
    "pcd": [pcd, pcd_binary, pcd_compressed],
    "xyz": [xyz],
    "txt": [xyz],
    "asc": [xyz],
    "csv": [csv],
    "pts": [pts],
    "mtx": [mtx],
    "npz": [npz, npz_mesh, npz_cloud],
    "edges": [edges],
    "vtk": [vtk],
}
"""Functions without arguments, by suffix."""


# -- by the packages that own the format ---------------------------------------------------------


def through_file(suffix, folder, write):
    path = Path(folder) / f"written.{suffix}"
    write(path)
    return path.read_bytes()


def meshio_bytes(form, suffix, folder, **options):
    import meshio

    mesh = meshio.Mesh(POINTS, [("triangle", FACES)])
    return through_file(suffix, folder, lambda path: meshio.write(path, mesh, form, **options))


def glb(folder):
    import trimesh

    return trimesh.Trimesh(POINTS, FACES, process=False).export(file_type="glb")


def gltf(folder):
    """With its buffers inside."""
    import base64

    import trimesh

    files = trimesh.Trimesh(POINTS, FACES, process=False).export(file_type="gltf")
    text = files["model.gltf"].decode()
    for name, data in files.items():
        text = text.replace(
            f'"{name}"', f'"data:application/octet-stream;base64,{base64.b64encode(data).decode()}"'
        )
    return text.encode()


def gii(folder):
    import nibabel
    from nibabel.gifti import GiftiDataArray, GiftiImage

    image = GiftiImage(
        darrays=[
            GiftiDataArray(POINTS.astype("f4"), intent="NIFTI_INTENT_POINTSET"),
            GiftiDataArray(FACES.astype("i4"), intent="NIFTI_INTENT_TRIANGLE"),
        ]
    )
    return through_file("surf.gii", folder, lambda path: nibabel.save(image, path))


def vtp(folder, mode="Appended", *, raw=False, compressor="ZLib", header=32):
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

    points, cells = vtkPoints(), vtkCellArray()
    points.SetDataTypeToDouble()
    for place in POINTS.tolist():
        points.InsertNextPoint(place)
    for face in FACES.tolist():
        cells.InsertNextCell(3, face)
    data, writer = vtkPolyData(), vtkXMLPolyDataWriter()
    data.SetPoints(points)
    data.SetPolys(cells)
    writer.SetInputData(data)
    getattr(writer, f"SetDataModeTo{mode}")()
    if raw:
        writer.EncodeAppendedDataOff()
    getattr(writer, f"SetCompressorTypeTo{compressor}")()
    getattr(writer, f"SetHeaderTypeToUInt{header}")()

    def write(path):
        writer.SetFileName(str(path))
        assert writer.Write()

    return through_file("vtp", folder, write)


def pial(folder):
    from nibabel.freesurfer import write_geometry

    return through_file("pial", folder, lambda path: write_geometry(str(path), POINTS, FACES))


def las(folder, suffix="las"):
    import laspy

    scan = laspy.create(point_format=0)
    scan.header.scales = [0.25, 0.25, 0.25]
    scan.x, scan.y, scan.z = POINTS.T
    return through_file(suffix, folder, scan.write)


WRITTEN = {
    "glb": ("trimesh", glb),
    "gltf": ("trimesh", gltf),
    "mesh": ("meshio", lambda folder: meshio_bytes("medit", "mesh", folder)),
    "msh": ("meshio", lambda folder: meshio_bytes("gmsh", "msh", folder, binary=False)),
    "msh binary": ("meshio", lambda folder: meshio_bytes("gmsh", "msh", folder)),
    "vtk grid": ("meshio", lambda folder: meshio_bytes("vtk", "vtk", folder)),
    "vtu": ("meshio", lambda folder: meshio_bytes("vtu", "vtu", folder)),
    "gii": ("nibabel", gii),
    "vtp": ("vtk", vtp),
    "vtp raw": ("vtk", lambda folder: vtp(folder, raw=True)),
    "vtp base64": ("vtk", lambda folder: vtp(folder, "Binary")),
    "vtp ascii": ("vtk", lambda folder: vtp(folder, "Ascii")),
    "vtp lzma": ("vtk", lambda folder: vtp(folder, compressor="LZMA")),
    "vtp plain": ("vtk", lambda folder: vtp(folder, raw=True, compressor="None", header=64)),
    "vtp plain base64": ("vtk", lambda folder: vtp(folder, "Binary", compressor="None")),
    "pial": ("nibabel", pial),
    "las": ("laspy", las),
    "laz": ("lazrs", lambda folder: las(folder, "laz")),
}
"""Package and function of a folder, by suffix (and what else distinguishes them)."""

OWN = [(suffix, make) for suffix, makes in SAMPLES.items() for make in makes]
"""Suffix and function of every format that needs no other package."""

TRIANGLE = "0 0 0\n1 0 0\n0 1 0\n"
"""The rows of a triangle, as in OFF and PLY."""

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
"""The vertices of a square, as in OBJ."""


def place(folder, name, contents):
    """Write a file and return its path."""
    path = folder / name
    path.write_bytes(contents if isinstance(contents, bytes) else contents.encode())
    return path


def check_octahedron(domain, *, exact=True):
    """Fail unless a domain is the octahedron of this file: mesh, cloud, or graph of edges."""
    tolerance = 0 if exact else 1e-6
    if isinstance(domain, gt.Graph):
        assert domain.n_vertices == 6
        order = np.lexsort(np.sort(EDGES).T[::-1])
        found = np.lexsort(domain.edges.T[::-1])
        np.testing.assert_array_equal(domain.edges[found], EDGES[order])
        np.testing.assert_array_equal(domain.lengths[found], LENGTHS[order])
    elif isinstance(domain, gt.PointCloud):
        np.testing.assert_allclose(domain.points, POINTS, rtol=tolerance)
    else:
        np.testing.assert_allclose(domain.vertices, POINTS, rtol=tolerance)
        np.testing.assert_array_equal(domain.faces, FACES)
