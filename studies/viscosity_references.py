#!/usr/bin/env python3
"""Computes the references of studies/viscosity that have no closed form, by finite elements: steady flows without inertia.

    studies/viscosity_references.py [REGEX]

Writes studies/viscosity_references/<flow>.csv: velocity and pressure at points; its head has forces, the kinetic energy, the largest
stream function and its place. Taylor and Hood's elements; with interfaces, where the pressure jumps, velocity of degree 2
with a bubble and pressure of degree 1 that jumps between triangles (M. Crouzeix & P.-A. Raviart, RAIRO R3 (1973) 33-75), and
sides of triangles lie on interfaces.
Newton's method with the exact derivative of the law, from small regularisation to the last by factors of 3. Three
meshes, each 1.5 times as fine as the one before, which gives its start; the values are those of the finest, and the head of a file has their differences
from the second. A force is the reaction of a body's nodes (V. John, Int. J. Numer. Meth. Fluids 25 (1997) 777-797).
Needs Debian's freefem++."""
import os
import re
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
RATIOS = ("1e-6", "1e-3", "1e-1", "1e1", "1e3", "1e6")
YIELDS = ("1", "10", "100", "1000")
MESHES = (0.3, 0.45, 0.675)  # density of the sides
FINER = (0.5, 0.75, 1.125)  # of cavities
NEAR = 0.045  # of an interface: no points
HEAD = """
fespace V(Th, ELEMENT); fespace Q(Th, PRESSURE); fespace W(Th, P2);
V u = 0, v = 0, du, dv, a, b, cu, cv, ou, ov, one, zero; Q p, dp, q; W psi, test; real moved = 1, m = FIRST; int step, total = 0;
macro G2() (2*(dx(u)^2 + dy(v)^2) + (dy(u) + dx(v))^2) //
macro G() sqrt(G2 + 1e-24) //
macro NU() (LAW) //
macro SLOPE() (DERIVATIVE) //
macro ENERGY() (POTENTIAL) //
macro EE(a, b, c, d) (dx(a)*dx(c) + dy(b)*dy(d) + 0.5*(dy(a) + dx(b))*(dy(c) + dx(d))) //
"""
SOLVE = """
for (total = 0; true; m = min(3*m, 1.*LAST)) {
  moved = 1;
  for (step = 0; step < 80 && moved > (m < LAST ? 0.02 : 1e-8); step++) {
    real newton = total > 0;
    solve Newton([du, dv, dp], [a, b, q], solver = UMFPACK) =
      int2d(Th)(2*NU*EE(du, dv, a, b) + newton*8*SLOPE*EE(u, v, du, dv)*EE(u, v, a, b) - dp*(dx(a) + dy(b)) - q*(dx(du) + dy(dv)) - EPS*dp*q)
      - int2d(Th)(newton*8*SLOPE*EE(u, v, u, v)*EE(u, v, a, b))
      + on(1, du = U1, dv = 0) + on(2, du = 0, dv = 0) + on(3, du = 1, dv = 0) + on(9, dv = 0) + on(11, du = 0, dv = 0);
    cu = du - u; cv = dv - v; ou = u; ov = v; moved = max(cu[].linfty, cv[].linfty); p = dp;
    real before = int2d(Th)(ENERGY), share = 1;  // the solution is its minimum: halve steps that do not lessen it
    u = du; v = dv;
    for (int k = 0; newton > 0 && k < 30 && moved > 1e-7 && int2d(Th)(ENERGY) > before; k++) {
      share = share/2; u = ou + share*cu; v = ov + share*cv; }
    total++;
    if (TRACE) cout << "trace " << m << " " << step << " " << moved << " " << share << endl;
    if (!NONLINEAR) break;
  }
  if (!NONLINEAR || m >= LAST) break;
}
cout.precision(9); cout << "mesh" << endl;
cout << "result solves " << total << endl << "result change " << (NONLINEAR ? moved : 0) << endl;
cout << "result unknowns " << 2*V.ndof + Q.ndof << endl << "result kinetic_energy " << int2d(Th)(0.5*(u^2 + v^2)) << endl;
real mean = int2d(Th)(p)/int2d(Th)(1.);
if (EPS > 0) p = p - mean;
if (BODY) {
  varf Mark(f, g) = on(11, f = 1); zero = 0; one = 0; one[] = Mark(0, V, tgv = 1);
  cout << "result body_1_fx " << -int2d(Th)(2*NU*EE(u, v, one, zero) - p*dx(one)) << endl;
}
if (STREAM) {
  solve Stream(psi, test) = int2d(Th)(dx(psi)*dx(test) + dy(psi)*dy(test)) - int2d(Th)((dx(v) - dy(u))*test) + on(2, 3, psi = 0);
  W ax = abs(psi); int best = 0;
  for (int i = 0; i < W.ndof; i++) if (ax[][i] > ax[][best]) best = i;
  W X = x, Y = y; real hx = X[][best], hy = Y[][best], w = 0.02;
  for (int k = 0; k < 12; k++) { real bx = hx, by = hy, top = abs(psi(hx, hy));
    for (int i = -4; i <= 4; i++) for (int j = -4; j <= 4; j++) { real at = abs(psi(hx + i*w/4, hy + j*w/4)); if (at > top) { top = at; bx = hx + i*w/4; by = hy + j*w/4; } }
    hx = bx; hy = by; w *= 0.6; }
  cout << "result stream " << abs(psi(hx, hy)) << endl << "result stream_x " << hx << endl << "result stream_y " << hy << endl;
}
"""
# a law, its derivative by the square of the strain rate, and the potential of its stress
NEWTONIAN = ("nu", "0*x", "0*x")
LAWS = {
    "power": ("min(1000., max(0.001, G^(N - 1)))", "G^(N - 1) < 1000 ? 0.5*(N - 1)*G^(N - 3) : 0", "G^(N + 1)/(N + 1)"),
    "carreau": ("(1 + (TIME*G)^2)^((N - 1)/2)", "0.5*(N - 1)*TIME^2*(1 + (TIME*G)^2)^((N - 3)/2)",
                "((1 + (TIME*G)^2)^((N + 1)/2) - 1)/((N + 1)*TIME^2)"),
    "bingham": ("1 + YIELD*(m*G < 1e-6 ? m*(1 - 0.5*m*G) : (1 - exp(-m*G))/G)",
                "YIELD*(m*G < 1e-3 ? m^2*(-0.5 + m*G/3) : ((m*G + 1)*exp(-m*G) - 1)/G^2)/(2*G)",
                "0.5*G2 + YIELD*(G + (exp(-m*G) - 1)/m)"),
}


