"""Assignment of dancers' names to the persons that sensors report, by their positions on the floor."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment

from ..core import Array, PersonStatus

SAME_PLACE_M = 0.25
"""A person this close to where their dancer was last seen keeps the name [m].

Below half of the smallest distance between two slots (.6 m), so that two dancers cannot both be meant.
"""

REACH_M = 0.5
"""Distance from the last position within which a dancer is looked for [m]."""

REACH_M_S = 1.0
"""Growth of that distance with the time since the dancer was last seen [m/s] (assumed: nobody walks faster)."""

_NO_MATCH_COST = 1e6
"""Assignment cost of a person and a dancer who cannot have come there [m]: beyond any real distance."""


class IdentityAssigner:
    """Assigns dancers' names to the persons of all sensors.

    At the start each dancer is at its slot. Afterwards a name is assigned to the person whose position continues the
    path of the dancer, independently of the sensor and of the sensor's identity for the person. A person whose position
    no dancer can have reached has no name.

    Args:
        names: the dancers' names.
        slots_m: (D, 2) their positions at the start [m].
    """

    def __init__(self, names: Sequence[str], slots_m: Array) -> None:
        self._names = tuple(names)
        self._positions_m = [(float(x), float(y)) for x, y in slots_m]
        self._seen_s = [0.0] * len(self._names)
        self._indices: dict[str, dict[int, int]] = {}
        """Sensor -> sensor's identity of a person -> index of the dancer."""

    def cast_indices(self, sensor: str) -> Mapping[int, int]:
        """Return the mapping from a sensor's person identities to dancer indices; a change creates a new mapping."""
        return self._indices.get(sensor, {})

    def name(self, sensor: str, person: int) -> str | None:
        """Name of the dancer whom a sensor knows as ``person``; None if unknown."""
        index = self._indices.get(sensor, {}).get(person)
        return None if index is None else self._names[index]

    def person_id(self, sensor: str, name: str) -> int | None:
        """A sensor's own identity of a dancer; None if it has not seen them."""
        wanted = self._names.index(name)
        indices = self._indices.get(sensor, {})
        return next((person for person, index in indices.items() if index == wanted), None)

    def update(self, sensor: str, t_s: float, persons: Sequence[PersonStatus]) -> None:
        """Update names and positions with a sensor's report.

        Args:
            sensor: which sensor.
            t_s: session time of the report [s].
            persons: everyone it sees. A person whose position is not finite is treated as not seen.
        """
        indices = self._indices.get(sensor, {})
        if not self._all_in_place(indices, persons):
            persons = [person for person in persons if math.isfinite(person.x_m) and math.isfinite(person.y_m)]
            indices = self._indices[sensor] = self._reassign(indices, t_s, persons)

        for person in persons:
            index = indices.get(person.person)
            if index is not None:
                self._positions_m[index] = (person.x_m, person.y_m)
                self._seen_s[index] = t_s

    def _all_in_place(self, indices: Mapping[int, int], persons: Sequence[PersonStatus]) -> bool:
        """Whether every person has a name and is where that dancer was last seen. False if a position is NaN."""
        for person in persons:
            index = indices.get(person.person)
            if index is None or not self._distance_m(index, person) <= SAME_PLACE_M:
                return False
        return True

    def _reassign(self, indices: Mapping[int, int], t_s: float, persons: Sequence[PersonStatus]) -> dict[int, int]:
        """New indices of dancers for the persons that a sensor sees and those it has just lost."""
        assigned = [indices.get(person.person) for person in persons]
        moved = (
            index is None or self._distance_m(index, person) > SAME_PLACE_M
            for index, person in zip(assigned, persons, strict=True)
        )
        if any(moved):
            assigned = self._assign(t_s, persons)
        found = {person.person: index for index, person in zip(assigned, persons, strict=True) if index is not None}

        # A person just lost keeps the name for a while: one of their events may still be under way.
        for person_id, index in indices.items():
            if person_id not in found and index not in found.values():
                found[person_id] = index
        return found

    def _assign(self, t_s: float, persons: Sequence[PersonStatus]) -> list[int | None]:
        """Index of a dancer for each person, with the smallest sum of distances; None beyond every dancer's reach."""
        cost_m = np.full((len(persons), len(self._names)), _NO_MATCH_COST)
        # A cost beyond every distance instead of infinity, with which the solver would find no assignment at all.
        for row, person in enumerate(persons):
            for index in range(len(self._names)):
                reach_m = REACH_M + REACH_M_S * max(t_s - self._seen_s[index], 0.0)
                distance_m = self._distance_m(index, person)
                if distance_m <= reach_m:
                    cost_m[row, index] = distance_m

        assigned: list[int | None] = [None] * len(persons)
        for row, index in zip(*linear_sum_assignment(cost_m), strict=True):
            if cost_m[row, index] < _NO_MATCH_COST:
                assigned[int(row)] = int(index)
        return assigned

    def _distance_m(self, index: int, person: PersonStatus) -> float:
        """Distance between a person and the last position of a dancer [m]."""
        x_m, y_m = self._positions_m[index]
        return math.hypot(person.x_m - x_m, person.y_m - y_m)
