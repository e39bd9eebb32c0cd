"""One library for all tests that need one."""

import os

import pytest

import wzvi

KUBO = dict(
    drift="|q, p| 0.5 * a * (q * q + p * p)",
    noise="|q, p| 0.5 * sigma * (q * q + p * p)",
    embedding="Midpoint",
    invariant={"action": "|q, p| q * q + p * p"},
    parameters={"a": float, "sigma": float},
    observe={"radius": "|q, p| (q * q + p * p).sqrt()"},
    name="Kubo",
    doc="An oscillator of random frequency.",
    docs={"a": "The mean frequency.", "sigma": "The noise of the frequency."},
    want=("path", "ensemble", "sweep", "chaos"),
)
RUN = dict(h=0.02, q=0.0, p=1.0)


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
def system(cache):
    return wzvi.compile(**KUBO)


@pytest.fixture(scope="session")
def kubo(system):
    return system(a=1.5, sigma=1.0)
