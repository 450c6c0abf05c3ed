"""Causes in words. Plugins may count others: these are said as they are."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from mamo_core.types.scene import Mobility, Scene

_NAMED = 3
"""So many of those involved are named."""

_NO_PATH = {
    "start_blocked": "its start is blocked",
    "goals_blocked": "its ends are blocked",
    "exhausted": "none was found within the work allowed",
}
_WAYS = {
    "approach": "the arm finds no path to where the action begins",
    "transit": "the arm finds no path to the grasps",
    "carry": "the arm finds no path for what it carries",
    "open": "the arm finds no path to where the hand can open",
    "away": "the arm finds no path away from the object",
}

CAUSES: dict[str, str] = {
    # grasps of the target
    "no_grasps": "the problem lists no grasps and none is known that fits the hand",
    "out_of_reach": "its grasps are out of the arm's reach",
    "gripper_too_small": "the gripper does not open wide enough for its grasps",
    "hand_blocked": "there is no room for the hand",
    "grip_missed": "the pads of the fingers do not reach it at its grasps",
    "grip_too_weak": "it is too heavy, or too slippery, for the gripper's force",
    "grip_would_turn": "its weight would turn it between the fingers",
    "grasp_no_ik": "no arm configuration brings the hand to the grasp",
    "grasp_in_collision": "the arm is in collision at the grasp",
    "grasp_blocked": "something is in the way at the grasp",
    "reach_blocked": "the straight way to the grasp is blocked",
    "lift_blocked": "there is no room to lift it",
    "home_blocked": "there is no room at home for the arm that holds it",
    "in_the_way": "it stands where the retrieval sweeps",
    # pushes
    "no_room": "there is no room to slide it straight by a useful length",
    "no_ik": "no arm configuration brings the hand behind it",
    "start_blocked": "the arm is in collision where the push begins",
    "line_untrackable": "the arm cannot follow the straight line of the push",
    "sweep_blocked": "the arm meets something fixed while it pushes",
    "no_turn_helps": "to turn it does not bring it nearer to a place outside the swept region",
    "no_place": "no place outside the swept region was found for it",
    # pick and place
    "ungraspable": "no grasp of it fits the hand",
    "tipped": "it leans too much to be grasped",
    "no_free_place": "no free place for it was found",
    "grasp_hand_blocked": "there is no room for the hand at its grasps",
    "place_hand_blocked": "there is no room for the hand where it could be put down",
    "place_no_ik": "no arm configuration puts it down there",
    "place_blocked": "the arm is in collision where it could be put down",
    "lower_blocked": "there is no room to lower it",
    "retract_blocked": "the hand cannot get away after it was put down",
    # simulated
    "stalled": "the arm stalls",
    "contact": "something touches what must not be touched",
    "tilt": "it tips over",
    "speed": "it becomes too fast",
    "bounds": "it falls",
    "penetration": "something is pressed into something else",
    "unmoved": "it does not move",
    "too_close": "it ends too close to what must not be touched",
    "arm_blocked_after": "the arm ends in collision",
    "no_gain": "it stays in the way as much as before",
    "not_reproduced": "it did not hold in the continuous execution",
    # abstract paths
    "jammed": "they are in each other's way for good",
    "no_paths_found": "no paths for all of them were found within the work allowed",
    **{f"{way}_{why}": f"{_WAYS[way]}: {_NO_PATH[why]}" for way in _WAYS for why in _NO_PATH},
}
"""Where nobody else is involved."""

BLOCKED = "blocked"
"""Counted where a second look found things without which it would work: they are involved."""

_CONTACT = "contact"

INVOLVED: dict[str, str] = {
    _CONTACT: "{} is touched",
    "tilt": "{} tips over",
    "speed": "{} becomes too fast",
    "bounds": "{} falls",
    "penetration": "{} is pressed into something",
    "stalled": "the arm stalls at {}",
}
"""Where somebody else is involved; other causes read the same."""


def in_words(cause: str, others: Sequence[str], scene: Scene) -> str:
    """A cause with the others that it involves, by name; a cause nobody knows as it is."""
    if others and cause == BLOCKED:
        verb = "is" if len(others) == 1 else "are"
        return f"{listed(named_some(others, scene))} {verb} in the way"
    if others and cause in INVOLVED:
        named = named_some(_guarded(others, scene) if cause == _CONTACT else others, scene)
        return INVOLVED[cause].format(listed(named, "or"))
    return CAUSES.get(cause, cause)


def _guarded(names: Sequence[str], scene: Scene) -> Sequence[str]:
    """Those that must not be touched: movables may be, even if something touched both."""
    movable = {item.name for item in scene.objects if item.mobility is Mobility.MOVABLE}
    return [name for name in names if name not in movable] or names


def name_of(name: str, scene: Scene) -> str:
    """A thing by what it is and its name, as in 'the immovable o9'."""
    if any(fixture.name == name for fixture in scene.fixtures):
        return f"the fixture {name}"
    kinds = {item.name: item.mobility for item in scene.objects}
    if kinds.get(name) is Mobility.TARGET:
        return "the target"
    return f"the immovable {name}" if kinds.get(name) is Mobility.IMMOVABLE else name


def named_some(names: Sequence[str], scene: Scene) -> list[str]:
    """The first few of them, and how many more there are."""
    words = [name_of(name, scene) for name in names[:_NAMED]]
    return words if len(names) <= _NAMED else [*words, f"{len(names) - _NAMED} more"]


def listed(words: Iterable[str], last_one: str = "and") -> str:
    """'a', 'a and b', 'a, b and c'."""
    *most, last = words
    return f"{', '.join(most)} {last_one} {last}" if most else last