def side(x0, y0, x1, y1, label, count):
    return f"border s@(t=0,1){{x={x0}+({x1}-({x0}))*t;y={y0}+({y1}-({y0}))*t;label={label};}}", int(count)


def ring(x, y, r, label, count):
    """Returns a circle by a polygon that has its area; a negative count leaves its inside out."""
    return (f"border s@(t=0,2*pi){{real R={r}*sqrt((2*pi/{abs(count)})/sin(2*pi/{abs(count)}));x={x}+R*cos(t);y={y}+R*sin(t);label={label};}}",
            int(count))


def mesh(parts):
    """Returns FreeFem's text of the mesh between sides and circles."""
    text = "".join(f"{part.replace('@', str(k))}\n" for k, (part, _) in enumerate(parts))
    return text + "mesh Th = buildmesh(" + " + ".join(f"s{k}({count})" for k, (_, count) in enumerate(parts)) + ");\n"


def corners(points, label, density):
    """Returns the sides of a polygon; a negative density goes round it with the fluid outside."""
    return [side(*p, *q, label, density * ((p[0] - q[0])**2 + (p[1] - q[1])**2)**0.5) for p, q in zip(points, points[1:] + points[:1])]


def lid(m, extra, floor=(0, 1)):
    """Returns the unit box whose lid moves, with points that are closer at the ends of the lid."""
    top = f"border s@(t=0,1){{x=0.5+0.5*cos(pi*t*t*(3-2*t));y=1;label=3;}}"
    bottom = [side(a, 0, b, 0, 2, 50 * m * (b - a)) for a, b in zip(floor, floor[1:])]
    def upright(x, low):
        return f"border s@(t=0,1){{real T={'1-t' if low else 't'};x={x};y=cos(pi*T*T/2);label=2;}}"
    return mesh([*bottom, (upright(1, True), int(50 * m)), (top, int(90 * m)), (upright(0, False), int(50 * m)), *extra])


GRID = [(round(0.1 * i, 3), round(0.1 * j, 3)) for i in range(1, 10) for j in range(1, 10)]


