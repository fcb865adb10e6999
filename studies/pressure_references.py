#!/usr/bin/env python3
"""Computes the references of studies/pressure that no paper has, by finite elements: steady flows in 2D, and with rotation
about an axis.

    studies/pressure_references.py [FLOW ...]

Prints forces and torques of the fluid on the bodies, and writes the velocity in the round vessel on a grid of points to
cases/reference/turning_lid_re100.csv. Taylor and Hood's elements (velocity of degree 2, pressure of degree 1), Newton's
method, a mesh of triangles that is finer at bodies and corners, and a second one with 1.5 times as many sides: their
difference is printed. A force is the reaction of a body's nodes, tested by a field that is the motion of a rigid body there
and 0 on other boundaries (V. John, Int. J. Numer. Meth. Fluids 25 (1997) 777-797). Needs Debian's freefem++."""
import math
import os
import subprocess
import sys
import tempfile

SOLVE = """
fespace V(Th, P2); fespace Q(Th, P1);
V u, v, du, dv, a, b, ex, ey; Q p, dp, q; real change = 1; int step;
for (step = 0; step < 30 && change > 1e-11; step++) {
  solve Newton([du, dv, dp], [a, b, q]) =
    int2d(Th)(nu * (dx(du)*dx(a) + dy(du)*dy(a) + dx(dv)*dx(b) + dy(dv)*dy(b)) - dp * (dx(a) + dy(b)) - q * (dx(du) + dy(dv))
      - EPS * dp * q + CONV * ((u*dx(du) + v*dy(du) + du*dx(u) + dv*dy(u)) * a + (u*dx(dv) + v*dy(dv) + du*dx(v) + dv*dy(v)) * b))
    - int2d(Th)(CONV * ((u*dx(u) + v*dy(u)) * a + (u*dx(v) + v*dy(v)) * b)) + on(1, du = U1, dv = V1) + on(2, du = 0, dv = 0)
    + on(3, du = U3, dv = V3) + on(4, du = U4, dv = V4) + on(11, du = U11, dv = V11) + on(12, du = U12, dv = V12)
    + on(13, du = 0, dv = 0);
  V cu = du - u, cv = dv - v; change = max(cu[].linfty, cv[].linfty); u = du; v = dv; p = dp;
}
cout << "result steps " << step << endl; cout << "result unknowns " << 2 * V.ndof + Q.ndof << endl;
func real reaction(real[int] & vx, real[int] & vy) {
  a[] = vx; b[] = vy;
  return -int2d(Th)(nu * (2*dx(u)*dx(a) + 2*dy(v)*dy(b) + (dy(u) + dx(v)) * (dy(a) + dx(b))) - p * (dx(a) + dy(b))
    + CONV * ((u*dx(u) + v*dy(u)) * a + (u*dx(v) + v*dy(v)) * b));
}
V one, zero = 0; real[int] X = [X11, X12, X13], Y = [Y11, Y12, Y13];
for (int k = 11; k <= 13; k++) {
  varf Mark(f, g) = on(k, f = 1); one[] = Mark(0, V, tgv = 1);
  if (one[].max < 0.5) continue;
  real fx = reaction(one[], zero[]), fy = reaction(zero[], one[]);
  ex = -(y - Y[k - 11]) * one; ey = (x - X[k - 11]) * one;
  cout.precision(9);
  cout << "result body_" << k - 10 << "_fx " << fx << endl; cout << "result body_" << k - 10 << "_fy " << fy << endl;
  cout << "result body_" << k - 10 << "_torque " << reaction(ex[], ey[]) << endl;
}
"""
# u radial, v axial, w around; x is the radius. Velocities on a grid of points.
AXIAL = """
fespace V(Th, P2); fespace Q(Th, P1);
V u, v, w, du, dv, dw, a, b, c; Q p, dp, q; real change = 1; int step;
for (step = 0; step < 30 && change > 1e-11; step++) {
  solve Newton([du, dv, dw, dp], [a, b, c, q]) =
    int2d(Th)(x * (nu * (dx(du)*dx(a) + dy(du)*dy(a) + du*a/x^2 + dx(dv)*dx(b) + dy(dv)*dy(b) + dx(dw)*dx(c) + dy(dw)*dy(c) + dw*c/x^2)
      - dp * (dx(a) + a/x + dy(b)) - q * (dx(du) + du/x + dy(dv)) - 1e-9 * dp * q
      + (u*dx(du) + v*dy(du) + du*dx(u) + dv*dy(u) - 2*w*dw/x) * a + (u*dx(dv) + v*dy(dv) + du*dx(v) + dv*dy(v)) * b
      + (u*dx(dw) + v*dy(dw) + du*dx(w) + dv*dy(w) + (u*dw + du*w)/x) * c))
    - int2d(Th)(x * ((u*dx(u) + v*dy(u) - w*w/x) * a + (u*dx(v) + v*dy(v)) * b + (u*dx(w) + v*dy(w) + u*w/x) * c))
    + on(5, du = 0, dw = 0) + on(2, du = 0, dv = 0, dw = 0) + on(4, du = 0, dv = 0, dw = x / 0.5);
  V cu = du - u, cv = dv - v, cw = dw - w; change = max(max(cu[].linfty, cv[].linfty), cw[].linfty); u = du; v = dv; w = dw; p = dp;
}
cout << "result steps " << step << endl; cout << "result unknowns " << 3 * V.ndof + Q.ndof << endl; cout.precision(9);
for (int i = 1; i <= 9; i++) for (int j = 1; j <= 9; j++)
  cout << "point " << 0.05 * i << " " << 0.1 * j << " " << u(0.05 * i, 0.1 * j) << " " << v(0.05 * i, 0.1 * j) << " " << w(0.05 * i, 0.1 * j) << endl;
"""
FLOWS = {}


