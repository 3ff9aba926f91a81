"""The geometry of the contacts: the numbers of Table 1 of Fan et al. 2025, with the formulas of Hertz and Johnson."""

from __future__ import annotations

import math

import pytest

from dcrb_ros.core.laws.site import Site, inner_site, outer_site, pair_site
from dcrb_ros.settings.configuration import Configuration
from dcrb_ros.settings.loaded_contacts import material_of

pytestmark = pytest.mark.kernel

MATERIAL = material_of(Configuration().bearing)


@pytest.mark.parametrize(
    ("site", "reduced", "distance"),
    [
        # 1/R is 1/15 mm and 1/78.86 mm, less 1/109.14 mm, or 1/15 mm twice; the distances of the centres are 93.86, 94.14 and 30 mm.
        (inner_site(MATERIAL), 12.603e-3, 93.86e-3),
        (outer_site(MATERIAL), 17.390e-3, 94.14e-3),
        (pair_site(MATERIAL), 7.5e-3, 30e-3),
    ],
    ids=["inner", "outer", "pair"],
)
def test_a_contact_has_the_radius_the_width_and_the_scale_of_its_bodies(site: Site, reduced: float, distance: float) -> None:
    assert site.reduced_radius == pytest.approx(reduced, rel=1e-4)
    assert site.scale == pytest.approx(4.0 * distance, rel=1e-4)
    # Hertz: b^2 = 4 F R / (pi L E*) with 48 mm and 114.01 GPa.
    assert site.width == pytest.approx(4.0 * reduced / (math.pi * 0.048 * 114.01e9), rel=1e-4)
