"""The numbers of a page: both worlds and the road, as plain lists for JSON."""

from math import isfinite
from typing import Any

import numpy as np

from aeb_sumo.criticality import ttc
from aeb_sumo.replay.director import World
from aeb_sumo.replay.film import Film
from aeb_sumo.replay.take import Take
from aeb_sumo.soa import Floats

__all__ = ["data"]

_VIEW = (45.0, 140.0)  # m across a panel, at least and at most
_NEAR = 3.0  # s from the event for which the view is chosen
_STRAIGHT = 0.2  # sine of the angle between headings, below which all of them drive along one road
_ALONG = 0.7  # cosine between headings from which on one follows the other
_LATE = 10.0  # s, a longer time to collision is of no interest


def data(take: Take) -> dict[str, Any]:
    """What the page's script draws. Positions are from the ego's at the event [m], times from the event [s].

    Per world: `t` the frames; `tracks` of all road users, each from its first frame `k` on (front bumper `x`, `y`,
    heading `h`, speed `v`, null while it is not near; `a` the AEB's phases, `w` the frame from which on it is a wreck);
    `lights` of lanes;
    `gap`, `ttc` (of one who follows), `speed`, `other`, `decel` and `brake`, the curves; `contacts`. What the ego and
    its AEB do is that of the step before a frame, and unknown of a wreck.
    """
    films = [world.film for world in take.worlds]
    instant, origin, turn = take.event.instant, *_stage(take)
    scenery = films[0].scenery
    for film in films[1:]:
        scenery = film.scenery if scenery is None else scenery if film.scenery is None else scenery | film.scenery
    across, shift = _view(take)
    straight = all(bool((np.abs(np.sin(f.heading - turn)) < _STRAIGHT).all()) for film in films for f in film.frames)
    return {
        "ego": take.event.ego,
        "other": take.partner,
        "turn": _round(turn, 4),
        "across": round(across * (1.3 if straight else 1.0), 1),
        "straight": straight,
        "shift": shift,
        "parting": _round(take.parting - instant, 3),
        "cast": {
            name: [body.vclass, _round(body.length), _round(body.width)]
            for film in reversed(films)
            for name, body in film.cast.items()
        },
        "lanes": [
            {
                "id": name,
                "p": _line(lane.shape, origin),
                "w": _round(lane.width),
                "kind": lane.kind,
                "inside": lane.inside,
            }
            for name, lane in (scenery.lanes.items() if scenery else ())
        ],
        "junctions": [_line(shape, origin) for shape in (scenery.junctions.values() if scenery else ())],
        "walls": [_line((wall[:2], wall[2:]), origin) for wall in (scenery.walls if scenery else ())],
        "worlds": [_world(world, take, instant, origin) for world in take.worlds],
    }


def _world(world: World, take: Take, instant: float, origin: Floats) -> dict[str, Any]:
    film, ego, other = world.film, take.event.ego, take.partner
    gap, speed = film.gap(ego, other), film.curve(ego, "speed")
    # Whose paths cross, are not on their way to where the other one is.
    follows = np.cos(film.curve(ego, "heading") - film.curve(other, "heading")) > _ALONG
    closing = -np.diff(gap, prepend=np.nan) / np.diff(film.times, prepend=np.nan)
    known = np.isfinite(closing) & (gap > 0) & follows
    until = np.full(len(gap), np.nan)
    until[known] = ttc(gap=gap[known], closing_speed=closing[known])
    driven = film.curve(ego, "wrecked") == 0
    braked = np.where(speed > 0, film.curve(ego, "brake"), 0.0)  # who stands is held, not braked
    return {
        "t": _list(film.times - instant, 3),
        "gap": _list(gap, 3),
        "ttc": _list(np.where(until <= _LATE, until, np.nan), 2),
        "speed": _list(speed, 3),
        "other": _list(film.curve(other, "speed"), 3),
        "decel": _list(np.where(driven, -film.curve(ego, "accel"), np.nan), 3),
        "brake": _list(np.where(driven, np.concatenate([[np.nan], braked[:-1]]), np.nan), 3),
        "tracks": _tracks(film, origin),
        "lights": _lights(film),
        "contacts": [
            {
                "t": _round(c.time - instant, 4),
                "x": _round(c.x - origin[0]),
                "y": _round(c.y - origin[1]),
                "striker": c.striker,
                "struck": c.struck,
                "speed": _round(c.speed, 4),
            }
            for c in film.contacts
        ],
    }


