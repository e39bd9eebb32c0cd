"""Runs of one library: values, views, tables, errors, Ctrl-C, threads and processes."""

import _ctypes
import concurrent.futures
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from conftest import RUN, SOON

import wzvi

pytestmark = pytest.mark.compiled


def rss():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


linux = pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")


def test_bits_of_the_readme(kubo):
    path = kubo.simulate("Midpoint", until=20.0, noise="wong-zakai", width=0.02, seed=7, **RUN)
    assert (path.q[-1, 0], path.p[-1, 0]) == (0.8292530916848057, -0.5588732503271108)
    assert np.abs(path.energy - path.energy[0]).max() < 1e-13


def test_bits_of_the_rust_program():
    """`cargo build --release -p wzvi-c --features chaos --examples`, and WZVI_BITS=target/release/examples/bits."""
    program = os.environ.get("WZVI_BITS")
    if not program:
        pytest.skip("WZVI_BITS is the example `bits` of wzvi-c, with the library of the example `systems` beside it")
    expected = [int(each, 16) for each in subprocess.run([program], capture_output=True, text=True, check=True).stdout.split()]
    name = {"darwin": "libsystems.dylib", "win32": "systems.dll"}.get(sys.platform, "libsystems.so")
    library = wzvi.load(os.path.join(os.path.dirname(program), name))
    kubo = library.Kubo(a=1.5, sigma=1.0)
    path = kubo.simulate("Midpoint", until=2.0, noise="wiener", seed=7, **RUN)
    arrays = [path.q, path.p]
    for threads in (1, 2, 3):
        many = kubo.ensemble("Midpoint", until=2.0, paths=3000, seed=7, threads=threads, observe=["q", "radius"], **RUN)
        arrays += [many.mean, many.error]
    path = library.Pendulum(g=9.81).simulate("Midpoint", h=0.01, q=2.0, p=0.0, until=10.0)
    arrays += [path.q, path.p]
    network = library.Network(k=2.0, springs=[[0, 1], [1, 2], [2, 3], [3, 0]])
    path = network.simulate("Verlet", h=0.05, q=[1.0, 0.0, 0.0, 0.0], p=[0.0, 0.0, 0.0, 0.5], until=5.0)
    arrays += [path.q, path.p]
    got = np.concatenate([array.ravel() for array in arrays]).view(np.uint64)
    assert got.tolist() == expected


def test_given_increments_are_those_that_come_back(kubo):
    dw = np.random.default_rng(1).normal(size=100) * 0.1
    path = kubo.simulate(increments=dw, steps=100, **RUN)
    assert (path.dw[:, 0] == dw).all()
    assert np.abs(np.hypot(path.q[:, 0], path.p[:, 0]) - 1).max() < 1e-13 and path.q.shape == (101, 1)
    # The exact solution is a rotation by a t + σ W.
    fine = kubo.simulate(increments=np.repeat(dw, 10) / 10, steps=1000, h=0.002, q=0.0, p=1.0)
    assert abs(fine.q[-1, 0] - np.sin(1.5 * fine.t[-1] + dw.sum())) < 1e-3


def test_threads_do_not_change_a_bit(kubo):
    one, two = (kubo.ensemble(until=2.0, paths=5000, seed=7, threads=n, quantiles=[0.1, 0.5], **RUN) for n in (1, 2))
    for name in one:
        np.testing.assert_array_equal(one[name], two[name])


def test_a_sweep_is_its_systems(system):
    a = np.linspace(1.0, 2.0, 5)
    more = dict(until=1.0, keep_paths=True, observe=["q"], seed=1, record_every=0, **RUN)
    swept = system(a=a, sigma=0.0).ensemble(**more)
    for i, each in enumerate(a):
        single = system(a=each, sigma=0.0).ensemble(paths=1, **more)
        assert swept.paths[i, -1, 0] == single.paths[0, -1, 0]
    with pytest.raises(ValueError, match="sweep"):
        system(a=a, sigma=0.0).simulate(until=1.0, seed=1, **RUN)
    with pytest.raises(ValueError, match="as many"):
        system(a=a, sigma=np.zeros(4))


def test_starts_of_each_path(system):
    q = np.linspace(0.0, 1.0, 3)[:, None]
    many = system(a=1.0, sigma=0.0).ensemble(h=0.02, q=q, p=0 * q, until=1.0, keep_paths=True, observe=["q"], seed=1)
    for i in range(3):
        alone = system(a=1.0, sigma=0.0).simulate(h=0.02, q=q[i], p=0.0, until=1.0, seed=1)
        assert abs(many.paths[i, -1, 0] - alone.q[-1, 0]) < 1e-14


