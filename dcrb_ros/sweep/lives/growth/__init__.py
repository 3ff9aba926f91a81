"""Laws of growing damage; a file with a subclass of `Growth` and a line here add one."""

from collections.abc import Mapping

from dcrb_ros.sweep.lives.growth.exponential import ExponentialGrowth
from dcrb_ros.sweep.lives.growth.gamma_process import GammaGrowth
from dcrb_ros.sweep.lives.growth.law import Growth
from dcrb_ros.sweep.lives.growth.paris import ParisGrowth

GROWTH_LAWS: Mapping[str, type[Growth]] = {"paris": ParisGrowth, "exponential": ExponentialGrowth, "gamma": GammaGrowth}
"""Laws by the value of ``growth.law``."""

__all__ = ["GROWTH_LAWS", "Growth"]
