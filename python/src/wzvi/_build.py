"""Cargo on the crate of a system, and the cache of what comes out."""

from __future__ import annotations

import hashlib
import importlib.util
import json
import os
import platform
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple, Optional

from . import _cache
from ._errors import NO_CARGO, NO_LINKER, NO_SOURCES, OLD_RUST, OLDEST_RUST, CompileError, Error, Message, pointed
from ._progress import Line, in_notebook
from ._source import Crate, Origin

#: Of the crates that are written; libraries of another version are compiled again.
VERSION = 1
HERE = Path(__file__).parent
FEATURES = ("ensemble", "sweep", "chaos")
CRATES = ("src", "wzvi-macros", "wzvi-runtime", "wzvi-c")

MANIFEST = """[package]
name = "wzvi-system"
version = "0.0.0"
edition = "2024"
publish = false
[lib]
path = "lib.rs"
crate-type = ["cdylib"]
[dependencies]
wzvi = {{ path = {wzvi}, default-features = false, features = ["ensemble"] }}
wzvi-c = {{ path = {wzvi_c}, default-features = false, features = {features} }}
[profile.release]
opt-level = {opt}
codegen-units = {units}
debug = 0
strip = "debuginfo"
panic = "unwind"
[workspace]
"""


class Sources(NamedTuple):
    """The Rust sources of wzvi."""

    folder: Path
    #: Of their content: a constant in a wheel.
    fingerprint: str
    #: Crates of others, or None where they come from the registry.
    vendor: Optional[Path]
    #: The versions that the vendored crates have.
    lock: Optional[Path]
    #: Whether they belong to this package, and never change.
    is_package: bool


def sources() -> Sources:
    """Those of WZVI_SOURCES, of this package, or of the repository that this package is in."""
    chosen = os.environ.get("WZVI_SOURCES")
    inside = HERE / "_sources"
    if not chosen and (inside / "FINGERPRINT").exists():
        vendor, lock = inside / "vendor", inside / "wzvi-system.lock"
        mark = (inside / "FINGERPRINT").read_text(encoding="ascii").strip()
        return Sources(inside, mark, vendor if vendor.is_dir() else None, lock if lock.exists() else None, True)
    folder = Path(chosen).absolute() if chosen else HERE.parents[2] if len(HERE.parents) > 2 else HERE
    if not (folder / "wzvi-c" / "Cargo.toml").exists():
        raise Error(NO_SOURCES if not chosen else f"WZVI_SOURCES is {folder}, where no sources of wzvi are")
    return Sources(folder, _stats(folder), None, None, False)


def _stats(folder: Path) -> str:
    """Names, sizes and times of all sources: reading them would take longer."""
    found = []
    for crate in CRATES:
        for file in sorted((folder / crate).rglob("*.rs")):
            status = file.stat()
            found.append(f"{file.relative_to(folder)} {status.st_size} {status.st_mtime_ns}")
    return hashlib.sha256("\n".join(found).encode()).hexdigest()


def features(want: Iterable[str]) -> list[str]:
    """Features of wzvi-c from kinds of runs."""
    wanted = [want] if isinstance(want, str) else list(want)
    for each in wanted:
        if each != "path" and each not in FEATURES:
            raise ValueError(f"want has {each!r}: there are 'path' (always), {', '.join(map(repr, FEATURES))}")
    found = {each for each in wanted if each != "path"}
    if "sweep" in found:
        found.add("ensemble")
    return [each for each in FEATURES if each in found]


def key_of(crate: Crate, chosen: list[str], opt: int, units: int, fingerprint: str) -> str:
    """Names a library by all that it depends on. Not by the compiler: a library of another one is as good."""
    parts = [
        str(VERSION),
        crate.text,
        ",".join(chosen),
        f"{opt} {units}",
        fingerprint,
        os.environ.get("RUSTFLAGS", ""),
        sys.platform,
        platform.machine(),
        # A library of a newer libc does not load with an older one, where several machines share a home.
        "".join(platform.libc_ver()) if sys.platform == "linux" else "",
    ]
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:32]


