# What the tests of the module share. Options: --lacquer PROGRAM, --scenes FOLDER.
import os
import signal

import pytest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")


# What a shell runs in the background ignores interrupts, and the tests that send one would never end.
signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_addoption(parser):
    parser.addoption("--lacquer", default=os.path.join(ROOT, "build/release/src/cmd/lacquer"))


@pytest.fixture(scope="session")
def program(request):
    return os.path.abspath(request.config.getoption("--lacquer"))


@pytest.fixture(scope="session")
def scenes():
    return os.path.join(ROOT, "scenes")
