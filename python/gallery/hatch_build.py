"""Builds the library of the gallery by cargo, and puts it into a wheel for this platform and any Python."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface
from packaging.tags import sys_tags


class Library(BuildHookInterface):  # type: ignore[type-arg]
    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        cargo = shutil.which("cargo")
        if cargo is None:
            raise RuntimeError("the gallery is built by cargo: install Rust 1.89 or newer: https://rustup.rs")
        command = [cargo, "build", "--release", "--lib", "--message-format=json-render-diagnostics"]
        done = subprocess.run(command, cwd=self.root, stdout=subprocess.PIPE, text=True, check=True)
        messages = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
        suffix = {"darwin": ".dylib", "win32": ".dll"}.get(sys.platform, ".so")
        built = next(
            file
            for each in messages
            if each["reason"] == "compiler-artifact" and each["target"]["name"].replace("-", "_") == "wzvi_gallery"
            for file in each["filenames"]
            if file.endswith(suffix)
        )
        build_data["force_include"][str(Path(built))] = f"wzvi_gallery/systems{suffix}"
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{next(sys_tags()).platform}"