def inclusion(shape, ratio):
    """Returns text, words, points and their side of a lid-driven box with an inclusion; nu is 1 outside."""
    x0, y0, x1, y1 = {"square": (0.375, 0.5, 0.625, 0.75), "floor": (0.3, 0, 0.6, 0.3)}.get(shape, (0, 0, 0, 0))
    if shape == "circle":
        def depth(x, y):
            return 0.15 - ((x - 0.5)**2 + (y - 0.6)**2)**0.5
        inside = [(0.5, 0.6), *((0.5 + r * c, 0.6 + r * s) for r in (0.05, 0.1) for c, s in
                                ((1, 0), (0.6, 0.8), (0, 1), (-0.6, 0.8), (-1, 0), (-0.6, -0.8), (0, -1), (0.6, -0.8)))]
        func = "(x-0.5)^2+(y-0.6)^2<0.15^2"
    else:
        def depth(x, y):
            dx, dy = max(x0 - x, x - x1), max(y0 - y, y - y1) if y0 > 0 else y - y1
            return -max(dx, dy) if max(dx, dy) < 0 else -(max(dx, 0)**2 + max(dy, 0)**2)**0.5
        inside = [(x0 + (x1 - x0) * (0.2 + 0.2 * i), y0 + (y1 - y0) * (0.2 + 0.2 * j)) for i in range(4) for j in range(4)]
        func = f"x>{x0}&&x<{x1}&&y>{y0}&&y<{y1}"
    points = [(x, y) for x, y in inside + GRID if abs(depth(x, y)) > NEAR]
    points = list(dict.fromkeys((round(x, 4), round(y, 4)) for x, y in points))

    def text(m):
        if shape == "circle":
            return lid(m, [ring(0.5, 0.6, 0.15, 20, round(120 * m))])
        if shape == "square":
            return lid(m, corners([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], 20, 120 * m))
        return lid(m, [side(x0, 0, x0, y1, 20, 36 * m), side(x0, y1, x1, y1, 20, 36 * m), side(x1, y1, x1, 0, 20, 36 * m)], (0, x0, x1, 1))
    # nu is constant in a triangle
    words = {"NU0": ratio, "REGION": func}
    return text, words, NEWTONIAN, points, [int(depth(x, y) > 0) for x, y in points], {}


def cavity(law, **words):
    """Returns the unit box whose lid moves, filled with a fluid of a law; the mesh is finer at its sides."""
    def text(m):
        return (f"int n = {int(60 * m)}; mesh Th = square(n, n, [0.1*x+0.45*(1-cos(pi*x)), 0.1*y+0.9*sin(pi*y/2)]);\n"
                "int[int] labels = [1, 2, 4, 2]; Th = change(Th, refe = labels);\n")
    points = [(round(0.1 * i, 3), y) for i in range(1, 10) for y in (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.975)]
    return text, words, LAWS[law], points, [0] * len(points), {"STREAM": 1}


def cylinder(law, closed=False, **words):
    """Returns a cylinder in a channel; parabola at the inflow, and at the right side the same, or no tangential velocity and no normal
    stress."""
    right = 1 if closed else 9

    def text(m):
        return mesh([side(0, 0, 3, 0, 2, 90 * m), side(3, 0, 3, 1, right, 30 * m), side(3, 1, 0, 1, 2, 90 * m), side(0, 1, 0, 0, 1, 30 * m),
                     ring(1, 0.5, 0.15, 11, -round(150 * m))])
    points = [(x, y) for x in (0.3, 0.6, 0.75, 1, 1.25, 1.4, 1.7, 2.2) for y in (0.1, 0.2, 0.3, 0.5, 0.7) if (x - 1)**2 + (y - 0.5)**2 > 0.0396]
    return text, {"U1": "6*y*(1-y)", **words}, LAWS.get(law, NEWTONIAN), points, [0] * len(points), {"BODY": 1, "EPS": 1e-10 if closed else 0}


FLOWS = {f"{shape}_{ratio}": inclusion(shape, ratio) for shape in ("circle", "square", "floor") for ratio in RATIOS}
FLOWS |= {f"cavity_bingham_{value}": cavity("bingham", YIELD=value, FIRST=1 / float(value) + 0.5, LAST=1000) for value in YIELDS}
FLOWS |= {"cavity_power_0.5": cavity("power", N=0.5), "cavity_carreau": cavity("carreau", N=0.5, TIME=5)}
for word, closed in (("cylinder", False), ("passage", True)):
    FLOWS |= {f"{word}_newtonian": cylinder("newtonian", closed), f"{word}_carreau": cylinder("carreau", closed, N=0.5, TIME=1)}
    FLOWS |= {f"{word}_power_{n}": cylinder("power", closed, N=n) for n in (0.7, 1.5)}


