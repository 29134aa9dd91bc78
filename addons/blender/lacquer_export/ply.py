"""Binary PLY files of triangles, as the shape "plymesh" reads them."""
import numpy as np


def encode(positions, faces, normals=None, uvs=None):
    """positions (n, 3), faces (m, 3) of indices, normals (n, 3), uvs (n, 2): the bytes of the file."""
    fields = [("x", "<f4"), ("y", "<f4"), ("z", "<f4")]
    columns = [positions]
    if normals is not None:
        fields += [("nx", "<f4"), ("ny", "<f4"), ("nz", "<f4")]
        columns.append(normals)
    if uvs is not None:
        fields += [("u", "<f4"), ("v", "<f4")]
        columns.append(uvs)
    vertices = np.ascontiguousarray(np.concatenate(columns, axis=1), dtype="<f4")
    rows = np.empty(len(faces), dtype=[("count", "u1"), ("indices", "<i4", 3)])
    rows["count"] = 3
    rows["indices"] = faces
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}"]
    header += [f"property float {name}" for name, _ in fields]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", ""]
    return "\n".join(header).encode("ascii") + vertices.tobytes() + rows.tobytes()
