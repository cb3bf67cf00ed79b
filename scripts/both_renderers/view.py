"""What both renderers must do."""

import dataclasses


@dataclasses.dataclass
class View:
    """A scene file with a camera, and what both renderers must do with it."""

    scene: str
    eye: list
    look_at: list
    up: list = dataclasses.field(default_factory=lambda: [0.0, 1.0, 0.0])
    fov: float = 45.0
    size: list = dataclasses.field(default_factory=lambda: [128, 128])
    lens_radius: float = 0.0
    focus_distance: float = 1.0
    environment: str | None = None
    # Tables of `[[light]]`, as docs/scene-format.md documents them.
    lights: list = dataclasses.field(default_factory=list)
    max_depth: int = 8
    # Mitsuba's samples for each of Tamis's, where it is that much noisier.
    mitsuba_samples: int = 1