def program(name, sizes):
    """Returns FreeFem's program of a flow on meshes; the solution on one is the start on the next."""
    make, words, law, points, _, switches = FLOWS[name]
    jumps, words = "REGION" in words, dict(words)
    switches = {"ELEMENT": "P2b" if jumps else "P2", "PRESSURE": "P1dc" if jumps else "P1", "NONLINEAR": int(law is not NEWTONIAN), "EPS": 1e-10,
                "BODY": 0, "STREAM": 0, "TRACE": 0, "FIRST": 1, "LAST": 1, **switches, **words}
    nu = f"nu = ({words['REGION']}) ? {words['NU0']} : 1;\n" if jumps else "nu = 1;\n"
    text = make(sizes[0]) + f"fespace P(Th, P0); P {nu}func U1 = {words.get('U1', '0*x')};\n"
    text += HEAD.replace("LAW", law[0], 1).replace("DERIVATIVE", law[1], 1).replace("POTENTIAL", law[2], 1)
    shown = "".join(f'cout << "point " << u({x}, {y}) << " " << v({x}, {y}) << " " << p({x}, {y}) << endl;\n' for x, y in points)
    for k, size in enumerate(sizes):
        text += "{\n" + (f"{make(size).replace('mesh Th =', 'Th =')}u = u; v = v; p = p; m = max(1.*FIRST, LAST/27.); {nu}" if k else "") + SOLVE + shown + "}\n"
    for key, value in switches.items():
        if key not in ("REGION", "NU0", "U1"):
            text = re.sub(rf"\b{key}\b", str(value), text)
    return text


def solve(name):
    """Returns for each mesh the results of a flow, and velocity and pressure at its points."""
    with tempfile.NamedTemporaryFile("w", suffix=".edp") as file:
        file.write(program(name, FINER if re.match("cavity|passage|cylinder", name) else MESHES))
        file.flush()
        done = subprocess.run(["FreeFem++", "-nw", "-v", "0", file.name], capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"{name}: {done.stdout[-2000:]}{done.stderr}")
    found = []
    for part in done.stdout.split("mesh\n")[1:]:
        lines = [line.split() for line in part.splitlines()]
        found.append(({line[1]: float(line[2]) for line in lines if line[:1] == ["result"]},
                      [[float(word) for word in line[1:]] for line in lines if line[:1] == ["point"]]))
    return found


def distance(few, many, columns):
    """Returns the largest difference of the values at points in some columns, relative to their largest."""
    scale = max(abs(row[k]) for row in many for k in columns)
    return max(abs(a[k] - b[k]) for a, b in zip(few, many) for k in columns) / scale


def main():
    only = sys.argv[1] if len(sys.argv) > 1 else ""
    for name in [name for name in FLOWS if re.search(only, name)]:
        results = solve(name)
        (_, _), (middle, few), (fine, many) = results
        change = fine.pop("change")
        if change > 1e-6:
            sys.exit(f"{name}: Newton's method stopped at a change of {change:g}")
        points, sides = FLOWS[name][3:5]
        for _, values in results:  # the constant of the pressure: its mean outside inclusions is 0
            mean = sum(row[2] for row, inside in zip(values, sides) if not inside) / sides.count(0)
            for row in values:
                row[2] -= mean
        velocity, pressure = (distance(few, many, columns) for columns in ((0, 1), (2,)))
        order = distance(results[0][1], few, (0, 1)) / max(velocity, 1e-300)
        print(f"{name}: velocity {velocity:.1e}, pressure {pressure:.1e}, meshes differ by factors of {order:.1f};",
              ", ".join(f"{key} {value:.7g} +- {abs(value - middle[key]):.0e}" for key, value in fine.items()), flush=True)
        with open(os.path.join(ROOT, "studies", "viscosity_references", f"{name}.csv"), "w", encoding="utf-8") as file:
            file.write(f"# By studies/viscosity_references.py {name}; the second mesh differs by {velocity:.0e} of the largest velocity at the\n"
                       f"# points and {pressure:.0e} of the largest pressure. Words: {', '.join(f'{k} {v:.7g} +- {abs(v - middle[k]):.0e}' for k, v in fine.items())}\n")
            file.write("x,y,inside,u,v,p\n")
            file.writelines(f"{x:g},{y:g},{inside}," + ",".join(f"{value:.7g}" for value in row) + "\n"
                            for (x, y), inside, row in zip(points, sides, many))


if __name__ == "__main__":
    main()