def side(x0, y0, x1, y1, label, sides, crowd=False):
    """Returns a side of the mesh's outline, with points that crowd at both ends where it ends in corners."""
    return (x0, y0, x1, y1), label, sides, crowd


def outline(x0, y0, x1, y1, labels, density):
    """Returns the sides of a box with the fluid inside: bottom, right, top, left."""
    corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    return [side(*corners[k], *corners[(k + 1) % 4], labels[k], math.ceil(density * math.dist(corners[k], corners[(k + 1) % 4])))
            for k in range(4)]


def mesh(sides, circles):
    """Returns FreeFem's text of the mesh of an outline, polygons and circles; fluid is left of a side."""
    text, parts = "", []
    for k, ((x0, y0, x1, y1), label, count, crowd) in enumerate(sides):
        at = "0.5*(1-cos(pi*t))" if crowd else "t"
        text += f"border s{k}(t=0,1){{x={x0}+({x1 - x0})*{at};y={y0}+({y1 - y0})*{at};label={label};}}\n"
        parts.append(f"s{k}({count})")
    for k, (x, y, r, label, count) in enumerate(circles):
        turn = 2 * math.pi / abs(count)
        r *= math.sqrt(turn / math.sin(turn))  # the polygon has the area of the circle
        text += f"border c{k}(t=0,2*pi){{x={x}+{r}*cos(t);y={y}+{r}*sin(t);label={label};}}\n"
        parts.append(f"c{k}({count})")
    return text + f"mesh Th = buildmesh({' + '.join(parts)});\n"


def box_sides(x0, y0, x1, y1, label, density):
    """Returns the sides of a body that is a box, the fluid outside."""
    corners = [(x0, y0), (x0, y1), (x1, y1), (x1, y0)]
    return [side(*corners[k], *corners[(k + 1) % 4], label, math.ceil(density * math.dist(corners[k], corners[(k + 1) % 4])), True)
            for k in range(4)]


def flow(name):
    """Adds a function that returns the text of a mesh and the words of a flow, for a factor of the number of sides."""
    def add(function):
        FLOWS[name] = function
        return function
    return add


def channel(m, length, height, circles, density, nu, profile):
    """Returns a channel with circles; the inflow is side 1, the outflow has no label of a condition."""
    text = mesh(outline(0, 0, length, height, (2, 9, 2, 1), density * m),
                [(x, y, r, 11 + k, -math.ceil(count * m)) for k, (x, y, r, count) in enumerate(circles)])
    words = {"nu": nu, "U1": profile, "EPS": 0}
    for k, (x, y, _, _) in enumerate(circles):
        words |= {f"X{11 + k}": x, f"Y{11 + k}": y}
    return text, words


