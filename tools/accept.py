"""Run acceptance tests, long or machine-dependent: ``python tools/accept.py [ITEM ...]``; each prints its result."""

from __future__ import annotations

import argparse
import sys

from acceptance.attacking import attack_item
from acceptance.clocks import clocks_item
from acceptance.comparing import controls_item, targets_item
from acceptance.coverage import coverage_item
from acceptance.damaging import damage_item
from acceptance.driver_mistakes import mistakes_item
from acceptance.driving import drives_item, sign_item
from acceptance.empty_floor import empty_floor_item
from acceptance.exchange import exchange_item
from acceptance.exporting import exports_item
from acceptance.frozen import frozen_false_item, frozen_item
from acceptance.guarding import guard_item
from acceptance.large_pictures import large_item
from acceptance.lighting import light_item
from acceptance.live_bad import bad_item
from acceptance.live_drives import live_item
from acceptance.live_interop import interop_item
from acceptance.live_late import late_item
from acceptance.live_load import load_item
from acceptance.live_safety import safety_item
from acceptance.machine import bench_item, fresh_item, heard_item, interrupt_item, memory_item
from acceptance.navigating import navigate_item
from acceptance.no_odometry import no_odometry_item
from acceptance.notebook import notebook_item
from acceptance.portable import portable_item
from acceptance.replayable import replayable_item
from acceptance.replaying import replay_item
from acceptance.same_results import results_item
from acceptance.screens import screens_item
from acceptance.seeing import floor_item, sees_item
from acceptance.soak import soak_item
from acceptance.stopped_sender import stopped_sender_item
from acceptance.studying import kill_item, parallel_item
from acceptance.takeovers import takeovers_item
from acceptance.trusting import trust_item
from acceptance.unknown_cells import unknown_item
from acceptance.watch_cost import cost_item
from acceptance.watch_hostile import hostile_item
from acceptance.watch_loss import loss_item
from acceptance.watch_page import page_item

ITEMS = {
    "controls": controls_item,
    "targets": targets_item,
    "drives": drives_item,
    "results": results_item,
    "sign": sign_item,
    "sees": sees_item,
    "floor": floor_item,
    "empty_floor": empty_floor_item,
    "kill": kill_item,
    "parallel": parallel_item,
    "heard": heard_item,
    "memory": memory_item,
    "interrupt": interrupt_item,
    "portable": portable_item,
    "bench": bench_item,
    "fresh": fresh_item,
    "guard": guard_item,
    "frozen": frozen_item,
    "frozen_false": frozen_false_item,
    "live": live_item,
    "load": load_item,
    "safety": safety_item,
    "interop": interop_item,
    "late": late_item,
    "large": large_item,
    "bad": bad_item,
    "mistakes": mistakes_item,
    "takeovers": takeovers_item,
    "loss": loss_item,
    "hostile": hostile_item,
    "cost": cost_item,
    "page": page_item,
    "replay": replay_item,
    "replayable": replayable_item,
    "damage": damage_item,
    "screens": screens_item,
    "exchange": exchange_item,
    "exports": exports_item,
    "notebook": notebook_item,
    "coverage": coverage_item,
    "unknown": unknown_item,
    "light": light_item,
    "no_odometry": no_odometry_item,
    "navigate": navigate_item,
    "soak": soak_item,
    "trust": trust_item,
    "attack": attack_item,
    "stopped_sender": stopped_sender_item,
    "clocks": clocks_item,
}


def main() -> int:
    """Run the items named, else all; return 1 if one misses its target."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("items", nargs="*", metavar="ITEM", help=f"of {', '.join(ITEMS)} (default: all)")
    parser.add_argument("--seeds", default="1000:1020", help="FIRST:END, END excluded (default 1000:1020)")
    parser.add_argument("-j", dest="jobs", type=int, default=2, help="parallel processes (default 2)")
    args = parser.parse_args()
    if unknown := set(args.items) - set(ITEMS):
        parser.error(f"no item {', '.join(sorted(unknown))}: items are {', '.join(ITEMS)}")
    first, end = map(int, args.seeds.split(":"))
    missed = []
    for name in args.items or ITEMS:
        sys.stdout.write(f"== {name}\n")
        sys.stdout.flush()
        if not ITEMS[name](range(first, end), args.jobs):
            missed.append(name)
    sys.stdout.write(f"missed: {', '.join(missed)}\n" if missed else "all items met\n")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