def _tracks(film: Film, origin: Floats) -> dict[str, Any]:
    tracks = {}
    rows = [{name: at for at, name in enumerate(frame.ids)} for frame in film.frames]
    for name in film.cast:
        there = [k for k, row in enumerate(rows) if name in row]
        first, last = there[0], there[-1]
        span = [(film.frames[k], rows[k].get(name)) for k in range(first, last + 1)]
        wrecked = next((k for k in there if film.frames[k].wrecked[rows[k][name]]), None)
        phases = "".join("0" if at is None else str(int(frame.phase[at])) for frame, at in span)
        tracks[name] = {
            "k": first,
            "x": [None if at is None else _round(frame.x[at] - origin[0]) for frame, at in span],
            "y": [None if at is None else _round(frame.y[at] - origin[1]) for frame, at in span],
            "h": [None if at is None else _round(frame.heading[at], 3) for frame, at in span],
            "v": [None if at is None else _round(frame.speed[at]) for frame, at in span],
            "a": phases if phases.strip("0") else "",
            "w": wrecked,
        }
    return tracks


def _lights(film: Film) -> dict[str, list[list[Any]]]:
    """Per lane, from which frame on its signals show what, from the right, in SUMO's letters."""
    result: dict[str, list[list[Any]]] = {}
    for lane, heads in (film.scenery.heads if film.scenery else {}).items():
        changes = result[lane] = []
        for k, frame in enumerate(film.frames):
            state = "".join(frame.lights[light][place] for light, place in heads)
            if not changes or changes[-1][1] != state:
                changes.append([k, state])
    return result


def _stage(take: Take) -> tuple[Floats, float]:
    """Where the ego is at the event [m], and how it came there [rad]: the way to the right in the drawing."""
    film, ego = take.factual.film, take.event.ego
    x, y = film.curve(ego, "x"), film.curve(ego, "y")
    seen = np.flatnonzero(np.isfinite(x))
    if not len(seen):
        return np.zeros(2), 0.0
    at = seen[np.abs(film.times[seen] - take.event.instant).argmin()]
    return np.array([x[at], y[at]]), float(film.curve(ego, "heading")[seen[0]])


def _view(take: Take) -> tuple[float, float]:
    """How much of the road a panel shows [m], and which share of that the ego is off its middle, backwards."""
    film, ego, other = take.factual.film, take.event.ego, take.partner
    near = np.abs(film.times - take.event.instant) < _NEAR
    dx, dy = (np.where(near, film.curve(other, axis) - film.curve(ego, axis), np.nan) for axis in ("x", "y"))
    apart, heading = np.hypot(dx, dy), film.curve(ego, "heading")
    if not np.isfinite(apart).any():
        return _VIEW[0] * 2, 0.0
    ahead = float(np.nanmean(dx * np.cos(heading) + dy * np.sin(heading)))
    return round(float(np.clip(1.8 * np.nanmax(apart) + 20, *_VIEW)), 1), 0.12 * float(np.sign(ahead))


def _line(shape: tuple[tuple[float, ...], ...], origin: Floats) -> list[float | None]:
    return [_round(value - origin[k]) for point in shape for k, value in enumerate(point)]


def _list(values: Floats, digits: int) -> list[float | None]:
    return [_round(value, digits) for value in values.tolist()]


def _round(value: float, digits: int = 2) -> float | None:
    return round(float(value), digits) + 0.0 if isfinite(value) else None  # + 0.0: no -0.0
