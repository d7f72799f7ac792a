"""A campaign without a file: a scenario, and what of it the command line varies."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from heave_node.files.bounded_yaml import YamlError, parse_yaml
from heave_node.parameters import ParameterError

from heave_bringup.campaign.plan import Campaign, Link
from heave_bringup.settings import make_setting

VARY = "--vary"


def campaign_of(scenario: str, vary: Sequence[str]) -> Campaign:
    """Return the campaign of every combination of the values in `vary` in a `scenario`.

    Parameters
    ----------
    scenario : shipped name or file
    vary : texts PLACE=VALUE,VALUE,...; the values in YAML, as `--set` takes them

    Raises ParameterError for another form, a place that is none, and the same place twice.
    """
    links = [_link(text) for text in vary]
    places = [place for link in links for place in link]
    for place in places:
        if places.count(place) > 1:
            raise ParameterError(f"{VARY} {place}: stands twice; give all its values once, separated by commas")
    return Campaign(path=Path(VARY), scenario=scenario, vary=tuple(links))


def _link(text: str) -> Link:
    place, separator, values = text.partition("=")
    source = f"{VARY} {text}"
    if not separator or not values.strip():
        raise ParameterError(f"{source}: must be NODE.PARAM=VALUE,VALUE,... such as winch_controller.law=off,lqg,mpc")
    try:
        found = parse_yaml(f"[{values}]", only_true_and_false=True)
    except YamlError as error:
        raise ParameterError(f"{source}: {values!r} is not a list of YAML values: {error}") from error
    make_setting(place, found[0], source)
    return {place: tuple(found)}


def with_settings(campaign: Campaign, settings: Sequence[str]) -> dict[str, object]:
    """Return what is common to every case of a `campaign` with the `settings` of the command line, PLACE=VALUE each."""
    common = dict(campaign.common)
    for text in settings:
        place, separator, value = text.partition("=")
        if not separator:
            raise ParameterError(f"--set {text}: must be NODE.PARAM=VALUE, for example system.sea.peak_period=9")
        try:
            common[place] = parse_yaml(value, only_true_and_false=True)
        except YamlError as error:
            raise ParameterError(f"--set {text}: {value!r} is not a YAML value: {error}") from error
    return common
