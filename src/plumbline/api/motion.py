"""What came of one scene on one engine: states of every step as arrays, and how the run ended."""

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from plumbline.api.frames import described
from plumbline.harness.intake.error import PlumblineError
from plumbline.harness.store.arrays import read_arrays

if TYPE_CHECKING:
    from plumbline.harness.adapter import Adapter
    from plumbline.harness.case import Case
    from plumbline.harness.scene import Scene
    from plumbline.harness.store.record import Record

Floats = NDArray[np.float64]


class Run:
    """One scene on one engine.

    Terms:
        engine, engine_version, track; dt [s]. scene: what was run. bodies: names, in the order of the arrays.
        status: "finite" (a scene of one's own was carried to its end), "passed" or "failed" (the checks of a case),
        "diverged", "unsupported", "unavailable", "timeout", "crashed" or "oom". reason: why. warnings: what engine and adapter
        said. settings: what the engine used. time, positions, ... raise `PlumblineError` with status and reason if the engine
        gave no state; a run that diverged has those up to there.
    """

    def __init__(
        self, record: "Record", scene: "Scene", case: "Case", adapter: "Adapter", folder: "TemporaryDirectory[str]"
    ) -> None:
        self._record, self._case, self._adapter, self._folder = record, case, adapter, folder
        self.scene, self.bodies = scene, tuple(body.name for body in scene.bodies)
        self.engine, self.engine_version, self.track, self.dt = record.engine, record.engine_version, record.track, record.dt
        own = record.status == "passed" and case.truth == "agreed limit"
        self.status: str = "finite" if own else record.status
        self.reason, self.warnings = record.reason, tuple(map(str, record.warnings))
        self.settings: Mapping[str, Any] = record.resolved

    def __repr__(self) -> str:
        """In a line: engine, outcome, steps."""
        side = f"{self.engine} {self.engine_version}/{self.track}"
        return f"<Run {side}, dt {self.dt:g} s: {self.status}, {self._record.steps} steps>"

    @cached_property
    def _arrays(self) -> Mapping[str, NDArray[Any]]:
        if self._record.trajectory_hash is None:
            raise PlumblineError(f"{self.engine} gave no state: {self.status}: {self.reason}")
        return read_arrays(Path(self._folder.name) / "trajectories" / f"{self._record.trajectory_hash}.npz")

    @property
    def time(self) -> Floats:
        """Times of the states, shape (steps + 1,) [s]: the start, then the end of every step."""
        return self._arrays["time"]

    @property
    def positions(self) -> Floats:
        """Of the centres of mass in the world frame, shape (steps + 1, bodies, 3) [m]."""
        return self._arrays["p_WB"]

    @property
    def orientations(self) -> Floats:
        """Unit quaternions (w, x, y, z) from the frame of a body to the world's, shape (steps + 1, bodies, 4)."""
        return self._arrays["q_WB"]

    @property
    def velocities(self) -> Floats:
        """Of the centres of mass in the world frame, shape (steps + 1, bodies, 3) [m/s]."""
        return self._arrays["v_WB"]

    @property
    def angular_velocities(self) -> Floats:
        """In the world frame, shape (steps + 1, bodies, 3) [rad/s]."""
        return self._arrays["w_WB"]

    @property
    def signals(self) -> Mapping[str, Floats]:
        """What sensors read, by "<sensor>/<channel>", shape (readings, ...), and their times [s] by "<sensor>/time"."""
        return {name.removeprefix("stream:"): array for name, array in self._arrays.items() if name.startswith("stream:")}

    def frame(self) -> pd.DataFrame:
        """A row a state of a body; units and meanings of the columns are in `attrs["units"]` and `attrs["columns"]`."""
        count, bodies = self.positions.shape[:2]
        states = np.concatenate((self.positions, self.orientations, self.velocities, self.angular_velocities), axis=2)
        names = [*"xyz", *(f"{kind}{axis}" for kind, axes in (("q", "wxyz"), ("v", "xyz"), ("w", "xyz")) for axis in axes)]
        frame = pd.DataFrame(states.reshape(-1, len(names)), columns=names)
        frame.insert(0, "time", np.repeat(self.time, bodies))
        frame.insert(1, "body", np.tile(np.array(self.bodies, dtype=object), count))
        return described("states", frame)

    @property
    def measurements(self) -> pd.DataFrame:
        """What was measured of the run: a row a metric, with the bound if it has one."""
        from plumbline.harness.store.stored_tables import tables_of

        return described("measurements", tables_of([self._record])["measurements"])

    @property
    def fidelity(self) -> pd.DataFrame:
        """What became of each kind of element of a robot file; no row of a scene that was built in Python, or of a case."""
        from plumbline.harness.store.imported_scenes import fidelity_of

        return described("fidelity", pd.DataFrame(fidelity_of(Path(self._folder.name))))

    def recording(self) -> Path:
        """Write the run as a rerun recording, which lasts as long as this object; returns its path."""
        from plumbline.harness.store.store import write_json
        from plumbline.harness.store.stored_tables import write_tables
        from plumbline.harness.study.catalogue import describe_case, describe_engine
        from plumbline.reports.recordings import write_recordings

        self._arrays  # noqa: B018  # says why there is nothing to show
        folder = Path(self._folder.name)
        write_tables(folder, [self._record])
        about = {"cases": {self._case.name: describe_case(self._case)}}
        write_json(folder / "catalogue.json", about | {"engines": {self.engine: describe_engine(self._adapter)}})
        return write_recordings(folder)[0]

    def show(self) -> None:
        """Show the run in the rerun viewer until its window is closed. Raises: PlumblineError, if no window can open here."""
        from plumbline.reports.recordings.viewer import open_viewer

        path = self.recording()
        if open_viewer(path):
            raise PlumblineError(f"{path}: the viewer could not show it; recording() gives the file for a viewer elsewhere")
