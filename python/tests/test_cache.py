"""The cache and what stands around cargo, without a compiler: programs that say what cargo would."""

import errno
import os
import re
import signal
import stat
import subprocess
import sys
import textwrap
import threading
import time
from pathlib import Path

import pytest
from conftest import SOON

import wzvi
from wzvi import _build, _cache, _source

posix = pytest.mark.skipif(os.name != "posix", reason="needs POSIX")
PYTHON = sys.executable
VERSION = "rustc 1.95.0\nrelease: 1.95.0\nhost: x86_64-unknown-linux-gnu\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    tmp_path.chmod(0o700)
    cache = tmp_path / "cache"
    monkeypatch.setenv("WZVI_CACHE", str(cache))
    return cache


@pytest.fixture
def sources(monkeypatch):
    monkeypatch.setattr(_build, "sources", lambda: _build.Sources(Path("/nowhere"), "mark", None, None, False))


def program(path, text):
    path.write_text(f"#!{PYTHON}\n" + textwrap.dedent(text))
    path.chmod(0o700)
    return path


@pytest.fixture
def tools(tmp_path, monkeypatch, sources):
    """A folder of programs in place of those of Rust."""
    tools = tmp_path / "tools"
    tools.mkdir()
    program(tools / "rustc", f"print({VERSION!r})")
    program(tools / "cc", "")
    monkeypatch.setenv("PATH", str(tools))
    monkeypatch.setenv("CARGO_HOME", str(tmp_path / "none"))
    monkeypatch.delenv("RUSTC", raising=False)
    monkeypatch.setattr(sys, "executable", str(tmp_path / "bin" / "python"))
    return tools


def compile(text="|q, p| q * p", **more):
    return wzvi.compile(text, embedding="Midpoint", **more)


@posix
def test_a_folder_of_others_is_refused(folder):
    folder.mkdir(mode=0o777)
    folder.chmod(0o777)
    with pytest.raises(wzvi.Error, match="WZVI_CACHE"):
        compile()
    folder.chmod(0o770)
    with pytest.raises(wzvi.Error, match="others"):
        _cache.folder()
    folder.chmod(0o755)
    assert _cache.folder() == folder


@posix
def test_a_new_folder_is_its_users_alone(folder):
    assert stat.S_IMODE(_cache.folder().stat().st_mode) & 0o077 == 0


def test_a_folder_that_cannot_be(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("WZVI_CACHE", str(tmp_path / "file" / "cache"))
    with pytest.raises(wzvi.Error, match="WZVI_CACHE"):
        _cache.folder()


@posix
def test_without_cargo(folder, tools):
    with pytest.raises(wzvi.Error, match=re.escape("install Rust 1.89 or newer: https://rustup.rs, or `pip install wzvi[rust]`, or load()")):
        compile()


@posix
def test_an_old_compiler(folder, tools):
    program(tools / "rustc", "print('release: 1.75.0')")
    program(tools / "cargo", "")
    with pytest.raises(wzvi.Error, match="Rust 1.75 is too old"):
        compile()


def message(text):
    return {"reason": "compiler-message", "message": {"level": "error", "message": text, "rendered": text, "spans": [], "children": []}}


@posix
@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("linker `cc` not found", "no linker.*ziglang"),
        ("failed to write: No space left on device (os error 28)", "disk of the cache .* is full"),
        ("cannot find type `Midpoind` in this scope", "Midpoind"),
    ],
)
def test_what_cargo_says(folder, tools, text, said):
    program(tools / "cargo", f"import json\nprint(json.dumps({message(text)!r}))\nraise SystemExit(101)")
    with pytest.raises(wzvi.Error, match=said):
        compile()
    assert not list(folder.glob("crate-*")) and not list(folder.glob("*.so"))


@posix
def test_cargo_that_fails_by_itself(folder, tools):
    program(tools / "cargo", "import sys\nsys.stderr.write('error: no matching package named `wzvi`')\nraise SystemExit(101)")
    with pytest.raises(wzvi.Error, match="no matching package"):
        compile()


@posix
def test_a_linker_is_found(folder, tools, monkeypatch):
    variable = "CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_LINKER"
    assert variable not in _build.environment_for(folder, VERSION)
    (tools / "cc").unlink()
    monkeypatch.setattr(_build.importlib.util, "find_spec", lambda name: None)
    assert variable not in _build.environment_for(folder, VERSION)
    folder.mkdir()
    monkeypatch.setattr(_build.importlib.util, "find_spec", lambda name: name == "ziglang" or None)
    wrapper = Path(_build.environment_for(folder, VERSION)[variable])
    assert wrapper.read_text().endswith('-m ziglang cc "$@"\n') and os.access(wrapper, os.X_OK)
    program(tools / "clang", "")
    assert _build.environment_for(folder, VERSION)[variable] == str(tools / "clang")


@posix
def test_a_full_disk_leaves_nothing(folder, tools, monkeypatch):
    program(tools / "cargo", "")

    def full(*_, **__):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(_cache.os, "replace", full)
    with pytest.raises(wzvi.Error, match="is full"):
        compile()
    assert not list(folder.glob("crate-*")) and not list(folder.glob("*.so"))


