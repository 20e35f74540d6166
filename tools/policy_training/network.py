"""The network: pictures and beacon to speeds; how it learns, and how it becomes ONNX.

It is taught to choose among directions, as the planner's answer is one of two where a pillar is ahead, and the mean of
both leads into it. Its speeds are those of the control law of the planner, averaged over what it deems likely.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import onnx
import torch
from torch import Tensor, nn

from policy_training.drives import FRAMES

USED = (14, 12, 8, 0)
"""Those that it looks at: now, two, six and fourteen frames ago."""
WIDEST_RAD = math.radians(100)
N_DIRECTIONS = 25
SPREAD_RAD = math.radians(6)
"""Standard deviation of what counts as the planner's direction."""
SHARPNESS = 2.0
"""Exponent of the probabilities before they are averaged: more follows the likeliest direction."""
BATCH = 128


class Policy(nn.Module):  # type: ignore[misc]
    """From pictures at half of the camera's size to the log-likelihood of each direction."""

    def __init__(self) -> None:
        super().__init__()
        self.eye = nn.Sequential(
            nn.Conv2d(len(USED), 32, 5, 2, 2, bias=False), nn.BatchNorm2d(32), nn.ReLU(),
            nn.Conv2d(32, 48, 3, 2, 1, bias=False), nn.BatchNorm2d(48), nn.ReLU(),
            nn.Conv2d(48, 64, 3, 2, 1, bias=False), nn.BatchNorm2d(64), nn.ReLU(),
            nn.Conv2d(64, 96, 3, 2, 1, bias=False), nn.BatchNorm2d(96), nn.ReLU(),
            nn.Flatten(),
            nn.Linear(96 * 4 * 5, 128), nn.ReLU(),
        )  # fmt: skip
        self.goal = nn.Sequential(nn.Linear(6, 32), nn.ReLU())
        self.head = nn.Sequential(nn.Linear(160, 96), nn.ReLU(), nn.Linear(96, N_DIRECTIONS))

    def forward(self, pictures: Tensor, told: Tensor) -> Tensor:
        """Pictures (n, used, 60, 80) as gray levels, told (n, 4): bearing, distance, most speed, most turn."""
        centred = pictures - pictures.mean(dim=(1, 2, 3), keepdim=True)
        spread = (centred * centred).mean(dim=(1, 2, 3), keepdim=True).sqrt()
        seen = self.eye(centred / (spread + 2.0))
        bearing, distance, speed, turn = told[:, 0:1], told[:, 1:2], told[:, 2:3], told[:, 3:4]
        known = (distance > 0).to(told.dtype)
        features = torch.cat(
            [known * bearing.cos(), known * bearing.sin(), known * (-distance).exp(), known, speed, turn / 2], dim=1
        )
        return self.head(torch.cat([seen, self.goal(features)], dim=1))


def directions() -> Tensor:
    """Return the directions, from the rightmost, rad."""
    return torch.linspace(-WIDEST_RAD, WIDEST_RAD, N_DIRECTIONS)


class Driver(nn.Module):  # type: ignore[misc]
    """The network as it is exported: everything from the camera's pictures to the command."""

    def __init__(self, policy: Policy) -> None:
        super().__init__()
        self.policy = policy
        theta = directions()
        self.register_buffer("ahead", theta.cos().clamp(min=0.0)[:, None])
        aside = torch.where(theta.abs() > math.pi / 2, theta.sign(), theta.sin())
        self.register_buffer("aside", aside[:, None])

    def forward(
        self, image: Tensor, bearing: Tensor, distance: Tensor, speed: Tensor, turn: Tensor
    ) -> tuple[Tensor, Tensor]:
        """Return forward speed and turning rate, (1, 1) each, of pictures (1, frames, h, w) and scalars (1, 1)."""
        used = torch.cat([image[:, number : number + 1] for number in USED], dim=1).float()
        small = nn.functional.avg_pool2d(used, 2)
        likely = (SHARPNESS * self.policy(small, torch.cat([bearing, distance, speed, turn], dim=1))).softmax(dim=1)
        return speed * (likely @ self.ahead), turn * (likely @ self.aside)


@dataclass(frozen=True)
class Lessons:
    """All frames of drives: pictures (n, h, w), what is told (n, 4), directions (n,), where each drive begins (n,)."""

    pictures: Tensor
    told: Tensor
    directions: Tensor
    begins: Tensor
    taught: Tensor
    """The frames to learn from, (m,)."""

    @classmethod
    def of(cls, files: Sequence[Path]) -> Lessons:
        """Read the files of drives; of fast pictures every second one is learned from."""
        pictures, told, thetas, begins, taught, n = [], [], [], [], [], 0
        for file in files:
            with np.load(file) as drive:
                count = len(drive["directions"])
                pictures.append(drive["pictures"])
                told.append(np.hstack([drive["goals"], np.tile(drive["limits"], (count, 1))]))
                thetas.append(drive["directions"])
            begins.append(np.full(count, n))
            taught.append(n + np.arange(0, count, 2 if told[-1][0, 2] > 0.5 else 1))
            n += count
        tensor = [torch.from_numpy(np.concatenate(one)) for one in (pictures, told, thetas, begins, taught)]
        return cls(tensor[0], tensor[1].float(), tensor[2].float(), tensor[3], tensor[4])

    def batch(self, frames: Tensor, *, mirrored: bool) -> tuple[Tensor, Tensor, Tensor]:
        """Return pictures, what is told, and directions of some frames."""
        ages = torch.tensor([FRAMES - 1 - number for number in USED])
        behind = torch.maximum(frames[:, None] - ages, self.begins[frames][:, None])
        pictures, told, theta = self.pictures[behind].float(), self.told[frames], self.directions[frames]
        if mirrored:
            pictures, theta, told = pictures.flip(-1), -theta, told * torch.tensor([-1.0, 1.0, 1.0, 1.0])
        return pictures, told, theta