def build(crate: Crate, *, want: Iterable[str], opt: int, units: int, name: str, progress: Optional[bool], check: Callable[[Path], None]) -> Path:
    """The library of this crate: from the cache, or by cargo. `check` raises if a library of the cache does not load."""
    chosen = features(want)
    folder = _cache.folder()
    found = sources()
    finished = folder / f"{key_of(crate, chosen, opt, units, found.fingerprint)}{_cache.SUFFIX}"
    if finished.exists():
        try:
            check(finished)
            return finished
        except Error:
            # Damaged, by a full disk or by hand: it is made again.
            finished.unlink(missing_ok=True)
    cargo = find("cargo")
    if cargo is None:
        raise Error(NO_CARGO)
    with _cache.locked(folder):
        if not finished.exists():
            _make(cargo, folder, crate, chosen, opt, units, found, finished, name, progress)
    check(finished)
    return finished


def find(program: str) -> Optional[str]:
    """A program of Rust: on the path, beside this Python (`pip install rustup`), or where rustup puts it."""
    found = shutil.which(program)
    if found:
        return found
    places = [Path(sys.executable).parent, Path(os.environ.get("CARGO_HOME") or Path.home() / ".cargo") / "bin"]
    for place in places:
        found = shutil.which(program, path=str(place))
        if found:
            return found
    return None


def rust_version(cargo: str) -> str:
    """What `rustc -vV` says."""
    rustc = os.environ.get("RUSTC") or find("rustc") or str(Path(cargo).with_name("rustc"))
    try:
        return subprocess.run([rustc, "-vV"], capture_output=True, text=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError) as error:
        said = getattr(error, "stderr", "") or str(error)
        raise Error(f"rustc does not start ({said.strip()}): {NO_CARGO.split(': ', 1)[1]}") from error


def environment_for(folder: Path, version: str) -> dict[str, str]:
    """The environment of cargo, with a linker where the machine has none."""
    release = re.search(r"release: (\d+)\.(\d+)", version)
    if release and (int(release[1]), int(release[2])) < OLDEST_RUST:
        raise Error(OLD_RUST.format(found=f"{release[1]}.{release[2]}"))
    environment = {**os.environ, "CARGO_TERM_COLOR": "never"}
    # What belongs to a build that this program may be a part of.
    for inherited in ("CARGO_TARGET_DIR", "CARGO_BUILD_TARGET", "CARGO_ENCODED_RUSTFLAGS", "RUSTC_WRAPPER_LOG"):
        environment.pop(inherited, None)
    host = re.search(r"host: (\S+)", version)
    if sys.platform == "win32" or not host or shutil.which("cc"):
        return environment
    variable = f"CARGO_TARGET_{host[1].upper().replace('-', '_')}_LINKER"
    if variable in environment:
        return environment
    linker = shutil.which("gcc") or shutil.which("clang") or zig(folder)
    if linker:
        environment[variable] = linker
    return environment


def zig(folder: Path) -> Optional[str]:
    """A program of one line that links by `python -m ziglang cc`, if ziglang is installed."""
    if importlib.util.find_spec("ziglang") is None:
        return None
    wrapper = folder / "zig-cc"
    quoted = "'" + sys.executable.replace("'", "'\\''") + "'"
    _cache.write(wrapper, f'#!/bin/sh\nexec {quoted} -m ziglang cc "$@"\n')
    wrapper.chmod(0o700)
    return str(wrapper)


def _make(
    cargo: str,
    folder: Path,
    crate: Crate,
    chosen: list[str],
    opt: int,
    units: int,
    found: Sources,
    finished: Path,
    name: str,
    progress: Optional[bool],
) -> None:
    try:
        _cache.sweep(folder)
        environment = environment_for(folder, rust_version(cargo))
        # One folder for all crates: with a name of its own for each, cargo would keep every system that ever was.
        home = folder / "crate"
        (home / ".cargo").mkdir(parents=True, exist_ok=True)
        manifest = MANIFEST.format(
            wzvi=json.dumps(str(found.folder)),
            wzvi_c=json.dumps(str(found.folder / "wzvi-c")),
            features=json.dumps(chosen),
            opt=opt,
            units=units,
        )
        _cache.write(home / "Cargo.toml", manifest)
        _cache.write(home / "lib.rs", crate.text)
        offline = []
        if found.vendor is not None:
            vendored = f'[source.crates-io]\nreplace-with = "vendored"\n[source.vendored]\ndirectory = {json.dumps(str(found.vendor))}\n'
            _cache.write(home / ".cargo" / "config.toml", vendored)
            offline = ["--offline"]
        else:
            (home / ".cargo" / "config.toml").unlink(missing_ok=True)
        if found.lock is not None:
            _cache.write(home / "Cargo.lock", found.lock.read_text(encoding="utf-8"))
        # Sources of a package may have any times, by which cargo would judge whether they changed: each version has its own folder.
        target = folder / "target" / (found.fingerprint[:16] if found.is_package else "checkout")
        target.mkdir(parents=True, exist_ok=True)
        os.utime(target)
        command = [cargo, "build", "--release", "--message-format=json", *offline, "--target-dir", str(target)]
        messages, said, code = run_cargo(command, home, environment, name, progress)
        if code != 0 and not offline and _is_network(said):
            # Without a network, the crates may still be on this machine.
            messages, said, code = run_cargo([*command, "--offline"], home, environment, name, progress)
        if code != 0:
            raise failure(messages, said, crate, folder)
        built = [
            file
            for each in messages
            if each.get("reason") == "compiler-artifact" and each["target"]["name"].replace("-", "_") == "wzvi_system"
            for file in each["filenames"]
            if file.endswith(_cache.SUFFIX)
        ]
        if not built:
            raise Error(f"cargo built no library:\n{said.strip()}")
        _cache.put(Path(built[0]), finished)
    except OSError as error:
        if _cache.is_full(folder, str(error)):
            raise _cache.full(folder) from error
        raise Error(f"the cache {folder} cannot be written: {error.strerror}: set WZVI_CACHE to a folder of your own") from error


