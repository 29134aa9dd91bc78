"""--display-server: what a viewer that speaks tev's protocol gets, and viewers that are absent, hang or go away."""
import os
import re
import signal
import socket
import struct
import threading
import time

from run import Case
from command_line import GOOD, has, left, oiiotool, pixels, render


def address(name, value):
    return Case("display-" + name, GOOD, ["--display-server", value, "HOST:PORT"], 1, ["--display-server", value])


CASES = [
    address("port-word", "localhost:tev"),
    address("port-zero", "localhost:0"),
    address("port-huge", "localhost:65536"),
    address("port-empty", "localhost:"),
    address("host-empty", ":14158"),
    address("bracket-open", "[::1:14158"),
    address("bracket-junk", "[::1]14158"),
]

CHECKS = []

SIZE = (75, 130)
SCENE = """Film "rgb" "integer xresolution" %d "integer yresolution" %d "bool savefp16" false "string filename" "view.exr"
Sampler "halton" "integer pixelsamples" %d
LookAt 0 1 -4  0 0 0  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
LightSource "infinite" "rgb L" [.4 .5 .6]
LightSource "point" "point3 from" [2 3 -3] "rgb I" [9 9 9]
Material "conductor" "float roughness" 0.2
Shape "sphere"
"""


def check(function):
    CHECKS.append(function)
    return function


class Viewer(threading.Thread):
    """Listens as tev does, and keeps the images and what was done to them."""

    def __init__(self, family=socket.AF_INET, host="127.0.0.1", reads=None):
        super().__init__(daemon=True)
        self.images, self.operations, self.problem = {}, [], None
        self.reads = reads               # number of packets; all of them if None
        self.socket = socket.socket(family)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        self.socket.bind((host, 0))
        self.socket.listen(1)
        self.socket.settimeout(20)
        self.address = "%s:%d" % ("[%s]" % host if ":" in host else host, self.socket.getsockname()[1])
        self.hold = threading.Event()    # keeps an unread connection open
        self.closes = False
        self.start()

    def run(self):
        try:
            connection, _ = self.socket.accept()
            with connection:
                while self.reads is None or len(self.operations) < self.reads:
                    head = self.take(connection, 4)
                    if head is None:
                        return
                    self.obey(self.take(connection, struct.unpack("<I", head)[0] - 4))
                if not self.closes:
                    self.hold.wait(30)
        except Exception as problem:  # told by the test's own thread
            self.problem = repr(problem)

    @staticmethod
    def take(connection, count):
        """That many bytes; None at the end of the connection, if it is between two packets."""
        data = b""
        while len(data) < count:
            part = connection.recv(count - len(data))
            if not part:
                assert not data and count == 4, "the connection ends within a packet"
                return None
            data += part
        return data

    def obey(self, packet):
        at = 0

        def number(form):
            nonlocal at
            value, = struct.unpack_from("<" + form, packet, at)
            at += struct.calcsize(form)
            return value

        def text():
            nonlocal at
            end = packet.index(b"\0", at)
            value, at = packet[at:end].decode(), end + 1
            return value

        operation, _, name = number("B"), number("B"), text()
        self.operations.append((operation, name))
        if operation == 4:
            width, height = number("i"), number("i")
            channels = [text() for _ in range(number("i"))]
            self.images[name] = {"size": (width, height), "updates": 0,
                                 "channels": {c: [None] * (width * height) for c in channels}}
        elif operation == 5:
            image = self.images[name]
            channels = [text() for _ in range(number("i"))]
            x, y, w, h = (number("i") for _ in range(4))
            width, height = image["size"]
            assert 0 <= x and 0 <= y and w > 0 and h > 0 and x + w <= width and y + h <= height, (x, y, w, h)
            for channel in channels:
                values = struct.unpack_from("<%df" % (w * h), packet, at)
                at += 4 * w * h
                for row in range(h):
                    start = (y + row) * width + x
                    image["channels"][channel][start:start + w] = values[row * w:(row + 1) * w]
            image["updates"] += y + h == height and x + w == width
        else:
            raise AssertionError("operation %d" % operation)
        assert at == len(packet), "%d bytes behind the packet's end" % (len(packet) - at)

    def finish(self):
        self.hold.set()
        self.join(20)
        self.socket.close()
        assert self.problem is None, self.problem


def scene(width=SIZE[0], height=SIZE[1], spp=40):
    return SCENE % (width, height, spp)


def rgb_of_file(tool, folder, name):
    """Values from the top left, one list for each channel."""
    oiiotool(folder, name, "--ch", "R,G,B", "-o", "rgb.exr")
    result = tool.run(["convert", "rgb.exr", "rgb.pfm"], folder)
    assert result.status == 0, result.err
    with open(os.path.join(folder, "rgb.pfm"), "rb") as f:
        data = f.read()
    head = re.match(rb"PF\s+(\d+)\s+(\d+)\s+(\S+)\s", data)
    width, height = int(head.group(1)), int(head.group(2))
    order = "<" if float(head.group(3)) < 0 else ">"
    values = struct.unpack(order + "%df" % (3 * width * height), data[head.end():])
    rows = [values[3 * width * y:3 * width * (y + 1)] for y in range(height)][::-1]
    return [[v for row in rows for v in row[c::3]] for c in range(3)]


