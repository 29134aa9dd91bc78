"""Reads EXR files of Lacquer and of Cycles as arrays of channels by name."""
import numpy as np
import OpenImageIO as oiio


def read(path):
    """({channel: (height, width)}, metadata): all layers of an EXR, inside of its data window."""
    source = oiio.ImageInput.open(path)
    if source is None:
        raise OSError(f"{path}: {oiio.geterror()}")
    spec = source.spec()
    pixels = source.read_image(oiio.FLOAT)
    channels = {name: np.asarray(pixels)[:, :, i].astype(np.float64) for i, name in enumerate(spec.channelnames)}
    metadata = {a.name: a.value for a in spec.extra_attribs}
    source.close()
    return channels, metadata


def rgb(channels):
    """(height, width, 3) of the colours."""
    prefix = "" if "R" in channels else next(n[:-1] for n in channels if n.endswith("Combined.R"))
    return np.stack([channels[prefix + c] for c in "RGB"], axis=2)


def vectors(channels, ending):
    """(height, width, 3) of the channels whose names end so, as P or ViewLayer.Position."""
    prefix = next(n[:-1] for n in channels if n.endswith(ending + ".X"))
    return np.stack([channels[prefix + c] for c in "XYZ"], axis=2)