def _is_network(said: str) -> bool:
    return any(word in said for word in ("failed to download", "Could not resolve", "failed to fetch", "Couldn't connect", "spurious network"))


def run_cargo(
    command: list[str], home: Path, environment: Mapping[str, str], name: str, progress: Optional[bool]
) -> tuple[list[dict[str, Any]], str, int]:
    """Runs cargo in a group of processes of its own, and ends all of the group if anything interrupts.

    Returns the messages of the compiler, what else was said, and the exit code.
    """
    group: dict[str, Any] = {"start_new_session": True} if os.name == "posix" else {"creationflags": 0x00000200}
    messages: list[dict[str, Any]] = []
    told = _Told(name, progress)
    with tempfile.TemporaryFile() as errors:
        try:
            process = subprocess.Popen(
                command, cwd=home, env=dict(environment), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=errors, **group
            )
        except OSError as error:
            raise Error(f"{command[0]} does not start ({error.strerror}): {NO_CARGO.split(': ', 1)[1]}") from error
        over = threading.Event()

        def read() -> None:
            try:
                assert process.stdout is not None
                for line in process.stdout:
                    if line.startswith(b"{"):
                        messages.append(json.loads(line))
            finally:
                over.set()

        try:
            threading.Thread(target=read, daemon=True).start()
            while not over.wait(0.05):
                told.at(messages)
            code = process.wait()
        except BaseException:
            end_group(process)
            raise
        finally:
            told.end()
        errors.seek(0)
        return messages, errors.read().decode(errors="replace"), code


def end_group(process: subprocess.Popen[bytes]) -> None:
    """Ends cargo and the compilers that it started."""
    if os.name == "posix":
        for sign, patience in ((signal.SIGTERM, 0.2), (signal.SIGKILL, 2.0)):
            try:
                os.killpg(process.pid, sign)
            except (ProcessLookupError, PermissionError):
                pass
            try:
                process.wait(patience)
            except subprocess.TimeoutExpired:
                continue
            if sign == signal.SIGTERM:
                # A compiler may live longer than cargo.
                continue
    else:
        subprocess.run(["taskkill", "/F", "/T", "/PID", str(process.pid)], capture_output=True, check=False)
        process.wait(2.0)


class _Told:
    """A line that says that a compiler is at work, and how far it is."""

    def __init__(self, name: str, progress: Optional[bool]) -> None:
        shown = progress if progress is not None else (in_notebook() or (sys.stderr is not None and sys.stderr.isatty()))
        self.line = Line() if shown else None
        self.name, self.began, self.last = name, time.monotonic(), 0.0

    def at(self, messages: list[dict[str, Any]]) -> None:
        now = time.monotonic()
        if self.line is None or now - self.began < 1.0 or now - self.last < 0.5:
            return
        self.last = now
        built = sum(1 for each in messages if each.get("reason") == "compiler-artifact")
        first = any(each.get("reason") == "compiler-artifact" and not each.get("fresh", True) for each in messages)
        once = f", {built} crates that later systems share" if first else ""
        self.line.write(f"compiling {self.name}: {now - self.began:.0f} s{once}")

    def end(self) -> None:
        if self.line is not None:
            self.line.end()


