"""MuJoCo's compiler in this process: for the texts of tests, where `plumbline` gives each file a process of its own."""

import io
import os
import warnings
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from plumbline.harness.intake.error import RobotError
from plumbline.harness.scene.importers import mjcf_compiler
from plumbline.harness.scene.importers.mjcf_model import Model, look_for_misspelt, model_of, said_of
from plumbline.harness.scene.importers.mjcf_text import Prepared

__all__ = ["compiled_here"]


def compiled_here(text: Prepared, file: str) -> Model:
    """As `compile_apart`, through the same archive. Raises: RobotError."""
    before = Path.cwd()
    with TemporaryDirectory(prefix="plumbline-mjcf-") as scratch:
        os.chdir(scratch)
        try:
            for name, raw in {"model.xml": text.text.encode(), **text.assets}.items():
                Path(name).write_bytes(raw)
            with warnings.catch_warnings(action="ignore"):
                kept = mjcf_compiler.compiled()
        except Exception as error:
            raise RobotError(said_of(f"{type(error).__name__}: {error}", text, file, mjcf_compiler.schema())) from None
        finally:
            os.chdir(before)
    look_for_misspelt(text, mjcf_compiler.schema())
    archive = io.BytesIO()
    np.savez(archive, allow_pickle=False, **kept)
    return model_of(archive.getvalue(), file)
