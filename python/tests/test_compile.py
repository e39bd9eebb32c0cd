"""What the compiler says of mistakes, at the place of the user. All of these share the crates of the one library."""

import os
import subprocess
import sys
import time

import pytest
from conftest import RUN, SMALL, SOON

import wzvi

pytestmark = pytest.mark.compiled

HALF = "|q, p| 0.5 * p * p"
WELL = HALF + " + q.cos()"
A = {"a": float}
#: The places of mistakes: argument, line, column, width.
WRONG = [
    (dict(drift="|q, p| 0.5 * a * (q * q + p * p) +\n    b * q", parameters=A), ("drift", 2, 5, 1)),
    (dict(drift=HALF + " + q.coz()"), ("drift", 1, 24, 3)),
    (dict(drift=HALF + " + q.cos(1.0)"), ("drift", 1, 24, 3)),
    (dict(drift=HALF + " + rand(q)"), ("drift", 1, 22, 4)),
    (dict(drift=HALF + " + { let mut i = 0; while i < 3 { i += 1; } q }"), ("drift", 1, 39, 5)),
    (dict(drift=HALF + " + a[0]", parameters=A), ("drift", 1, 22, 1)),
    (dict(drift=HALF + ' + "text"'), ("drift", 1, 22, 6)),
    (dict(drift=HALF + " + ;"), ("drift", 1, 22, 1)),
    (dict(drift=HALF + " +  5"), ("drift", 1, 23, 1)),
    (dict(drift=HALF + " + q as f32"), ("drift", 1, 27, 3)),
    (dict(drift=HALF + " + if q > 0.0 { q }"), ("drift", 1, 22, 2)),
    (dict(drift="|q| 0.5 * q"), ("drift", 1, 1, 3)),
    (dict(drift="|[x, y], [px]| 0.5 * px * px"), ("drift", 1, 10, 4)),
    (dict(drift=WELL, noise=["|q, p| a * q", "|q, p|\n  a * z"], parameters=A), ("noise[1]", 2, 7, 1)),
    (dict(drift=WELL, invariant="|q, p| q * p"), ("invariant", 1, 8, 5)),
    (dict(drift=WELL, invariant={"none": "|q, p| q * p"}), ("invariant['none']", 1, 8, 5)),
    (dict(drift=WELL, observe={"radius": "|q, p| (q * r).sqrt()"}), ("observe['radius']", 1, 13, 1)),
    (dict(drift=WELL, embedding="Midpoind"), ("embedding", 1, 1, 8)),
    (dict(drift=WELL, noise="|q, p| q * q * p", embedding="DeltaPlus"), ("embedding", 1, 1, 9)),
    (dict(drift=WELL, schemes="Composed<Verlet, KahanLi8>"), ("schemes", 1, 1, 26)),
    (dict(drift=WELL, friction="gamma"), ("friction", 1, 1, 5)),
    (dict(drift=WELL, temperature="a", parameters=A), ("temperature", 1, 1, 1)),
    (dict(drift=WELL, calculus="Itoo"), ("calculus", 1, 1, 4)),
    (dict(drift=WELL, parameters={"a": "Strin"}), ("parameters['a']", 1, 1, 5)),
    (dict(drift="|[x, y], [px, py]| 0.5 * px * px", force="|[x, y], [px, py]| [x]"), ("force", 1, 20, 3)),
]


@pytest.mark.parametrize(("keys", "place"), WRONG)
def test_mistakes_have_their_place(compiled, keys, place):
    with pytest.raises(wzvi.CompileError) as caught:
        wzvi.compile(**{"embedding": "Midpoint", "want": SMALL["want"], **keys})
    messages = caught.value.messages
    assert messages[0][1:5] == place
    # No message without a place beside one that has one.
    assert all(message.argument is not None for message in messages)
    text = str(caught.value)
    assert text.count("\n  --> ") >= text.count("\n\n") + 1 and "Exported" not in text and "wzvi_system" not in text


