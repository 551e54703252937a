import pytest

from aeb_sumo.drivers import profile
from aeb_sumo.drivers.lapses import Glances
from aeb_sumo.drivers.reactions import Careful, Looming, Zheng, trucks
from aeb_sumo.errors import InputError


@pytest.mark.parametrize("name", profile.names())
def test_every_packaged_profile_loads_and_says_what_it_is(name):
    assert profile.load(name).name == name
    assert profile.text(name).startswith("# ")


def test_models_are_chosen_by_name():
    assert profile.load("careful").cars == Careful()
    assert profile.load("classes").cars == Zheng()
    assert profile.load("attentive").cars == Looming()
    assert profile.load("distracted").trucks == trucks()


def test_sumo_is_nothing_at_all():
    assert profile.load("sumo") == profile.Profile()


def test_a_copy_with_a_change(tmp_path):
    mine = tmp_path / "mine.toml"
    mine.write_text(profile.text("highway").replace("share = 0.18", "share = 0.3"))
    loaded = profile.load(str(mine))
    assert loaded.glances == Glances(share=0.3)
    assert loaded.hard_braking == profile.load("highway").hard_braking


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[glance]\n", "unknown section 'glance'; there are: glances, hard_braking, cars"),
        ("[glances]\nshares = 0.2\n", "Glances has no parameter 'shares'; there are: median, over_two, share"),
        ("[glances]\nshare = 1.5\n", "Glances.share must be within 0 .. 0.9, not 1.5"),
        ('[glances]\nshare = "a"\n', "Glances.share must be a number, not 'a'"),
        ("glances = 3\n", "glances must be a section, [glances], not a value"),
        ('[cars]\nmodel = "perfect"\n', "unknown model 'perfect' in [cars]; there are: looming, careful, zheng2020"),
        ("[failure_to_yield]\nprobability = 2\n", "FailureToYield.probability must be within 0 .. 1, not 2"),
        ("[glances\n", "is no TOML"),
    ],
)
def test_bad_profiles_are_named(tmp_path, text, message):
    mine = tmp_path / "mine.toml"
    mine.write_text(text)
    with pytest.raises(InputError) as error:
        profile.load(str(mine))
    assert message in str(error.value)
    assert str(mine) in str(error.value)


def test_unknown_profiles_are_named():
    with pytest.raises(InputError, match="unknown driver profile 'drunk'; there are: attentive, careful"):
        profile.load("drunk")
    with pytest.raises(InputError, match=r"cannot read the parameter file nowhere\.toml"):
        profile.load("nowhere.toml")
