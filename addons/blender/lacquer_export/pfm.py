"""PFM files: floats without a limit, for images that hold more than 1."""
import numpy as np


def encode(pixels):
    """pixels (height, width) or (height, width, 3), linear, rows from the top: the bytes of the file, whose rows go up."""
    kind = "PF" if pixels.ndim == 3 else "Pf"
    header = f"{kind}\n{pixels.shape[1]} {pixels.shape[0]}\n-1.0\n"
    return header.encode("ascii") + np.ascontiguousarray(np.nan_to_num(pixels)[::-1], dtype="<f4").tobytes()