def test_mistakes_name_the_term_of_sympy(compiled):
    sympy = pytest.importorskip("sympy")
    x, p, k = sympy.symbols("x p k")
    with pytest.raises(wzvi.CompileError) as caught:
        wzvi.compile(p**2 / 2 + k * x + x**4, q=x, p=p, parameters={"k": "Vec<f64>"}, embedding="Midpoint", want=SMALL["want"])
    (message,) = caught.value.messages
    assert message.term == "k*x" and message.argument == "drift" and "the term `k*x`" in str(caught.value)


def test_a_mistake_takes_half_a_second(compiled):
    times = []
    for number in range(3):
        began = time.monotonic()
        with pytest.raises(wzvi.CompileError):
            wzvi.compile(f"{HALF} + {number}.0 * b", embedding="Midpoint", want=SMALL["want"])
        times.append(time.monotonic() - began)
    # 0.25 s on idle cores; others may be at work beside.
    assert min(times) < 1.0


def python(text, **more):
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([os.path.dirname(os.path.dirname(wzvi.__file__)), os.path.dirname(__file__)])}
    return subprocess.Popen([sys.executable, "-c", text], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env={**environment, **more})


def test_the_second_compile_is_at_once(compiled):
    assert wzvi.compile(**SMALL) is compiled


def test_without_rust_a_compiled_system_is_there(compiled):
    program = python("import wzvi, conftest; print(wzvi.compile(**conftest.SMALL).library.path)", PATH="", CARGO_HOME="/nowhere")
    out, err = program.communicate()
    assert out.strip() == compiled.library.path, err


def test_systems_of_pickles_are_compiled_again_where_they_are_gone(compiled, tmp_path):
    import pickle

    (tmp_path / "system").write_bytes(pickle.dumps(compiled))
    # Another cache without cargo: the library is missing there, and the sentence says what it would need.
    program = python(
        f"import pickle, os, wzvi; os.path.exists = lambda path: False; pickle.load(open({str(tmp_path / 'system')!r}, 'rb'))",
        PATH="", CARGO_HOME="/nowhere", WZVI_CACHE=str(tmp_path / "cache"), HOME="/nowhere",
    )  # fmt: skip
    _, err = program.communicate()
    assert "install Rust 1.89 or newer" in err


@pytest.mark.slow
def test_processes_that_compile_the_same_at_once(compiled):
    text = "import wzvi; k = wzvi.compile('|q, p| 0.5 * p * p - 1.1 * q.cos()', embedding='Verlet', want='path'); print(k.library.path)"
    both = [python(text) for _ in range(2)]
    said = [each.communicate() for each in both]
    assert all(each.returncode == 0 for each in both), said
    assert said[0][0] == said[1][0] and os.path.exists(said[0][0].strip())


@pytest.mark.slow
def test_a_process_that_is_killed_leaves_a_cache_that_works(compiled):
    text = "import wzvi; k = wzvi.compile('|q, p| 0.5 * p * p - 1.2 * q.cos()', embedding='Verlet', want='path'); print(k.library.path)"
    for pause in (0.3, 1.0):
        first = python(text)
        time.sleep(pause)
        first.kill()
        first.communicate()
    second = python(text)
    out, err = second.communicate()
    assert second.returncode == 0 and os.path.exists(out.strip()), err


@pytest.mark.slow
def test_ctrl_c_in_compile(compiled):
    import signal
    import threading

    began = []

    def interrupt():
        began.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    threading.Timer(1.5, interrupt).start()
    with pytest.raises(KeyboardInterrupt):
        wzvi.compile("|[x, y], [px, py]| 0.5 * (px * px + py * py) + 0.25 * (x * x * y).cos()", embedding=["Verlet", "Midpoint", "Gauss<4>"])
    assert time.monotonic() - began[0] < SOON
    assert compiled(a=1.0, sigma=0.0).simulate(until=1.0, seed=1, **RUN).steps == 50