def wanted(theta: Tensor) -> Tensor:
    """Return the share of each direction that counts as the planner's, (n, directions)."""
    away = directions() - theta.clamp(-WIDEST_RAD, WIDEST_RAD)[:, None]
    return (-(away**2) / (2 * SPREAD_RAD**2)).softmax(dim=1)


def aimed(told: Tensor) -> Tensor:
    """Return where a robot heads that sees nothing: to the beacon, else straight on, rad, (n,)."""
    return told[:, 0].clamp(-WIDEST_RAD, WIDEST_RAD)


def learn(policy: Policy, lessons: Lessons, epochs: float, rate: float, seed: int) -> Iterator[tuple[int, float]]:
    """Teach by cross-entropy, large directions more; yield the step and the mean loss now and then."""
    policy.train().to(memory_format=torch.channels_last)
    rng = torch.Generator().manual_seed(seed)
    steps = int(epochs * len(lessons.taught) / BATCH)
    optimiser = torch.optim.AdamW(policy.parameters(), lr=rate, weight_decay=1e-3)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, rate, total_steps=max(steps, 2), pct_start=0.1)
    order, losses = torch.empty(0, dtype=torch.long), []
    for step in range(steps):
        if len(order) < BATCH:
            order = torch.cat([order, lessons.taught[torch.randperm(len(lessons.taught), generator=rng)]])
        frames, order = order[:BATCH], order[BATCH:]
        pictures, told, theta = lessons.batch(frames, mirrored=step % 2 == 1)
        with torch.autocast("cpu", dtype=torch.bfloat16):
            scores = policy(pictures.contiguous(memory_format=torch.channels_last), told)
        log_share = scores.float().log_softmax(dim=1)
        weight = 1.0 + 2.0 * (theta - aimed(told)).abs().clamp(max=WIDEST_RAD)
        loss = -((wanted(theta) * log_share).sum(dim=1) * weight).mean() / weight.mean()
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        schedule.step()
        losses.append(loss.item())
        if step % 100 == 99:
            yield step + 1, float(np.mean(losses[-100:]))


@torch.no_grad()  # type: ignore[untyped-decorator]
def judged(policy: Policy, lessons: Lessons) -> tuple[float, float]:
    """Return the mean cross-entropy and the median error of the likeliest direction, rad, on other drives."""
    policy.eval()
    losses, errors = [], []
    for frames in lessons.taught.split(512):
        pictures, told, theta = lessons.batch(frames, mirrored=False)
        log_share = policy(pictures, told).log_softmax(dim=1)
        losses.append(-(wanted(theta) * log_share).sum(dim=1))
        likeliest = directions()[log_share.argmax(dim=1)]
        errors.append((likeliest - theta.clamp(-WIDEST_RAD, WIDEST_RAD)).abs())
    return float(torch.cat(losses).mean()), float(torch.cat(errors).mean())


def export(policy: Policy, path: Path, about: Mapping[str, str], size_px: tuple[int, int] = (120, 160)) -> None:
    """Write the network with its normalisation and what it was made of as ONNX."""
    driver = Driver(policy).eval()
    scalars = [torch.zeros(1, 1) for _ in range(4)]
    torch.onnx.export(
        driver,
        (torch.zeros(1, FRAMES, *size_px, dtype=torch.uint8), *scalars),
        str(path),
        input_names=["image", "bearing_rad", "distance_m", "max_speed_mps", "max_turn_radps"],
        output_names=["v_mps", "omega_radps"],
        opset_version=17,
        dynamo=False,
    )
    model = onnx.load(path)
    onnx.helper.set_model_props(model, {**about})
    onnx.save(model, path)


def taught_and_written(files: Sequence[Path], before: Path | None, path: Path, *, epochs: float, rate: float) -> None:
    """Teach a network by drives, every 25th of which only judges it; write it as ONNX, and its weights beside it.

    ``before``: the weights to begin with.
    """
    torch.set_num_threads(1)
    torch.manual_seed(0)
    judging = files[:: max(25, len(files) // 8)]
    lessons = Lessons.of([file for file in files if file not in judging] or files)
    policy = Policy()
    if before is not None:
        policy.load_state_dict(torch.load(before))
    for step, loss in learn(policy, lessons, epochs, rate, seed=0):
        print(f"  {step} steps: cross-entropy {loss:.3f}", flush=True)
    entropy, error_rad = judged(policy, Lessons.of(judging))
    print(f"  other drives: cross-entropy {entropy:.3f}, mean error {math.degrees(error_rad):.1f} degrees", flush=True)
    torch.save(policy.state_dict(), path.with_suffix(".pt"))
    about = {
        "made_by": "tools/train_policy.py",
        "drives": f"{len(files)}, {len(lessons.pictures)} frames",
        "seeds": "below 900",
        "barn_worlds": "for tuning, neither 1 nor 5 modulo 12",
        "other_drives": f"cross-entropy {entropy:.3f}, mean error {math.degrees(error_rad):.1f} degrees",
    }
    export(policy, path, about)
