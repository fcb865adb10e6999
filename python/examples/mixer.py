"""The speed of a mixer for the least energy of a batch: its drive, and a constant load of 0.4 W/m until the dye is even.

A slow mixer takes long, a fast one takes power: P = torque times spin. Dye fills one half of the vessel at the start.
"""
import isph
from scipy.optimize import minimize_scalar

LOAD, EVEN = 0.4, 0.5  # [W/m]; the deviation of the dye at the end over that at the start


def batch(spin, n=16):
    """Returns the energy [J/m] and the time [s] until the dye is even."""
    spent = {"energy": 0.0}
    with isph.Flow(case="scene", n=n, viscosity=0.05, t_end=20, scene_body_1="box,0.2,0.45,0.8,0.55",
                   scene_body_1_rotation=spin, scene_scalar_1_name="dye", scene_scalar_1_diffusivity=2e-3,
                   scene_scalar_1_start=lambda x: float(x > 0.5)) as flow:
        def after(flow):
            spent["energy"] += flow.dt * (LOAD - spin * flow.force("body_1").torque[2])
            return flow["dye"].std() < EVEN * spent["start"]
        spent["start"] = flow["dye"].std()
        flow.run(each=after)
        return spent["energy"], flow.t


if __name__ == "__main__":
    best = minimize_scalar(lambda spin: batch(spin)[0], bounds=(0.5, 6.0), method="bounded", options={"xatol": 0.1})
    print(f"least energy {best.fun:.3f} J/m at {best.x:.2f} rad/s, in {best.nfev} batches")
