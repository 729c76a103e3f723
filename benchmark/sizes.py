"""Models of K09's brake with fewer and with more modes than it keeps, for the benchmarks."""

from dataclasses import replace

from squeal_core.audit import truncated
from squeal_core.brake_file import read_brake
from squeal_core.brake_model import BrakeModel
from squeal_core.build import build_model
from squeal_core.resources import config_folder


def sized(count: int) -> BrakeModel:
    """Return a model of about so many modes; doublets stay whole."""
    shipped = BrakeModel.load('kang2009')
    if count <= shipped.size:
        return replace(truncated(shipped, count / shipped.size), caliper=shipped.caliper,
                       friction_law=shipped.friction_law)
    brake = read_brake(config_folder() / 'brakes' / 'kang2009.yaml')
    share = count / shipped.size
    more = replace(brake, disc_modes=round(share * brake.disc_modes),
                   pad_modes=round(share * brake.pad_modes))
    return build_model(more)
