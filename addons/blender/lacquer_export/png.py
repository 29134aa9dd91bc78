"""PNG files of 16 bits, grey or RGB: what the exporter computes of images, with linear values."""
import struct
import zlib

import numpy as np


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def encode(pixels):
    """pixels (height, width) or (height, width, 3) in [0, 1], rows from the top: the bytes of the file."""
    height, width = pixels.shape[:2]
    values = np.rint(np.clip(np.nan_to_num(pixels), 0, 1) * 65535).astype(">u2").reshape(height, -1)
    rows = np.zeros((height, 1 + values.shape[1] * 2), dtype=np.uint8)  # the first byte of a row: no filter
    rows[:, 1:] = values.view(np.uint8)
    color_type = 2 if pixels.ndim == 3 else 0
    header = struct.pack(">IIBBBBB", width, height, 16, color_type, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows.tobytes(), 6)) +
            chunk(b"IEND", b""))