def warnings(result):
    return [line for line in result.err.splitlines() if "warning:" in line]


def shows_what_is_written(tool, folder, viewer, *args, name="view.exr", text=None):
    result = render(tool, folder, "--display-server", viewer.address, *args, scene=text or scene())
    viewer.finish()
    assert not warnings(result), result.err
    assert list(viewer.images) == [name], list(viewer.images)
    assert viewer.operations[0] == (4, name) and [o for o, _ in viewer.operations].count(4) == 1, viewer.operations
    image = viewer.images[name]
    assert list(image["channels"]) == ["R", "G", "B"], list(image["channels"])
    for channel, written in zip("RGB", rgb_of_file(tool, folder, name)):
        shown = image["channels"][channel]
        assert None not in shown, "some pixels of %s were never sent" % channel
        wrong = sum(a != b for a, b in zip(shown, written))
        assert len(shown) == len(written) and not wrong, "%d pixels of %s differ from the file" % (wrong, channel)
    return image


@check
def display_gets_the_image_that_is_written(tool, folder):
    # The image has more rows than a packet, and not a multiple of them. Passes end at 8, 32 and 40 samples; a
    # slow viewer may miss all but the last.
    image = shows_what_is_written(tool, folder, Viewer())
    assert image["size"] == SIZE and 1 <= image["updates"] <= 3, image["updates"]
    shown = pixels(folder, "view.exr")
    render(tool, folder, "--outfile", "alone.exr", scene=scene())
    assert pixels(folder, "alone.exr") == shown, "the viewer changes the image"


@check
def display_of_a_render_that_ends_within_a_pass(tool, folder):
    # Far from done: the first passes take long enough for the limit to come in one.
    image = shows_what_is_written(tool, folder, Viewer(), "--time-limit", "0.3", text=scene(200, 160, 1 << 20))
    assert image["size"] == (200, 160), image["size"]


@check
def display_over_ipv6(tool, folder):
    try:
        viewer = Viewer(socket.AF_INET6, "::1")
    except OSError:
        return "no IPv6 here: skipped"
    shows_what_is_written(tool, folder, viewer)


@check
def display_of_a_crop_and_of_more_channels(tool, folder):
    image = shows_what_is_written(tool, folder, Viewer(), "--cropwindow", "0.25,0.75,0,0.5", "--aov", "depth,normal",
                                  "--outfile", "other.exr", name="other.exr")
    assert image["size"] == (38, 65), image["size"]


def goes_on(tool, folder, viewer_address, says, *args, text=None, most_seconds=10):
    """One warning, and the same image as without a viewer."""
    text = text or scene()
    result = render(tool, folder, "--display-server", viewer_address, *args, scene=text)
    assert len(warnings(result)) == 1, "not one warning: " + result.err
    has(result.err, r'warning: the display server ".*" ' + says)
    assert result.seconds < most_seconds * (10 if tool.sanitized else 1), "took %.1f s" % result.seconds
    assert left(folder) == ["view.exr"], left(folder)
    shown = pixels(folder, "view.exr")
    render(tool, folder, "--quiet", *args, scene=text)
    assert pixels(folder, "view.exr") == shown, "the viewer changes the image"


@check
def a_missing_display_is_a_warning(tool, folder):
    with socket.socket() as s:  # a port where nobody listens
        s.bind(("127.0.0.1", 0))
        port = s.getsockname()[1]
        goes_on(tool, folder, "127.0.0.1:%d" % port, r"is not there")


@check
def a_display_host_without_a_name_is_a_warning(tool, folder):
    # Looking it up may take long where there is no network: rendering does not wait.
    goes_on(tool, folder, "no-such-host.invalid:14158", "cannot be found|does not take")


LARGE = 900, 700  # 7.5 MB of floats: more than the system keeps between two processes


@check
def a_display_that_does_not_read_is_a_warning(tool, folder):
    viewer = Viewer(reads=0)
    goes_on(tool, folder, viewer.address, "does not take the last image", text=scene(*LARGE, spp=1))
    viewer.finish()


@check
def a_display_that_stops_reading_is_a_warning(tool, folder):
    viewer = Viewer(reads=2)
    goes_on(tool, folder, viewer.address, "does not take the last image", text=scene(*LARGE, spp=1))
    viewer.finish()


@check
def a_display_that_goes_away_is_a_warning(tool, folder):
    viewer = Viewer(reads=1)
    viewer.closes = True
    goes_on(tool, folder, viewer.address, "went away", text=scene(*LARGE, spp=1))
    viewer.finish()


@check
def a_display_does_not_hinder_a_signal(tool, folder):
    viewer = Viewer(reads=0)
    started = time.monotonic()
    result = render(tool, folder, "--display-server", viewer.address, scene=scene(*LARGE, spp=100000), status=130,
                    signal_after=(tool.moment(1.5), signal.SIGINT))
    viewer.finish()
    assert time.monotonic() - started < 10 * (5 if tool.sanitized else 1), "took long: " + result.err
    assert left(folder) == ["view.exr"], left(folder)


@check
def a_quiet_render_does_not_speak_of_the_display(tool, folder):
    result = render(tool, folder, "--quiet", "--display-server", "127.0.0.1:1", scene=scene())
    assert not result.err and not result.out, result.err
