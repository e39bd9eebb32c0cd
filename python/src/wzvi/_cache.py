"""The folder of compiled systems. It holds programs: nobody else may write to it."""

from __future__ import annotations

import contextlib
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ._errors import DISK_FULL, Error

#: What builds share is kept for so long after the last one, in seconds.
UNUSED = 30 * 86400.0
#: Leftovers of processes that ended in the middle are older than this, in seconds.
STALE = 3600.0
SUFFIX = {"darwin": ".dylib", "win32": ".dll"}.get(sys.platform, ".so")
#: What a library is written to before it gets its name.
PART = "crate-"


def folder() -> Path:
    """The folder of the cache: WZVI_CACHE, or the place for caches of this system. It is made if it is missing."""
    chosen = os.environ.get("WZVI_CACHE")
    if chosen:
        base = Path(chosen).absolute()
    elif sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "wzvi" / "cache"
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Caches" / "wzvi"
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "wzvi"
    try:
        base.mkdir(parents=True, exist_ok=True, mode=0o700)
        refuse_writable(base)
    except OSError as error:
        raise Error(f"the cache {base} cannot be used: {error.strerror}: set WZVI_CACHE to a folder of your own") from error
    return base


def refuse_writable(base: Path) -> None:
    """An error if others could put programs into this folder."""
    if not hasattr(os, "getuid"):
        return
    status = base.stat()
    if status.st_uid != os.getuid() or status.st_mode & 0o022:
        raise Error(
            f"{base} can be written by others, who could put programs there: set WZVI_CACHE to a folder that only you can write to, "
            "or take the right to write from others (`chmod go-w`)"
        )


@contextlib.contextmanager
def locked(base: Path) -> Iterator[None]:
    """One build at a time for all processes that use this cache. The system opens the lock of a process that ends."""
    with open(base / "lock", "a+b") as file:
        if sys.platform == "win32":
            import msvcrt

            while True:
                try:
                    msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
                    break
                except OSError:
                    time.sleep(0.05)
            try:
                yield
            finally:
                file.seek(0)
                msvcrt.locking(file.fileno(), msvcrt.LK_UNLCK, 1)
        else:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX)
            yield


def put(built: Path, finished: Path) -> None:
    """Copies a file into the cache so that it is there as a whole or not at all, also after a loss of power."""
    part = Path(tempfile.mkdtemp(prefix=PART, dir=finished.parent))
    try:
        copy = part / finished.name
        shutil.copyfile(built, copy)
        with open(copy, "rb+") as file:
            os.fsync(file.fileno())
        os.replace(copy, finished)
    finally:
        shutil.rmtree(part, ignore_errors=True)


def write(path: Path, text: str) -> None:
    """Replaces a text file as a whole."""
    part = path.with_name(path.name + ".part")
    part.write_text(text, encoding="utf-8", newline="\n")
    os.replace(part, path)


def sweep(base: Path) -> None:
    """Removes what processes left that ended in the middle of a build, and what builds of versions share that are gone."""
    now = time.time()
    for pattern, age in ((PART + "*", STALE), ("target/*", UNUSED)):
        for left in base.glob(pattern):
            with contextlib.suppress(OSError):
                if left.is_dir() and now - left.stat().st_mtime > age:
                    shutil.rmtree(left, ignore_errors=True)


def clear_cache() -> int:
    """Removes all compiled systems and what their builds share, and returns how many bytes that were.

    Systems that are loaded stay usable; those of pickles are compiled again when they are needed. The next `compile`
    takes as long as the first one.
    """
    base = folder()
    freed = 0
    with locked(base):
        for each in base.iterdir():
            if each.name == "lock":
                continue
            try:
                if each.is_dir() and not each.is_symlink():
                    freed += sum(file.lstat().st_size for file in each.rglob("*") if not file.is_dir())
                    shutil.rmtree(each, ignore_errors=True)
                else:
                    size = each.lstat().st_size
                    each.unlink()
                    freed += size
            except OSError:
                # Windows keeps libraries that are loaded.
                continue
    return freed


def is_full(base: Path, *texts: str) -> bool:
    """Whether a build ended because the disk is full: by what was said, or by what is left."""
    said = ("os error 28", "os error 112", "No space left", "disk is full", "not enough space")
    if any(word in text for text in texts for word in said):
        return True
    try:
        return shutil.disk_usage(base).free < 1 << 20
    except OSError:
        return False


def full(base: Any) -> Error:
    return Error(DISK_FULL.format(folder=base))
