"""What SUMO is started with to simulate a scenario."""

from pathlib import Path

from aeb_sumo.scenarios.base import Scenario
from aeb_sumo.world.session import IMPOSED, output_prefix

__all__ = ["start_options"]


def start_options(
    scenario: Scenario,
    folder: Path,
    *,
    seed: int | None = None,
    step_length: float | None = None,
    output: Path | None = None,
) -> list[str]:
    """Options for `aeb_sumo.world.session.Session`.

    Args:
        scenario: what is simulated.
        folder: a temporary one, which must outlive the session: vehicles that the scenario brings as text go there.
        seed: of SUMO; None for the scenario's.
        step_length: [s]; None for the scenario's.
        output: folder for the output files that the scenario itself asks of SUMO; None for `folder`.

    Raises:
        InputError: SUMO cannot write into the folder for output.
    """
    routes = folder / "vehicles.rou.xml"
    routes.write_text(scenario.vehicles, encoding="utf-8")
    step = scenario.step_length if step_length is None else step_length
    number = scenario.seed if seed is None else seed
    return [
        *scenario.sumo_options,
        *(("--route-files", str(routes)) if scenario.vehicles else ()),
        *IMPOSED,
        *(("--step-length", f"{step:g}") if step is not None else ()),
        *(("--seed", str(number)) if number is not None else ()),
        "--output-prefix",
        output_prefix(str(Path(output or folder).resolve()), scenario.output_prefix),
    ]