def test_a_library_is_there_as_a_whole_or_not_at_all(tmp_path, monkeypatch):
    built = tmp_path / "built"
    built.write_bytes(b"library")
    _cache.put(built, tmp_path / "finished")
    assert (tmp_path / "finished").read_bytes() == b"library"

    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(_cache.os, "fsync", full)
    with pytest.raises(OSError):
        _cache.put(built, tmp_path / "second")
    assert sorted(each.name for each in tmp_path.iterdir()) == ["built", "finished"]


def test_what_is_stale_is_swept(tmp_path):
    ages = [("crate-old", 2 * _cache.STALE), ("crate-new", 1.0), ("crate", 2 * _cache.STALE), ("target/old", 2 * _cache.UNUSED), ("target/new", 1.0)]
    for name, age in ages:
        (tmp_path / name).mkdir(parents=True)
        (tmp_path / name / "file").write_text("")
        then = time.time() - age
        os.utime(tmp_path / name, (then, then))
    _cache.sweep(tmp_path)
    assert sorted(each.name for each in tmp_path.iterdir()) == ["crate", "crate-new", "target"]
    assert [each.name for each in (tmp_path / "target").iterdir()] == ["new"]


def test_clear_cache(folder):
    base = _cache.folder()
    (base / "target").mkdir()
    (base / "target" / "file").write_bytes(b"12345")
    (base / "some.so").write_bytes(b"123")
    assert wzvi.clear_cache() == 8 and sorted(each.name for each in base.iterdir()) == ["lock"]
    assert wzvi.clear_cache() == 0


def test_keys_depend_on_what_matters(monkeypatch):
    crate = _source.Crate("text", ())
    key = _build.key_of(crate, ["ensemble"], 3, 16, "mark")
    others = [
        _build.key_of(_source.Crate("texts", ()), ["ensemble"], 3, 16, "mark"),
        _build.key_of(crate, [], 3, 16, "mark"),
        _build.key_of(crate, ["ensemble"], 2, 16, "mark"),
        _build.key_of(crate, ["ensemble"], 3, 16, "marks"),
    ]
    monkeypatch.setenv("RUSTFLAGS", "-Ctarget-cpu=native")
    others.append(_build.key_of(crate, ["ensemble"], 3, 16, "mark"))
    assert len({key, *others}) == 6


def test_features():
    assert _build.features(("path",)) == [] and _build.features("sweep") == ["ensemble", "sweep"]
    assert _build.features(["chaos", "path", "ensemble"]) == ["ensemble", "chaos"]


@posix
def test_ctrl_c_ends_cargo_and_what_it_started(folder, tools, tmp_path):
    # A cargo that starts a compiler and waits; both write down who they are.
    program(
        tools / "cargo",
        f"""
        import os, subprocess, sys, time
        child = subprocess.Popen(['/bin/sh', '-c', 'trap "" TERM; exec sleep 60'])
        open({str(tmp_path / "pids")!r}, 'w').write(f'{{os.getpid()}} {{child.pid}}')
        time.sleep(60)
        """,
    )

    def interrupt():
        while not (tmp_path / "pids").exists() or not (tmp_path / "pids").read_text():
            time.sleep(0.01)
        began.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    began = []
    os.environ["PATH"] += ":/bin:/usr/bin"
    handler = signal.getsignal(signal.SIGINT)
    threading.Thread(target=interrupt).start()
    with pytest.raises(KeyboardInterrupt):
        compile()
    assert time.monotonic() - began[0] < SOON
    assert signal.getsignal(signal.SIGINT) is handler
    for pid in map(int, (tmp_path / "pids").read_text().split()):
        for _ in range(100):
            if not alive(pid):
                break
            time.sleep(0.01)
        assert not alive(pid)
    # The lock is free, and nothing is half there.
    assert not list(folder.glob("crate-*"))
    program(tools / "cargo", "raise SystemExit(101)")
    with pytest.raises(wzvi.Error, match="cargo failed"):
        compile()


def alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


@posix
def test_the_lock_of_a_process_that_is_killed_is_free(folder):
    base = _cache.folder()
    text = f"import time; from pathlib import Path; from wzvi._cache import locked\nwith locked(Path({str(base)!r})):\n    print('locked', flush=True); time.sleep(60)"
    environment = {**os.environ, "PYTHONPATH": str(Path(wzvi.__file__).parents[1])}
    holder = subprocess.Popen([PYTHON, "-c", text], stdout=subprocess.PIPE, env=environment)
    assert holder.stdout.readline() == b"locked\n"
    entered = threading.Event()

    def enter():
        with _cache.locked(base):
            entered.set()

    threading.Thread(target=enter, daemon=True).start()
    assert not entered.wait(0.2)
    holder.kill()
    assert entered.wait(2.0)
    holder.wait()


@posix
def test_versions_of_a_package_share_no_builds(folder, tools, monkeypatch):
    program(tools / "cargo", "import sys\nsys.stderr.write('--target-dir ' + sys.argv[-1])\nraise SystemExit(101)")
    for mark, is_package, name in [("a" * 64, True, "a" * 16), ("b" * 64, True, "b" * 16), ("c" * 64, False, "checkout")]:
        monkeypatch.setattr(_build, "sources", lambda: _build.Sources(Path("/nowhere"), mark, None, None, is_package))
        with pytest.raises(wzvi.Error, match=f"target.{name}"):
            compile()


def test_sources_that_are_missing(tmp_path, monkeypatch):
    monkeypatch.setenv("WZVI_SOURCES", str(tmp_path))
    with pytest.raises(wzvi.Error, match="WZVI_SOURCES"):
        _build.sources()