def test_statistics(kubo):
    many = kubo.ensemble(
        until=1.0, paths=20_000, seed=7, record_every=10, observe=["q", "radius"], quantiles=[0.05, 0.95], covariances=True,
        histograms={"q": (-1.1, 1.1, 22)}, passages=["p"], **RUN,
    )  # fmt: skip
    assert many.names == ["q", "radius"] and many.mean.shape == (len(many.t), 2)
    truth = np.exp(-0.5 * many.t) * np.sin(1.5 * many.t)
    assert np.abs(many.mean[1:, 0] - truth[1:]).max() < 5 * many.error[1:, 0].max()
    assert many.quantiles.shape == (len(many.t), 2, 2) and many["histogram.q"].shape == (len(many.t), 22) and many["edges.q"].shape == (23,)
    assert many["histogram.q"][-1].sum() == 20_000 and many["passage.p"].shape == (7,)
    assert many.covariance.shape == (len(many.t), 2, 2)
    frame = many.to_pandas()
    assert list(frame.columns)[:6] == ["t", "count", "lost", "q", "q error", "q variance"] and "q 5 %" in frame
    assert set(many.of("q")) >= {"mean", "error", "quantiles", "histogram", "edges"}
    assert "±" in repr(many) and "20000 paths" in repr(many) and "<table>" in many._repr_html_()


def test_observables_sections_frames(kubo):
    pandas = pytest.importorskip("pandas")
    path = kubo.simulate(until=20.0, seed=1, observe=["radius"], sections=["+q"], **RUN)
    assert np.abs(path["observed.radius"] - 1).max() < 1e-13
    assert np.abs(path["crossings.q"]).max() < 1e-12 and (path["crossings.direction"] == 1).all()
    assert set(path.group("crossings")) == {"section", "direction", "t", "q", "p"}
    names = ["t", "q", "p", "energy", "action", "radius"]
    frame = path.to_pandas()
    assert isinstance(frame, pandas.DataFrame) and list(frame.columns) == names and len(frame) == 1001
    assert path.steps == 1000 and "q" in dir(path) and "energy" in path and len(path.keys()) > 5


def test_frames_of_polars(kubo):
    polars = pytest.importorskip("polars")
    path = kubo.simulate(until=20.0, seed=1, observe=["radius"], **RUN)
    frame = path.to_polars()
    assert isinstance(frame, polars.DataFrame) and frame.columns == ["t", "q", "p", "energy", "action", "radius"]
    assert frame.height == 1001 and (frame["q"].to_numpy() == path.q[:, 0]).all()


def test_the_end_at_an_event(system):
    path = system(a=1.0, sigma=0.0).simulate(until=20.0, seed=1, end_at="-q", h=0.02, q=0.0, p=1.0)
    # Half a turn of the scheme, whose frequency is smaller by h²/12.
    assert abs(path.t[-1] / np.pi - 1.0 - 0.02**2 / 12) < 1e-6 and len(path["events.t"]) == 1


def test_descriptions(system, kubo):
    assert "Discrete" in system.equations() and "Discrete" in repr(system) and system.parameters == {"a": "f64", "sigma": "f64"}
    html = system._repr_html_()
    assert "Mean angular frequency." in html and "a rotation whose angle diffuses" in html and "order" in html and "Midpoint" in html
    assert "1.5" in kubo._repr_html_() and "Intensity of the noise." in system.__doc__
    assert str(__import__("inspect").signature(system)).startswith("(*, a:")
    assert repr(kubo) == "Kubo(a=1.5, sigma=1.0)" and repr(kubo.replace(a=2.0)) == "Kubo(a=2.0, sigma=1.0)"
    assert "<table>" in kubo.simulate(until=1.0, seed=1, **RUN)._repr_html_()


def test_chaos(kubo, system):
    quiet = system(a=1.0, sigma=0.0)
    more = dict(h=0.1, q=1.0, p=0.0, until=200.0, seed=1)
    found = quiet.indicators(record_every=10, **more)
    assert found.sali > 0 and len(found.columns()["t"]) > 100 and "MEGNO" in repr(found)
    found = quiet.lyapunov(copies=0, **more)
    assert found.exponents.shape == (2,) and np.abs(found.exponents).max() < 0.1 and "Exponents" in repr(found)
    found = quiet.map(h=0.1, q=[[0.5], [1.0], [2.0]], p=[[0.0]] * 3, until=100.0, seed=1)
    assert found.megno_mean.shape == (3,) and len(found.to_pandas()) == 3 and "3 paths" in repr(found)
    found = quiet.tangent(by="a", **{**more, "until": 1.0})
    angle = 1.0
    rotation = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    # The angle of the scheme differs by h²/12.
    assert np.abs(found.by_start - rotation).max() < 2e-3
    assert found.by == ["a"] and found.by_parameters.shape == (2, 1) and "d/da" in found.columns()
    assert pickle.loads(pickle.dumps(found)).by == ["a"] and len(found.to_pandas()) == 2


