"""What a user can say about a recording."""

from __future__ import annotations

import dataclasses

OPTIONS = {
    "--topic": "topic of the clouds in a bag; not needed where there is one",
}
"""Options of the command that readers take, by flag: an attribute of Options each."""


@dataclasses.dataclass
class Options:
    sensor: str = ""
    topic: str | None = None
