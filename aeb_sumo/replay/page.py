"""The page of a replay: one file of HTML that needs nothing else."""

from importlib.resources import files

from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

from aeb_sumo.replay.data import data
from aeb_sumo.replay.story import story
from aeb_sumo.replay.take import Take

__all__ = ["page"]


def page(take: Take) -> str:
    """The page. The same take makes the same page, byte by byte."""
    here = files(__package__)
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    # `tojson` writes < > & \' as escapes, so that no name can end the script.
    environment.policies["json.dumps_kwargs"] = {"sort_keys": True, "separators": (",", ":"), "allow_nan": False}
    template = environment.from_string((here / "page.html.jinja").read_text(encoding="utf-8"))
    css, view, play = (
        Markup((here / name).read_text(encoding="utf-8"))  # noqa: S704 - our own
        for name in ("page.css", "view.js", "play.js")
    )
    return template.render(story=story(take), data=data(take), css=css, js=view + play)