def test_errors_of_runs(kubo, system):
    with pytest.raises(TypeError, match="untill"):
        kubo.simulate("Midpoint", until=1.0, untill=2.0, **RUN)
    for settings, part in [(dict(seed=1), "until"), (dict(until=1.0), "noise"), (dict(until=1.0, seed=-1), "seed"), (dict(until=1.0, seed=1, observe=["z"]), "radius")]:
        with pytest.raises(wzvi.RunError, match=part) as caught:
            kubo.simulate("Midpoint", **RUN, **settings)
        assert caught.value.code and caught.value.partial is None
    with pytest.raises(wzvi.RunError, match="Verlet"):
        kubo.simulate("Verlet", until=1.0, seed=1, **RUN)
    with pytest.raises(wzvi.RunError, match="degree"):
        kubo.simulate(h=0.1, q=[0.0, 1.0], p=[1.0, 0.0], until=1.0, seed=1)
    for wrong, part in [(dict(a=1.0), "sigma"), (dict(a=1.0, sigma=1.0, b=1.0), "b"), (dict(a="x", sigma=1.0), "real")]:
        with pytest.raises(TypeError, match=part):
            system(**wrong)
    for wrong, part in [(dict(until="x"), "number"), (dict(steps=1.5), "integer"), (dict(until=1.0, observe=[1]), "name"), (dict(until=1.0, increments="x"), "numbers")]:
        with pytest.raises(TypeError, match=part):
            kubo.simulate(**{**RUN, "seed": 1, **wrong})
    with pytest.raises(wzvi.RunError) as caught:
        kubo.simulate(increments=[0.1, np.nan, 0.1], steps=3, **RUN)
    assert caught.value.partial is None or len(caught.value.partial.t) <= 2
    assert pickle.loads(pickle.dumps(caught.value)).code == caught.value.code


def test_steps_as_they_are_often_written(kubo):
    assert len(kubo.simulate(steps=1e2, seed=np.int64(1), **RUN).t) == 101


def test_null_is_an_error(system):
    functions = system.library._functions
    assert functions.run(None) == 2 and functions.results(None) == 0 and functions.error(None)
    functions.end(None), functions.stop(None)


def test_arrays_outlive_everything_and_are_views(kubo):
    q = kubo.simulate(until=20.0, seed=1, **RUN).q
    copy = q.copy()
    for _ in range(100):
        kubo.simulate(until=20.0, seed=2, **RUN)
    assert (q == copy).all() and not q.flags.writeable and not q.flags.owndata


@linux
def test_no_leak(kubo):
    def call(count):
        for seed in range(count):
            _ = kubo.simulate(steps=50, seed=seed, observe=["radius"], **RUN).q
            with pytest.raises(wzvi.RunError):
                kubo.simulate("None", steps=5, seed=seed, **RUN)

    call(1000)
    before = rss()
    call(10_000)
    assert rss() - before < 1 << 20, rss() - before


@linux
def test_no_leak_of_ensembles(kubo):
    def call(count):
        for seed in range(count):
            kubo.ensemble(steps=2, paths=64, seed=seed, observe=["q"], quantiles=[0.5], histograms={"q": (-1.0, 1.0, 20)}, **RUN)

    call(300)
    before = rss()
    call(1000)
    assert rss() - before < 2 << 20, rss() - before


@pytest.mark.parametrize("kind", ["ensemble", "path", "sweep", "map"])
def test_ctrl_c(kubo, system, kind):
    handler = signal.getsignal(signal.SIGINT)
    began = []

    def interrupt():
        began.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    threading.Timer(0.4, interrupt).start()
    with pytest.raises(wzvi.Interrupted) as caught:
        if kind == "ensemble":
            kubo.ensemble(until=20.0, paths=10**8, seed=1, **RUN)
        elif kind == "sweep":
            system(a=np.linspace(1.0, 2.0, 100_000), sigma=1.0).ensemble(until=2000.0, seed=1, **RUN)
        elif kind == "map":
            kubo.map(h=0.02, q=np.linspace(0.1, 1.0, 10_000)[:, None], p=np.zeros((10_000, 1)), until=2000.0, seed=1)
        else:
            kubo.simulate(steps=10**10, record_every=10**6, seed=1, **RUN)
    assert time.monotonic() - began[0] < SOON
    if kind in ("ensemble", "path"):
        assert caught.value.partial is not None
    assert signal.getsignal(signal.SIGINT) is handler
    kubo.simulate(until=1.0, seed=1, **RUN)


