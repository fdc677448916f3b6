"""Box2D's adapter; `adapters.box2d.adapter` describes it."""

from .adapter import *  # noqa: F403
from .adapter import __all__  # noqa: F401
