"""The script in an FMU, which pythonfmu3 calls; it is copied there and not imported elsewhere."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

from pythonfmu3 import (
    DefaultExperiment,
    Float64,
    Fmi3Causality,
    Fmi3Initial,
    Fmi3Slave,
    Fmi3Status,
    Fmi3StepResult,
    Fmi3Variability,
    Unit,
)

from ancfsparse.embedding.fmu_model import TIME, UNITS, FmuModel
from ancfsparse.errors import AncfError


class SceneSlave(Fmi3Slave):  # type: ignore[misc]
    """A scene as a unit of a co-simulation."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self._model = model = FmuModel(Path(self.resources))
        self.modelName = model.name
        self.default_experiment = DefaultExperiment(start_time=0.0, step_size=model.dt)
        units = dict.fromkeys(model.outputs.values())
        self.register_units([Unit(name, **UNITS[name]) for name in units])
        self.register_variable(
            Float64(
                TIME,
                causality=Fmi3Causality.independent,
                variability=Fmi3Variability.continuous,
                getter=lambda: model.time,
            )
        )
        for name in model.inputs:
            self.register_variable(
                Float64(
                    name,
                    causality=Fmi3Causality.input,
                    variability=Fmi3Variability.continuous,
                    getter=partial(model.inputs.__getitem__, name),
                    setter=partial(model.inputs.__setitem__, name),
                )
            )
        for name, unit in model.outputs.items():
            self.register_variable(
                Float64(
                    name,
                    causality=Fmi3Causality.output,
                    variability=Fmi3Variability.continuous,
                    initial=Fmi3Initial.calculated,
                    unit=unit,
                    getter=partial(model.output, name),
                )
            )

    def enter_initialization_mode(self) -> None:
        """Set up the simulation, so that outputs have their values at the start."""
        self._model.begin()

    def exit_initialization_mode(self) -> None:
        """Set it up again, if inputs were set in the meantime."""
        self._model.begin()

    def do_step(self, current_time: float, step_size: float) -> Any:
        """Take the time steps of a communication step."""
        try:
            self._model.step(step_size)
        except AncfError as error:
            self.log(str(error), Fmi3Status.error)
            return Fmi3StepResult(status=Fmi3Status.error)
        return Fmi3StepResult(status=Fmi3Status.ok)