def test_the_gil_is_free_and_progress_is_told(kubo):
    seen, ticks, end = [], [0], threading.Event()

    def tick():
        while not end.is_set():
            ticks[0] += 1
            time.sleep(0.001)

    worker = threading.Thread(target=tick)
    worker.start()
    kubo.ensemble(until=20.0, paths=200_000, seed=1, progress=lambda done, of: seen.append((done, of)), **RUN)
    end.set()
    worker.join()
    assert ticks[0] > 20 and seen[-1] == (200_000, 200_000) and any(0 < done < of for done, of in seen)


def test_a_line_of_progress(kubo, capsys):
    kubo.ensemble(until=2.0, paths=50_000, seed=1, progress=True, **RUN)
    kubo.simulate(steps=1000, seed=1, progress=True, **RUN)
    said = capsys.readouterr().err
    assert "100.0 % of 50000 paths" in said and "100.0 % of 1000 steps" in said


def test_an_error_in_progress_stops_the_run(kubo):
    def fail(done, of):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        kubo.ensemble(until=20.0, paths=10**8, seed=1, progress=fail, **RUN)


def last(args):
    kubo, seed = args
    return float(kubo.simulate(until=2.0, seed=seed, **RUN).q[-1, 0])


@pytest.mark.parametrize("method", multiprocessing.get_all_start_methods())
def test_processes(kubo, method):
    expected = [last((kubo, seed)) for seed in range(8)]
    kubo.ensemble(until=2.0, paths=5000, seed=1, **RUN)
    with concurrent.futures.ProcessPoolExecutor(2, mp_context=multiprocessing.get_context(method)) as pool:
        assert list(pool.map(last, [(kubo, seed) for seed in range(8)])) == expected


def test_pickles(kubo):
    path = kubo.simulate(until=2.0, seed=1, sections=["q"], **RUN)
    again = pickle.loads(pickle.dumps(path))
    assert (again.q == path.q).all() and repr(again.system) == repr(kubo) and again.keys() == path.keys()
    assert again.to_pandas().equals(path.to_pandas()) and repr(again) == repr(path)
    many = kubo.ensemble(until=2.0, paths=100, seed=1, **RUN)
    assert repr(pickle.loads(pickle.dumps(many))) == repr(many)


def test_threads_of_python_run_beside_each_other(kubo):
    expected = [last((kubo, seed)) for seed in range(16)]
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        assert list(pool.map(last, [(kubo, seed) for seed in range(16)])) == expected


def test_libraries(system, kubo):
    library = wzvi.load(system.library.path)
    assert "Kubo" in list(library) and repr(library.Kubo(a=1.5, sigma=1.0)) == repr(kubo) and "Kubo" in dir(library)
    with pytest.raises(AttributeError, match="Kubo"):
        _ = library.Orbit
    with pytest.raises(KeyError, match="Kubo"):
        library["Orbit"]
    with pytest.raises(wzvi.Error, match="wzvi_table"):
        wzvi.load(_ctypes.__file__)
    with pytest.raises(wzvi.Error, match="no library"):
        wzvi.load("/nowhere/at/all.so")




def test_a_damaged_library_is_refused(tmp_path):
    (tmp_path / "broken.so").write_bytes(b"no library")
    with pytest.raises(wzvi.Error, match="cannot be loaded"):
        wzvi.load(tmp_path / "broken.so")


@pytest.mark.slow
def test_a_call_takes_100_us(kubo):
    def call():
        return kubo.simulate(steps=1, seed=1, **RUN).q

    times = []
    for _ in range(50):
        began = time.perf_counter()
        for _ in range(100):
            call()
        times.append((time.perf_counter() - began) / 100)
    # The best of many, since others may be at work beside.
    assert min(times) < 100e-6, min(times)


def test_antithetic_pairs_have_the_exact_mean_of_odd_observables(kubo):
    """The step is a rotation by an angle that is odd in the noise but for its mean: q is odd in the noise where a = 0."""
    still = kubo.replace(a=0.0)
    many = still.ensemble(until=1.0, paths=100, seed=3, antithetic=True, observe=["q", "p"], **RUN)
    assert abs(many.mean[-1, 0]) < 1e-15 and many.error[-1, 0] < 1e-15 and many.error[-1, 1] > 1e-3
