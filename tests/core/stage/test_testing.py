"""The public check of stages finds what breaks their contract."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np
import pytest

from graphnav import Image, Latest, Metric, ParamError, Source, Stage, Stamped, State, Twist, Unnoticed, param
from graphnav.testing import check_stage


def picture() -> Image:
    return Image(pixels=np.zeros((4, 6), np.uint8))


class Good(Stage):
    """The same picture."""

    gain: float = param(1.0, ge=0.0, doc="dimensionless")

    def step(self, image: Image) -> Image:
        return image


class NoDoc(Good):
    def step(self, image: Image) -> Image:
        return image


class NoSentence(Good):
    """No sentence"""


class WrongUnit(Stage):
    """Its parameter names a unit that graphnav writes differently."""

    wait_ms: float = param(1.0, doc="how long")

    def step(self, image: Image) -> Image:
        return image


class NoUnit(Stage):
    """Its parameters are numbers of unknown unit."""

    size: tuple[float, float] | None = param(None, doc="how large")

    def step(self, image: Image) -> Image:
        return image


class WrongDefault(Stage):
    """Its default is out of bounds."""

    gain: float = param(-1.0, ge=0.0, doc="dimensionless")

    def step(self, image: Image) -> Image:
        return image


class NoticesNothing(Good):
    """Its unnoticed fault names an input that it has not."""

    unnoticed = (Unnoticed("flow", (Image,), "a picture that freezes"),)


class NeverFires(Stage):
    """Nothing fires it."""

    def step(self, image: Latest[Image]) -> Image:
        return image.value or picture()


class WritesInputs(Stage):
    """It scribbles."""

    def step(self, image: Image) -> Image:
        image.pixels[0, 0] = 1
        return image


class Forgetful(Stage):
    """Its reset does not restart it."""

    steps = 0

    def step(self, image: Image) -> Image:
        Forgetful.steps += 1
        return Image(pixels=image.pixels + np.uint8(Forgetful.steps))


class WrongType(Stage):
    """It returns something else."""

    def step(self, image: Image) -> Image:
        return image.pixels  # type: ignore[return-value]


class SeesTruth(Stage):
    """It drives by what no robot knows."""

    def step(self, state: State) -> Twist:
        return Twist(v_mps=0.0, omega_radps=0.0)


class HeldBack(Source):
    """It waits for something."""

    def step(self, image: Image) -> Image:
        return image


class BadMetrics(Stage):
    """Its metrics are not numbers."""

    metrics: ClassVar[tuple[Metric, ...]] = (Metric("share", better="higher", help="Share."),)

    def step(self, image: Image) -> None:
        return None

    def summary(self) -> Mapping[str, float]:
        return {"share": "half"}  # type: ignore[dict-item]


class Undeclared(BadMetrics):
    """It returns another metric than it declares."""

    def summary(self) -> Mapping[str, float]:
        return {"shape": 1.0}


class Silent(Good):
    """It declares metrics that nothing returns."""

    metrics: ClassVar = BadMetrics.metrics


class Talkative(BadMetrics):
    """It returns metrics without a declaration."""

    metrics: ClassVar[tuple[Metric, ...]] = ()


class Stopped(Source):
    """It never fires."""

    def rate(self) -> float:
        return 0.0

    def step(self) -> Image:
        return picture()


class NeedsFile(Source):
    """It plays a file."""

    path: Path = param(Path("nowhere.jpg"), doc="what to play")

    def check(self) -> None:
        if not self.path.exists():
            raise ParamError("path", "there is no such file")

    def step(self) -> Image:
        return picture()


class Sensed(NamedTuple):
    image: Stamped[Image] | None


class Pair(NamedTuple):
    near: Image
    far: Image | None


class Meddles(Stage):
    """Another output depends on what is read."""

    def step(self, image: Image) -> Pair:
        return Pair(Image(pixels=image.pixels + np.uint8(not self.is_read("far"))), image)


class Withholds(Stage):
    """It leaves out an output that every step must have."""

    def step(self, image: Image) -> Pair:
        return Pair(image if self.is_read("near") else None, None)  # type: ignore[arg-type]


class Spares(Stage):
    """It leaves out an optional output."""

    def step(self, image: Image) -> Pair:
        return Pair(image, image if self.is_read("far") else None)


class Sensor(Stage):
    """Its output has a stamp of its own, which has to repeat as well."""

    drift_us: ClassVar[int] = 0

    def step(self, image: Image) -> Sensed:
        Sensor.drift_us += 1
        return Sensed(Stamped(image, Sensor.drift_us))


def test_stamps_of_an_output_have_to_repeat() -> None:
    with pytest.raises(AssertionError, match="the same seed gave a different output in step 1"):
        check_stage(Sensor, {"image": picture()})


def test_a_good_stage_passes() -> None:
    check_stage(Good, {"image": picture()}, {"image": picture()}, gain=0.5)
    check_stage(Spares, {"image": picture()})


@pytest.mark.parametrize(
    ("cls", "said"),
    [
        (NoDoc, "has no docstring"),
        (NoSentence, "is not a sentence"),
        (WrongUnit, "parameter 'wait_ms' does not end in a unit suffix of graphnav"),
        (NoUnit, "parameter 'size' has no unit suffix: add one, or say 'dimensionless' in its doc"),
        (WrongDefault, "invalid default"),
        (NoticesNothing, "names 'flow' in 'unnoticed', which is not a sampled input"),
        (SeesTruth, "input 'state' is true data, but the role is method: write role"),
        (HeldBack, "is a Source, but its input 'image' is not sampled"),
        (NeverFires, "nothing fires it"),
        (Forgetful, "the same seed gave a different output in step 1"),
        (WrongType, "output 'image' is ndarray"),
        (Meddles, "output 'near' of step 1 depends on which outputs are read"),
        (Withholds, "output 'near' of step 1 depends on which outputs are read"),
        (BadMetrics, "metric 'share' of summary() is 'half'"),
        (Silent, "declares metrics, but has no summary()"),
        (Talkative, "has a summary(), but declares no metrics"),
    ],
)
def test_what_breaks_the_contract_is_told(cls: type[Stage], said: str) -> None:
    with pytest.raises(AssertionError) as caught:
        check_stage(cls, {"image": picture()})
    assert str(caught.value).startswith(f"{cls.__qualname__}: ")
    assert said in str(caught.value)


def test_only_declared_metrics_are_returned() -> None:
    with pytest.raises(AssertionError, match="'shape', which it does not declare"):
        check_stage(Undeclared, {"image": picture()})


def test_a_source_has_a_rate() -> None:
    with pytest.raises(AssertionError, match="rate\\(\\) is 0"):
        check_stage(Stopped, {})


def test_inputs_are_read_only() -> None:
    with pytest.raises(ValueError, match="read-only"):
        check_stage(WritesInputs, {"image": picture()})


def test_files_that_are_not_here_end_the_check_unless_they_were_given() -> None:
    check_stage(NeedsFile)
    given: dict[str, Any] = {"path": "also_nowhere.jpg"}
    with pytest.raises(AssertionError, match="there is no such file"):
        check_stage(NeedsFile, **given)