def failure(messages: list[dict[str, Any]], said: str, crate: Crate, folder: Path) -> Error:
    """What the compiler said, at the lines of the user."""
    compiled = [each["message"] for each in messages if each.get("reason") == "compiler-message"]
    errors = [each for each in compiled if each["level"].startswith("error") and not each["message"].startswith("aborting")]
    texts = [said, *(each["message"] for each in errors)]
    if _cache.is_full(folder, *texts):
        return _cache.full(folder)
    everything = "\n".join([said, *(each.get("rendered") or "" for each in errors)])
    if re.search(r"linker `[^`]*` not found|linker.* not found|link\.exe.* not found", everything):
        return Error(NO_LINKER)
    if re.search(r"requires rustc|is not supported by the following package", said) and "rustc" in said:
        return Error(f"{OLD_RUST.format(found='on this machine')}\n\n{said.strip()}")
    lines = crate.text.split("\n")
    parts: list[tuple[list[Message], str]] = []
    seen: set[tuple[Any, ...]] = set()
    for message in errors:
        text, places = _placed(message, lines, crate.origins)
        # What is said again of the same place, and again of no place at all, is no news.
        key = places[0][1:4] if places else ()
        if key not in seen:
            seen.add(key)
            parts.append((places, text))
    # Nor is what follows from a mistake of the user, but is at no line of his.
    if any(places for places, _ in parts):
        parts = [each for each in parts if each[0]]
    if not parts:
        return Error(f"cargo failed:\n{said.strip()}")
    found = [place for places, _ in parts for place in places] or [Message(errors[0]["message"], None, None, None, None)]
    return CompileError("\n\n".join(text for _, text in parts), found)


#: Notes of the compiler on its own types.
_NOTES = ("required for", "required by", "redundant requirement", "full name for the type", "consider using `--verbose`", "for that trait implementation", "the trait `")


def _placed(message: Mapping[str, Any], lines: list[str], origins: tuple[Origin, ...]) -> tuple[str, list[Message]]:
    text: str = message["message"]
    part: list[str] = []
    places: list[Message] = []

    def add(at: int, column: int, width: int, mark: str, label: Optional[str]) -> None:
        origin = origins[at]
        term = f", the term `{origin.term}`" if origin.term else ""
        part.extend([f"  --> {origin.argument}, line {origin.line}{term}", pointed(lines[at], column, width, mark, label or "")])
        if mark == "^" or not places:
            places.append(Message(text, origin.argument, origin.line, column, width, label, origin.term))

    for span in sorted(message["spans"], key=lambda span: not span["is_primary"]):
        span = outermost(span)
        at = span["line_start"] - 1
        if not span["file_name"].endswith("lib.rs") or at >= len(origins) or origins[at].argument is None:
            continue
        end = span["column_end"] if span["line_end"] == span["line_start"] else len(lines[at]) + 1
        add(at, span["column_start"], max(end - span["column_start"], 1), "^" if span["is_primary"] else "-", span.get("label"))
    if not places:
        at_scheme = _scheme_of(message, lines, origins)
        if at_scheme is not None:
            add(at_scheme, 1, len(lines[at_scheme]), "^", None)
    for child in message["children"]:
        if any(note in child["message"] for note in _NOTES):
            continue
        # Help may say what to write at a place.
        replaced = [span["suggested_replacement"] for span in child["spans"] if span.get("suggested_replacement")]
        hint = f": `{replaced[0]}`" if len(replaced) == 1 else ""
        part.append(f"  = {child['level']}: {child['message']}{hint}")
    return "\n".join([text, *part]), places


def _scheme_of(message: Mapping[str, Any], lines: list[str], origins: tuple[Origin, ...]) -> Optional[int]:
    """The line of a further scheme that does not exist for the system: rustc finds it where the library is put together."""

    def plain(text: str) -> str:
        return re.sub(r"\w+::|\s", "", text)

    said = plain(" ".join([message["message"], *(child["message"] for child in message["children"])]))
    for at, origin in enumerate(origins):
        if origin.argument and origin.argument.startswith("schemes") and f"Discretized<{plain(lines[at])}>" in said:
            return at
    return None


def outermost(span: dict[str, Any]) -> dict[str, Any]:
    """Where the user wrote what a macro expanded."""
    while span.get("expansion") and not span["file_name"].endswith("lib.rs"):
        span = span["expansion"]["span"]
    return span