@pytest.mark.slow
def test_systems_of_all_kinds(compiled):
    sympy = pytest.importorskip("sympy")
    import numpy as np

    x, y, px, py, k, t, e = sympy.symbols("x y px py k t e")
    kepler = wzvi.compile(
        (px**2 + py**2) / 2 - k / sympy.sqrt(x**2 + y**2), q=[x, y], p=[px, py], embedding="Verlet", schemes="Composed<Verlet, KahanLi8>",
        invariant={"momentum": x * py - y * px}, observe={"r": sympy.sqrt(x**2 + y**2)}, name="Kepler", want="path",
    )  # fmt: skip
    path = kepler(k=1.0).simulate("Composed<Verlet, KahanLi8>", h=0.1, q=[1.0, 0.0], p=[0.0, 1.0], until=2 * np.pi, observe=["r"])
    assert abs(path.q[-1, 0] - 1.0) < 1e-5 and np.abs(path["invariant.momentum"] - 1.0).max() < 1e-13
    assert list(path.columns()) == ["t", "x", "y", "px", "py", "energy", "momentum", "r"]
    with pytest.raises(wzvi.RunError, match="want=.*'ensemble'"):
        kepler(k=1.0).ensemble("Verlet", h=0.1, q=[1.0, 0.0], p=[0.0, 1.0], until=1.0, paths=10)
    with pytest.raises(wzvi.RunError, match="want=.*'chaos'"):
        kepler(k=1.0).lyapunov("Verlet", h=0.1, q=[1.0, 0.0], p=[0.0, 1.0], until=1.0)
    driven = wzvi.compile(px**2 / 2 + x**2 / 2 - e * x * sympy.cos(t), q=x, p=px, t=t, friction=k, embedding="Verlet", name="Driven", want="path")
    assert driven(e=0.1, k=0.1).simulate(h=0.05, q=0.0, p=0.0, until=10.0).steps == 200
    springs = wzvi.compile(
        "|q: &[f64], p: &[f64]| p.iter().map(|p| 0.5 * p * p).sum::<f64>() + (0..self.bonds.len()).map(|b| { let d = q[self.bonds[b][0]] - q[self.bonds[b][1]]; 0.5 * k * d * d }).sum::<f64>()",
        parameters={"bonds": "Vec<[usize; 2]>", "k": float}, embedding="Verlet", name="Springs", want="path",
    )  # fmt: skip
    path = springs(bonds=[[0, 1], [1, 2]], k=1.0).simulate(h=0.1, q=[0.0, 0.1, 0.0], p=np.zeros(3), until=10.0)
    assert path.q.shape == (101, 3) and list(path.columns())[1] == "q[0]"
    clocked = wzvi.compile(
        "|[x, y], [px, py]| 0.5 * (px * px + py * py) - k / (x * x + y * y).sqrt()", clock="curvature", embedding="Clocked<Verlet>",
        parameters={"k": float}, name="Orbit", want="path",
    )  # fmt: skip
    path = clocked(k=1.0).simulate("Clocked<Verlet>", eps=0.1, q=[0.1, 0.0], p=[0.0, 19.0**0.5], until=6.0)
    assert "intervals.h" in path and path["intervals.h"].min() < 0.1 * path["intervals.h"].max()


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="mounts a small disk")
def test_a_full_disk_leaves_a_cache_that_works(tmp_path, monkeypatch):
    disk = tmp_path / "disk"
    disk.mkdir(mode=0o700)
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=40m,mode=700", "tmpfs", disk], capture_output=True, check=False).returncode:
        pytest.skip("may not mount")
    try:
        monkeypatch.setenv("WZVI_CACHE", str(disk))
        well = dict(drift=HALF + " - 1.3 * q.cos()", embedding="Verlet", want="path")
        with pytest.raises(wzvi.Error, match="is full.*WZVI_CACHE"):
            wzvi.compile(**well)
        assert not [each for each in os.listdir(disk) if each.endswith(".so") or each.startswith("crate-")]
        subprocess.run(["mount", "-o", "remount,size=2g", disk], check=True)
        assert wzvi.compile(**well)().simulate(h=0.1, q=0.1, p=0.0, until=1.0).steps == 10
    finally:
        subprocess.run(["umount", "-l", disk], check=False)
