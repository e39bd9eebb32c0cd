"""One library for all tests that need one."""

import os
import signal

import pytest

import wzvi

KUBO = dict(
    drift="|q, p| 0.5 * a * (q * q + p * p)",
    noise="|q, p| 0.5 * sigma * (q * q + p * p)",
    embedding="Midpoint",
    invariant={"action": "|q, p| 0.5 * (q * q + p * p)"},
    parameters={"a": float, "sigma": float},
    observe={"radius": "|q, p| (q * q + p * p).sqrt()"},
    name="Kubo",
    doc="Kubo's oscillator: a rotation whose angle diffuses.",
    docs={"a": "Mean angular frequency.", "sigma": "Intensity of the noise."},
    want=("path", "ensemble", "sweep", "chaos"),
)
#: The same for paths alone, which compiles fastest.
SMALL = dict(KUBO, want=("path",))
RUN = dict(h=0.02, q=0.0, p=1.0)
#: How soon Ctrl-C has to end a run, in seconds: half a second on idle cores, more beside compilers.
SOON = 0.5 if "WZVI_IDLE" in os.environ else 2.0


@pytest.fixture(scope="session", autouse=True)
def interrupts():
    """Ctrl-C is heard, also where a shell began the tests in the background, which makes it deaf to it."""
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session", autouse=True)
def cache(tmp_path_factory):
    """A cache of its own for these tests, unless WZVI_CACHE names one that they may share with each other."""
    if "WZVI_CACHE" not in os.environ:
        folder = tmp_path_factory.mktemp("cache")
        folder.chmod(0o700)
        os.environ["WZVI_CACHE"] = str(folder)
        yield folder
        del os.environ["WZVI_CACHE"]
    else:
        yield os.environ["WZVI_CACHE"]


@pytest.fixture(scope="session")
def compiled(cache):
    """A system that this package compiled."""
    return wzvi.compile(**SMALL)


@pytest.fixture(scope="session")
def system(cache):
    """The system for runs: from the library of the example `systems` of wzvi-c, if WZVI_SYSTEMS names it."""
    library = os.environ.get("WZVI_SYSTEMS")
    return wzvi.load(library).Kubo if library else wzvi.compile(**KUBO)


@pytest.fixture(scope="session")
def kubo(system):
    return system(a=1.5, sigma=1.0)
