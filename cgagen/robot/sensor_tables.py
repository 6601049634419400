"""The tables of a robot file that say what it senses with."""

from cgagen.counts import CURVE_SEGMENTS
from cgagen.robot.table import LAST_PIN, Table
from cgagen.robot.values import (
    SIDES,
    SONAR_KINDS,
    SONARS,
    Antenna,
    Light,
    LightSensor,
    Sonar,
)
from cgagen.words import Role

MODES = ("ground", "open")
"""Of an SRF04's mode pin."""

FARTHEST_IN = 300.0
"""More than any sonar of the two kinds can see, twice over."""


def sonars_of(top: Table, role: Role) -> tuple[Sonar, ...]:
    """Return all sonars, in the order of `SONARS`."""
    sonars = []
    for name, table in _in_order(top.tables("sonar"), SONARS[role], top, "sonar"):
        kind = table.text("kind", tuple(SONAR_KINDS))
        sonars.append(
            Sonar(
                name=name,
                kind=kind,
                bearing_deg=table.number("bearing_deg", -360, 360),
                cone_deg=table.number("cone_deg", 1, 170),
                range_in=table.number("range_in", 1, FARTHEST_IN),
                pins=tuple(table.integer(key, 0, LAST_PIN) for key in SONAR_KINDS[kind].pins),
                mode=_mode(table) if kind == "srf04" else "",
            )
        )
        table.done()
    return tuple(sonars)


def _mode(table: Table) -> str:
    return table.text("mode", MODES) if table.has("mode") else ""


def antennas_of(top: Table) -> tuple[Antenna, ...]:
    """Return both antennas, left and right."""
    antennas = []
    for name, table in _in_order(top.tables("antenna"), SIDES, top, "antenna"):
        antennas.append(
            Antenna(
                name=name,
                bearing_deg=table.number("bearing_deg", -360, 360),
                length_in=table.number("length_in", 0.1, FARTHEST_IN),
                robot_deg=table.pair("robot_deg", -180, 180),
                pin=table.integer("pin", 0, LAST_PIN),
            )
        )
        table.done()
    return tuple(antennas)


def light_of(table: Table) -> Light:
    """Return the light sensors, each with its curve; one for both is an earlier version's."""
    common = _curve(table) if table.offers("curve") else None
    sensors = []
    for name, one in _in_order(table.tables("sensor"), SIDES, table, "sensor"):
        sensors.append(
            LightSensor(
                name=name,
                bearing_deg=one.number("bearing_deg", -360, 360),
                cone_deg=one.number("cone_deg", 1, 170),
                pin=one.integer("pin", 0, LAST_PIN),
                curve=_curve(one) if common is None or one.offers("curve") else common,
            )
        )
        one.done()
    light = Light(
        condition=table.text("condition", ("dark", "ambient")),
        dark_range_in=table.number("dark_range_in", 1, FARTHEST_IN),
        ambient_range_in=table.number("ambient_range_in", 1, FARTHEST_IN),
        capacitor_uf=table.number("capacitor_uf", 0.0001, 10),
        charge_ms=table.integer("charge_ms", 1, 1000),
        sensors=tuple(sensors),
    )
    table.done()
    return light


def _curve(table: Table) -> tuple[tuple[float, int], ...]:
    wanted = f"2 to {CURVE_SEGMENTS + 1} pairs [inches, count 1 to 65535], both rising"
    value = table.take("curve", wanted)
    rows = value if isinstance(value, list) else []
    points: list[tuple[float, int]] = []
    for row in rows:
        match row:
            case [int() | float() as inches, int() as count] if (
                not isinstance(inches, bool)
                and not isinstance(count, bool)
                and 0 <= inches <= FARTHEST_IN
                and 1 <= count <= 65_535
                and (not points or (inches > points[-1][0] and count > points[-1][1]))
            ):
                points.append((float(inches), count))
            case _:
                raise table.error("curve", f"{row!r} does not fit; wanted {wanted}")
    if not 2 <= len(points) <= CURVE_SEGMENTS + 1:
        raise table.error("curve", f"{len(points)} pairs; wanted {wanted}")
    return tuple(points)


def _in_order(
    tables: list[Table], names: tuple[str, ...], top: Table, key: str
) -> list[tuple[str, Table]]:
    """Return the tables in the order of the names; each name once, and no other."""
    found: dict[str, Table] = {}
    for table in tables:
        name = table.text("name", names)
        if name in found:
            raise table.error("name", f"{name!r} stands twice; each of {', '.join(names)} once")
        found[name] = table
    for name in names:
        if name not in found:
            raise top.error(key, f"{name!r} is missing; wanted {', '.join(names)}")
    return [(name, found[name]) for name in names]
