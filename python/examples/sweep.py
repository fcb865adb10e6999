"""The torque of a stirrer in shear-thinning fluids: a sweep over exponents and speeds."""
import isph

SCENE = dict(case="scene", n=20, motion="eulerian", t_end=0.4, rheology="carreau", viscosity=1.0, rheology_time=1.0,
             rheology_viscosity_infinite=0.01, scene_body_1="circle,0.5,0.5,0.2")


def torque(flow):
    """Returns the torque that turns the stirrer, and its error bar [N m/m]."""
    force = flow.force("body_1")
    return {"torque": -force.torque[2], "error": force.error[1]}


if __name__ == "__main__":
    print(isph.study(**SCENE, rheology_exponent=[0.4, 0.7, 1.0], scene_body_1_rotation=[1.0, 4.0], measure=torque))
