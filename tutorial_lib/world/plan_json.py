"""Floor plans on disk: JSON with a schema version, and errors that name the field."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from tutorial_lib.errors import InputError
from tutorial_lib.files import write_text
from tutorial_lib.reading.documents import parse_json
from tutorial_lib.reading.limits import MAX_JSON
from tutorial_lib.reading.regular import read_text
from tutorial_lib.validation import instance, path_of
from tutorial_lib.world.fields import Field
from tutorial_lib.world.floorplan import Door, FloorPlan, Furniture, Room
from tutorial_lib.world.materials import Colour, Look, Material, Stripe
from tutorial_lib.world.occupancy import check_closed

SCHEMA = 1


def save_plan(plan: FloorPlan, path: str | Path) -> None:
    """Write `plan` to a JSON file, whole or not at all."""
    write_text(path_of("path", path), plan_to_json(plan))


def load_plan(path: str | Path) -> FloorPlan:
    """Read a floor plan from a JSON file and check that its rooms are closed.

    Raises:
        InputError: when the file is missing or malformed, or a room is open to the outside.
    """
    text = read_text(path_of("path", path), MAX_JSON, "give a floor plan's JSON file")
    plan = plan_from_json(text, where=Path(path).name)
    check_closed(plan)
    return plan


def plan_to_json(plan: FloorPlan) -> str:
    """The plan as JSON text, a line for each wall; equal plans give equal text."""
    instance("plan", plan, FloorPlan)
    sections: dict[str, Any] = {
        "schema": SCHEMA,
        "family": plan.family,
        "seed": plan.seed,
        "look": {
            "palette": plan.look.palette,
            "floor": plan.look.floor,
            "ceiling": plan.look.ceiling,
            "gamma": plan.look.gamma,
            "noise": plan.look.noise,
        },
    }
    lists: dict[str, list[dict[str, Any]]] = {
        "materials": [
            {
                "name": m.name,
                "colour": m.colour,
                "stripes": [[s.start, s.end, *s.colour] for s in m.stripes],
            }
            for m in plan.materials
        ],
        "rooms": [{"kind": r.kind, "outline": r.outline} for r in plan.rooms],
        "doors": [{"from": d.start, "to": d.end, "rooms": d.rooms} for d in plan.doors],
        "walls": [
            {"from": w[:2], "to": w[2:], "material": name, "offset": offset}
            for w, name, offset in zip(
                plan.walls.tolist(), plan.wall_materials, plan.wall_offsets.tolist(), strict=True
            )
        ],
        "furniture": [
            {"kind": f.kind, "outline": f.outline, "material": f.material} for f in plan.furniture
        ],
    }
    parts = [f"{json.dumps(key)}: {json.dumps(value)}" for key, value in sections.items()]
    for key, rows in lists.items():
        body = ",\n  ".join(json.dumps(row) for row in rows)
        parts.append(f"{json.dumps(key)}: [\n  {body}\n ]" if rows else f"{json.dumps(key)}: []")
    return "{\n " + ",\n ".join(parts) + "\n}\n"


def plan_from_json(text: str, where: str = "JSON text") -> FloorPlan:
    """Read a floor plan from JSON text.

    Raises:
        InputError: naming the field that is wrong.
    """
    instance("text", text, str)
    instance("where", where, str)
    root = Field(parse_json(text, where, "was the file cut off?"), where)
    if root["schema"].whole() != SCHEMA:
        raise root["schema"].fail(f"this version reads schema {SCHEMA}")
    try:
        return _plan(root)
    except InputError as error:
        if str(error).startswith(where):  # a field's names the file itself
            raise
        raise InputError(f"{where}: {error}") from error


def _plan(root: Field) -> FloorPlan:
    walls = list(root["walls"])
    return FloorPlan(
        family=root["family"].text(),
        seed=root["seed"].whole(),
        walls=np.array([w["from"].point() + w["to"].point() for w in walls]).reshape(-1, 4),
        wall_materials=tuple(w["material"].text() for w in walls),
        wall_offsets=np.array([w["offset"].number() for w in walls]),
        materials=tuple(_material(m) for m in root["materials"]),
        rooms=tuple(Room(r["kind"].text(), r["outline"].points()) for r in root["rooms"]),
        doors=tuple(_door(d) for d in root["doors"]),
        furniture=tuple(
            Furniture(f["kind"].text(), f["outline"].points(), f["material"].text())
            for f in root["furniture"]
        ),
        look=_look(root["look"]),
    )


def _material(entry: Field) -> Material:
    stripes = []
    for row in entry["stripes"]:
        start, end, *_ = row.numbers(5)
        red, green, blue = (channel.whole() for channel in list(row)[2:])
        stripes.append(Stripe(start, end, (red, green, blue)))
    return Material(entry["name"].text(), _colour(entry["colour"]), tuple(stripes))


def _door(entry: Field) -> Door:
    rooms = entry["rooms"]
    rooms.numbers(2)
    first, second = (room.whole() for room in rooms)
    return Door(entry["from"].point(), entry["to"].point(), (first, second))


def _look(entry: Field) -> Look:
    return Look(
        entry["palette"].text(),
        _colour(entry["floor"]),
        _colour(entry["ceiling"]),
        entry["gamma"].number(),
        entry["noise"].number(),
    )


def _colour(entry: Field) -> Colour:
    entry.numbers(3)
    red, green, blue = (channel.whole() for channel in entry)
    return red, green, blue