@flow("cylinders")
def cylinders(m):
    return channel(m, 3.5, 1.5, [(0.8, 0.75, 0.15, 100), (1.7, 0.45, 0.15, 100), (1.7, 1.05, 0.15, 100)], 20, 0.05, "8./3*y*(1.5-y)")


@flow("dfg")
def dfg(m):
    return channel(m, 2.2, 0.41, [(0.2, 0.2, 0.05, 120)], 70, 1e-3, "1.2*y*(0.41-y)/0.41^2")


@flow("dfg_short")
def dfg_short(m):
    return channel(m, 1.1, 0.41, [(0.2, 0.2, 0.05, 120)], 70, 1e-3, "1.2*y*(0.41-y)/0.41^2")


@flow("square")
def square(m):
    text = mesh(outline(0, 0, 1, 1, (3, 2, 4, 2), 40 * m) + box_sides(0.3, 0.3, 0.7, 0.7, 11, 120 * m), [])
    return text, {"nu": 0.05, "U3": "-8*x^2*(1-x)^2", "U4": "16*x^2*(1-x)^2", "X11": 0.5, "Y11": 0.5, "EPS": 1e-9}


@flow("mixer")
def mixer(m):
    text = mesh(box_sides(-0.6, -0.15, 0.6, 0.15, 11, 100 * m), [(0, 0, 1, 12, math.ceil(300 * m))])
    return text, {"nu": 0.1, "U12": "-y", "V12": "x", "EPS": 1e-9}


@flow("vessel")
def vessel(m):
    sides = [side(0, 0, 0.5, 0, 2, math.ceil(40 * m)), side(0.5, 0, 0.5, 1, 2, math.ceil(80 * m), True),
             side(0.5, 1, 0, 1, 4, math.ceil(40 * m)), side(0, 1, 0, 0, 5, math.ceil(60 * m))]
    return mesh(sides, []), {"nu": 0.01}


def solve(name, m):
    """Returns the results of a flow on a mesh, and the values at points."""
    text, words = FLOWS[name](m)
    zero = [f"{letter}{k}" for letter in "UVXY" for k in (1, 3, 4, 11, 12, 13)]
    words = {**dict.fromkeys(zero, 0), "CONV": 1, **words}
    text = "".join(f"func {key} = {value};\n" if key[0] in "UV" else f"real {key} = {value};\n" for key, value in words.items()) + text
    with tempfile.NamedTemporaryFile("w", suffix=".edp") as file:
        file.write(text + (AXIAL if name == "vessel" else SOLVE))
        file.flush()
        done = subprocess.run(["FreeFem++", "-nw", "-v", "0", file.name], capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"{name}: {done.stdout[-2000:]}{done.stderr}")
    lines = [line.split() for line in done.stdout.splitlines()]
    return ({line[1]: float(line[2]) for line in lines if line[:1] == ["result"]},
            [[float(word) for word in line[1:]] for line in lines if line[:1] == ["point"]])


def main():
    for name in sys.argv[1:] or FLOWS:
        (coarse, few), (fine, many) = solve(name, 1), solve(name, 1.5)
        print(name)
        for key, value in fine.items():
            print(f"  {key} {value:.8g} +- {abs(value - coarse[key]):.1e}")
        if many:
            error = max(abs(a - b) for one, other in zip(few, many) for a, b in zip(one, other))
            print(f"  points differ by {error:.1e}")
            path = os.path.join(os.path.dirname(os.path.dirname(os.path.realpath(__file__))), "cases", "reference", "turning_lid_re100.csv")
            with open(path, "w", encoding="utf-8") as file:
                file.write("# Round vessel of radius 0.5 and height 1, its lid z = 1 turning with the speed 1 at the rim, Re = 100, steady: velocity\n"
                           f"# along r, z and around. By studies/pressure_references.py; meshes differ by {error:.0e}.\nr,z,u_r,u_z,u_around\n")
                file.writelines(",".join(f"{number:.7g}" for number in row) + "\n" for row in many)


if __name__ == "__main__":
    main()
