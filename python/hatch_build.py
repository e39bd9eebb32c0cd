"""Puts the Rust sources of wzvi into the package, with what a first build would have to download, and a mark of their content."""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

CRATES = ("wzvi-macros", "wzvi-runtime", "wzvi-c")
#: Parts of the root manifest that path crates inherit from, or that make the crate `wzvi`.
KEPT = ("workspace.package", "workspace.dependencies", "workspace.lints", "package", "features", "dependencies", "lints")


def reduced(manifest: str) -> str:
    """The root manifest with the three crates as members, without examples and profiles."""
    kept, is_kept = ['[workspace]\nmembers = ["wzvi-macros", "wzvi-runtime", "wzvi-c"]\nresolver = "3"\n'], False
    for line in manifest.split("\n"):
        header = re.match(r"\[+([^\]]+)\]+\s*$", line)
        if header:
            name = header[1].strip()
            is_kept = any(name == each or name.startswith(each + ".") for each in KEPT) and not name.startswith("package.metadata")
        if is_kept:
            kept.append(line)
    text = "\n".join(kept) + "\n"
    # Files that are not here.
    text = re.sub(r"(?m)^readme = .*\n", "", text)
    return re.sub(r"(?ms)^include = \[.*?^\]\n", "", text)


def without_targets(manifest: str) -> str:
    """The manifest of a crate without its tests, benches and examples, whose files are not copied."""
    kept, is_kept = [], True
    for line in manifest.split("\n"):
        header = re.match(r"\[+([^\]]+)\]+\s*$", line)
        if header:
            is_kept = header[1].strip() not in ("example", "test", "bench", "dev-dependencies")
        if is_kept:
            kept.append(line)
    return re.sub(r"(?m)^readme = .*\n", "", "\n".join(kept))


def copy_sources(repository: Path, into: Path) -> None:
    """The sources of the crates, as a workspace of their own."""
    into.mkdir(parents=True, exist_ok=True)
    (into / "Cargo.toml").write_text(reduced((repository / "Cargo.toml").read_text(encoding="utf-8")), encoding="utf-8", newline="\n")
    shutil.copytree(repository / "src", into / "src")
    for crate in CRATES:
        manifest = without_targets((repository / crate / "Cargo.toml").read_text(encoding="utf-8"))
        (into / crate).mkdir()
        (into / crate / "Cargo.toml").write_text(manifest, encoding="utf-8", newline="\n")
        shutil.copytree(repository / crate / "src", into / crate / "src")
        for more in ("build.rs", "wzvi.h"):
            if (repository / crate / more).exists():
                shutil.copy(repository / crate / more, into / crate / more)
    # What is read by `include_str!` from beside the sources.
    for source in into.rglob("*.rs"):
        for found in re.findall(r'include_(?:str|bytes)!\(\s*"([^"]+)"', source.read_text(encoding="utf-8")):
            wanted = (source.parent / found).resolve()
            origin = (repository / source.relative_to(into).parent / found).resolve()
            if not wanted.exists() and origin.is_file() and into.resolve() in wanted.parents:
                wanted.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(origin, wanted)
    for licence in ("LICENSE-MIT", "LICENSE-APACHE", "NOTICE"):
        shutil.copy(repository / licence, into / licence)


def fingerprint(folder: Path) -> str:
    """Of all names and contents."""
    digest = hashlib.sha256()
    for file in sorted(folder.rglob("*")):
        if file.is_file():
            digest.update(f"{file.relative_to(folder).as_posix()} {file.stat().st_size}\n".encode())
            digest.update(file.read_bytes())
    return digest.hexdigest()


def vendor(sources: Path, repository: Path) -> bool:
    """The crates of others that a system needs, and no more; needs cargo, and its registry or a network."""
    cargo = shutil.which("cargo")
    if cargo is None:
        return False
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder)
        (home / "lib.rs").write_text("", encoding="utf-8")
        (home / "Cargo.toml").write_text(
            '[package]\nname = "wzvi-system"\nversion = "0.0.0"\nedition = "2024"\npublish = false\n[lib]\npath = "lib.rs"\n'
            'crate-type = ["cdylib"]\n[dependencies]\n'
            f'wzvi = {{ path = {json.dumps(str(sources))}, default-features = false, features = ["ensemble"] }}\n'
            f'wzvi-c = {{ path = {json.dumps(str(sources / "wzvi-c"))}, features = ["ensemble", "sweep", "chaos"] }}\n[workspace]\n',
            encoding="utf-8",
        )
        # The versions that the repository is tested with.
        if (repository / "Cargo.lock").exists():
            shutil.copy(repository / "Cargo.lock", home / "Cargo.lock")
        environment = {**os.environ, "CARGO_TERM_COLOR": "never"}
        command = [cargo, "vendor", "--quiet", "--versioned-dirs", str(sources / "vendor")]
        for more in ([], ["--offline"]):
            done = subprocess.run([*command, *more], cwd=home, env=environment, capture_output=True, text=True, check=False)
            if done.returncode == 0:
                break
        else:
            shutil.rmtree(sources / "vendor", ignore_errors=True)
            print(f"crates of others are not in the package, and a first build downloads them: {done.stderr.strip()}")
            return False
        shutil.copy(home / "Cargo.lock", sources / "wzvi-system.lock")
        tree = [cargo, "tree", "--offline", "--edges", "normal,build", "--target", "all", "--prefix", "none", "--no-dedupe"]
        listed = subprocess.run(tree, cwd=home, env=environment, capture_output=True, text=True, check=True).stdout
    # Lines are `name v1.2.3`, and folders `name-1.2.3`.
    needed = {f"{line.split()[0]}-{line.split()[1][1:]}" for line in listed.splitlines() if line.strip()}
    for crate in (sources / "vendor").iterdir():
        slim(crate, is_needed=crate.name in needed)
    return True


def slim(crate: Path, is_needed: bool) -> None:
    """Leaves out what no build of a dependency reads; of crates that cargo wants to see, but never compiles, all but the manifest."""
    listed = crate / ".cargo-checksum.json"
    checksums = json.loads(listed.read_text(encoding="utf-8"))
    if is_needed:
        for name in ("tests", "benches", "examples", ".github", "ci", "fuzz"):
            shutil.rmtree(crate / name, ignore_errors=True)
    else:
        manifest = (crate / "Cargo.toml").read_bytes()
        shutil.rmtree(crate)
        (crate / "src").mkdir(parents=True)
        (crate / "Cargo.toml").write_bytes(manifest)
        (crate / "src" / "lib.rs").write_text("", encoding="utf-8")
        checksums["files"] = {}
    left = {name: each for name, each in checksums["files"].items() if (crate / name).exists()}
    listed.write_text(json.dumps({"files": left, "package": checksums["package"]}), encoding="utf-8")


class Sources(BuildHookInterface):  # type: ignore[type-arg]
    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        root = Path(self.root)
        repository = root.parent
        if version == "editable" or not (repository / "wzvi-c" / "Cargo.toml").exists():
            # A checkout has its sources beside it, and a source distribution has them in the package.
            return
        self.staging = Path(tempfile.mkdtemp(prefix="wzvi-sources-"))
        staged = self.staging / "_sources"
        copy_sources(repository, staged)
        vendor(staged, repository)
        (staged / "FINGERPRINT").write_text(fingerprint(staged) + "\n", encoding="ascii")
        prefix = "" if self.target_name == "wheel" else "src/"
        build_data["force_include"][str(staged)] = f"{prefix}wzvi/_sources"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        if hasattr(self, "staging"):
            shutil.rmtree(self.staging, ignore_errors=True)
