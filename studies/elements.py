"""An independent finite-element program for references in the plane: incompressible flow by elements of Taylor and Hood,
velocity of second and pressure of first order on triangles with sides of second order (meshes.py), direct solves.

    rho (du/dt + (u - w).grad u + 2 omega x u) = -grad p + div(mu (grad u + grad u^T)) + f,    div u = 0

mu is a constant, or a Law of the strain rate g = sqrt(2 E:E), E = (grad u + grad u^T)/2.

Forces and torques on pieces of the border are reactions, the residual of the equations of their nodes, tested with rigid
motions: they converge twice as fast as integrals of stresses (Babuska and Miller 1984)."""
import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, eye
from scipy.sparse.linalg import splu
from scipy.spatial import cKDTree

# Rule of degree 5 with 7 points on the triangle (Radon 1948): coordinates r, s and weights.
ROOT = np.sqrt(15.0)
RULE = np.array([[1 / 3, 1 / 3, 9 / 80]]
                + [[a, b, w] for c, w in (((6 + ROOT) / 21, (155 + ROOT) / 2400), ((6 - ROOT) / 21, (155 - ROOT) / 2400))
                   for a, b in ((c, c), (1 - 2 * c, c), (c, 1 - 2 * c))])


def quadratic(r, s):
    """Returns the six functions of second order at points of the triangle, (points, 6), and derivatives, (points, 6, 2)."""
    r, s = np.atleast_1d(r), np.atleast_1d(s)
    t, o = 1 - r - s, np.zeros_like(r)
    value = np.stack([t * (2 * t - 1), r * (2 * r - 1), s * (2 * s - 1), 4 * t * r, 4 * r * s, 4 * s * t], 1)
    dr = np.stack([1 - 4 * t, 4 * r - 1, o, 4 * (t - r), 4 * s, -4 * s], 1)
    ds = np.stack([1 - 4 * t, o, 4 * s - 1, -4 * r, 4 * r, 4 * (t - s)], 1)
    return value, np.stack([dr, ds], 2)


class Law:
    """A fluid of Herschel and Bulkley, mu = K (g^2 + e^2)^((n-1)/2) + yield (g^2 + e^2)^(-1/2), regularised after M. Bercovier and
    M. Engelman (J. Comput. Phys. 36 (1980) 313): stresses of flowing fluid err by yield (e/g)^2/2."""

    def __init__(self, consistency=1.0, exponent=1.0, stress=0.0, least=1e-4):
        self.consistency, self.exponent, self.stress, self.least = consistency, exponent, stress, least

    def parts(self, square, e):
        """Returns mu, its derivative to g^2/2, and the density of the potential, whose derivative to g^2/2 is mu."""
        s, k, n = square + e * e, self.consistency, self.exponent
        return (k * s ** ((n - 1) / 2) + self.stress * s**-0.5, k * (n - 1) * s ** ((n - 3) / 2) - self.stress * s**-1.5,
                k * s ** ((n + 1) / 2) / (n + 1) + self.stress * s**0.5)


class Flow:
    """A flow on a mesh: unknowns are u of all nodes, v of all nodes, p of the corners. `velocity` has a function of points
    for some pieces of the border, {(loop, piece): f}, f(x) of shape (nodes, 2); other pieces have no stress. Pairs in
    `periodic` are pieces of the first loop as in Mesh(). `force` is per volume, `omega` the rate of a turning frame, whose
    centrifugal force is in the pressure."""

    def __init__(self, mesh, mu=1.0, rho=0.0, velocity=None, force=(0.0, 0.0), omega=0.0, periodic=()):
        self.mesh, self.rho, self.law = mesh, rho, mu if isinstance(mu, Law) else None
        self.mu = 1.0 if self.law else mu  # of the first guess
        self.nodes, self.size = len(mesh.x), 2 * len(mesh.x) + mesh.corners
        self.phi, slope = quadratic(*RULE[:, :2].T)
        self.psi = np.stack([1 - RULE[:, 0] - RULE[:, 1], RULE[:, 0], RULE[:, 1]], 1)
        map_ = np.einsum("qir,mia->mqar", slope, mesh.x[mesh.elements])
        self.weight = np.linalg.det(map_) * RULE[:, 2]
        if np.any(self.weight <= 0):
            raise ValueError(f"{np.sum(np.any(self.weight <= 0, axis=1))} triangles are folded: take finer sides")
        self.slope = np.einsum("qir,mqra->mqia", slope, np.linalg.inv(map_))
        e = mesh.elements
        self.dof = np.concatenate([e, e + self.nodes, e[:, :3] + 2 * self.nodes], axis=1)
        self.linear = self.assemble(self.stokes(omega))
        self.load = np.zeros(self.size)
        for axis in (0, 1):
            share = np.einsum("mq,qi->mi", self.weight, self.phi) * force[axis]
            self.load += np.bincount((e + axis * self.nodes).ravel(), share.ravel(), self.size)
        self.constrain(velocity or {}, periodic)

    def assemble(self, blocks):
        """Returns the sparse matrix of matrices of elements."""
        m, n = self.dof.shape
        rows, columns = np.repeat(self.dof, n, axis=1).ravel(), np.tile(self.dof, (1, n)).ravel()
        return coo_matrix((blocks.ravel(), (rows, columns)), shape=(self.size, self.size)).tocsr()

    def stokes(self, omega):
        """Returns the matrices of elements of the viscous stress, the pressure and Coriolis's force."""
        w, g, f = self.weight, self.slope, self.phi
        block = np.zeros((len(w), 15, 15))
        both = np.einsum("mq,mqia,mqja->mij", w, g, g)
        for a in (0, 1):
            for b in (0, 1):
                part = np.einsum("mq,mqi,mqj->mij", w, g[..., b], g[..., a]) + (a == b) * both
                block[:, 6 * a:6 * a + 6, 6 * b:6 * b + 6] = self.mu * part
            divergence = -np.einsum("mq,mqi,qk->mik", w, g[..., a], self.psi)
            block[:, 6 * a:6 * a + 6, 12:] = divergence
            block[:, 12:, 6 * a:6 * a + 6] = divergence.transpose(0, 2, 1)
        mass = np.einsum("mq,qi,qj->mij", w, f, f)
        block[:, :6, 6:12] -= 2 * self.rho * omega * mass
        block[:, 6:12, :6] += 2 * self.rho * omega * mass
        self.mass = mass
        return block

    def strain(self, w):
        """Returns 2 E at points, (elements, points, 2, 2)."""
        e = self.mesh.elements
        nodal = np.stack([w[:self.nodes][e], w[self.nodes:2 * self.nodes][e]], -1)
        gradient = np.einsum("mqib,mia->mqab", self.slope, nodal)
        return gradient + gradient.swapaxes(2, 3)

    def viscous(self, w, e):
        """Returns the viscous forces of the law at w, their derivative, both without those of mu, and the potential."""
        twice = self.strain(w)
        mu, slope, potential = self.law.parts(0.5 * np.einsum("mqab,mqab->mq", twice, twice), e)
        weight, g = self.weight, self.slope
        block = np.zeros((len(weight), 15, 15))
        pull = np.einsum("mqab,mqib->mqia", twice, g)  # derivative of g^2/2 to the nodes
        extra = (mu - self.mu) * weight
        both = np.einsum("mq,mqia,mqja->mij", extra, g, g, optimize=True)
        for a in (0, 1):
            for b in (0, 1):
                part = np.einsum("mq,mqi,mqj->mij", extra, g[..., b], g[..., a], optimize=True) + (a == b) * both
                part += np.einsum("mq,mqi,mqj->mij", slope * weight, pull[..., a], pull[..., b], optimize=True)
                block[:, 6 * a:6 * a + 6, 6 * b:6 * b + 6] = part
        force = np.einsum("mq,mqia->mia", extra, pull, optimize=True)
        nodes = np.concatenate([self.mesh.elements, self.mesh.elements + self.nodes], 1)
        vector = np.bincount(nodes.ravel(), np.concatenate([force[..., 0], force[..., 1]], 1).ravel(), self.size)
        return vector, self.assemble(block), np.sum(potential * weight)

    def plastic(self, start=None, first=1.0, factor=3.0, tolerance=1e-8, rounds=60, watch=None):
        """Returns all unknowns of the steady flow of a law without inertia, by Newton's method: its regularisation falls from
        first to its least by factors. Steps that do not lessen the potential are halved."""
        w = self.steady() if start is None else start
        e = max(first, self.law.least)
        while True:
            last = e <= self.law.least
            for turn in range(rounds):
                vector, extra, potential = self.viscous(w, e)
                residual = self.extend.T @ (self.load - self.linear @ w - vector)
                change = self.solve(self.linear + extra, residual)
                moved = np.abs(change[:2 * self.nodes]).max() / np.abs(w[:2 * self.nodes]).max()
                share, full = 1.0, change.copy()
                full[:2 * self.nodes] = 0
                before = potential - self.load @ w
                while share > 1e-4 and moved > 1e-6 and self.potential(w + share * change, e) > before + 1e-12 * abs(before):
                    share /= 2
                w = w + share * (change - full) + full
                if watch:
                    watch(e, turn, moved, share)
                if moved * share < (tolerance if last else 0.02):
                    break
            else:
                raise ValueError(f"Newton's method did not converge: regularisation {e:g}, change {moved:.1e}")
            if last:
                self.e = e
                return self.levelled(w)
            e = max(e / factor, self.law.least)

    def potential(self, w, e):
        """Returns the potential of the law at w, less the work of the load."""
        twice = self.strain(w)
        return np.sum(self.law.parts(0.5 * np.einsum("mqab,mqab->mq", twice, twice), e)[2] * self.weight) - self.load @ w

    def inertia(self, factor):
        """Returns the matrix of factor times rho times the mass of velocities."""
        block = np.zeros((len(self.weight), 15, 15))
        block[:, :6, :6] = block[:, 6:12, 6:12] = factor * self.rho * self.mass
        return self.assemble(block)

    def convection(self, u, newton):
        """Returns rho u.grad u and its derivative, without the derivative of the velocity that carries unless newton."""
        w, g, f, e = self.weight, self.slope, self.phi, self.mesh.elements
        nodal = np.stack([u[:self.nodes][e], u[self.nodes:2 * self.nodes][e]], -1)
        here = np.einsum("qi,mia->mqa", f, nodal)
        gradient = np.einsum("mqib,mia->mqab", g, nodal)
        block = np.zeros((len(w), 15, 15))
        carried = self.rho * np.einsum("mq,qi,mqa,mqja->mij", w, f, here, g, optimize=True)
        block[:, :6, :6] = block[:, 6:12, 6:12] = carried
        term = self.rho * np.einsum("mq,qi,mqb,mqab->mia", w, f, here, gradient, optimize=True)
        if newton:
            for a in (0, 1):
                for b in (0, 1):
                    part = np.einsum("mq,qi,qj,mq->mij", w, f, f, gradient[..., a, b], optimize=True)
                    block[:, 6 * a:6 * a + 6, 6 * b:6 * b + 6] += self.rho * part
        vector = np.bincount(np.concatenate([e, e + self.nodes], 1).ravel(),
                             np.concatenate([term[..., 0], term[..., 1]], 1).ravel(), self.size)
        return vector, self.assemble(block)

    def constrain(self, velocity, periodic):
        """Makes the map from free unknowns to all, and the values that are given."""
        mesh, same = self.mesh, np.arange(self.nodes)
        for a, b in periodic:
            one, other = mesh.border[0, a], mesh.border[0, b]
            n = (len(one) + 1) // 2
            same[np.concatenate([other[:n], other[n:]])] = np.concatenate([one[:n][::-1], one[n:][::-1]])
        same = same[same]
        self.given, fixed = np.zeros(self.size), np.zeros(self.size, bool)
        for piece, value in velocity.items():
            nodes = mesh.border[piece]
            for axis in (0, 1):
                self.given[nodes + axis * self.nodes] = value(mesh.x[nodes])[:, axis]
                fixed[nodes + axis * self.nodes] = True
        whole = np.concatenate([same, same + self.nodes, same[:mesh.corners] + 2 * self.nodes])
        self.closed = len(velocity) + 2 * len(periodic) == len(mesh.border)
        if self.closed:  # the constant of the pressure is free
            fixed[2 * self.nodes] = True
        free = np.flatnonzero((whole == np.arange(self.size)) & ~fixed)
        number = np.full(self.size, -1)
        number[free] = np.arange(len(free))
        number = number[whole]
        rows = np.flatnonzero((number >= 0) & ~fixed)
        self.extend = csr_matrix((np.ones(len(rows)), (rows, number[rows])), shape=(self.size, len(free)))

    def steady(self, tolerance=1e-10, start=None, rounds=30):
        """Returns all unknowns of the steady flow, by Newton's method after two of Picard's rounds where rho > 0."""
        w = self.given + (0 if start is None else self.extend @ (self.extend.T @ (start - self.given)))
        for turn in range(rounds):
            convected, extra = self.convection(w, turn > 1 or start is not None) if self.rho else (0, 0)
            residual = self.extend.T @ (self.load - self.linear @ w - convected)
            change = self.solve(self.linear + extra, residual)
            w = w + change
            if not self.rho or np.abs(change[:2 * self.nodes]).max() < tolerance * np.abs(w[:2 * self.nodes]).max():
                return self.levelled(w)
        raise ValueError("Newton's method did not converge")

    def advance(self, w, dt, steps, watch=None):
        """Returns the unknowns after steps of second order in time (BDF2, the first one by Euler), Newton's method in each."""
        before = None
        for step in range(steps):
            rate = 1 / dt if before is None else 1.5 / dt
            mass = self.inertia(1.0)
            past = mass @ (w / dt if before is None else (2 * w - 0.5 * before) / dt)
            before, w = w, self.extend @ (self.extend.T @ (w - self.given)) / 1 + self.given
            w[2 * self.nodes:] = before[2 * self.nodes:]
            for _ in range(8):
                convected, extra = self.convection(w, True)
                change = self.solve(self.linear + rate * mass + extra, self.extend.T @ (
                    self.load + past - self.linear @ w - rate * (mass @ w) - convected))
                w = w + change
                if np.abs(change[:2 * self.nodes]).max() < 1e-10:
                    break
            if watch:
                watch((step + 1) * dt, self.levelled(w.copy()))
        return self.levelled(w)

    def solve(self, matrix, residual):
        """Returns the change of all unknowns for a residual of the free ones."""
        inner = (self.extend.T @ matrix @ self.extend).tocsc()
        return self.extend @ splu(inner, permc_spec="COLAMD").solve(residual)

    def levelled(self, w):
        """Sets the mean pressure of the volume to zero where the border leaves its constant free."""
        if self.closed:
            p = w[2 * self.nodes:]
            mean = np.einsum("mq,qk,mk->", self.weight, self.psi, p[self.mesh.elements[:, :3]]) / self.weight.sum()
            w[2 * self.nodes:] = p - mean
        return w

    def reaction(self, w, pieces, centre=(0.0, 0.0), steady=True):
        """Returns force and torque about a centre (fx, fy, torque) of the fluid on pieces of the border, per length."""
        convected = self.convection(w, False)[0] if self.rho and steady else 0
        residual = self.linear @ w + convected - self.load + (self.viscous(w, self.e)[0] if self.law else 0)
        nodes = np.unique(np.concatenate([self.mesh.border[piece] for piece in pieces]))
        fx, fy = -residual[nodes], -residual[nodes + self.nodes]
        x, y = (self.mesh.x[nodes] - centre).T
        return np.array([fx.sum(), fy.sum(), (x * fy - y * fx).sum()])

    def dissipation(self, w):
        """Returns the power that viscosity dissipates, per length."""
        block = self.stokes(0.0)
        block[:, 12:, :] = block[:, :, 12:] = 0
        return w @ (self.assemble(block) @ w)

    def at(self, w, points):
        """Returns u, v, p at points."""
        points, mesh = np.atleast_2d(np.asarray(points, float)), self.mesh
        corners = mesh.x[mesh.elements[:, :3]]
        _, near = cKDTree(corners.mean(axis=1)).query(points, k=min(24, len(corners)))
        best, found = np.full(len(points), np.inf), np.zeros((len(points), 3))
        for element in near.T:
            nodal, r = mesh.x[mesh.elements[element]], np.full((len(points), 2), 1 / 3)
            for _ in range(6):
                value, slope = quadratic(*r.T)
                miss = points - np.einsum("ni,nia->na", value, nodal)
                r = r + np.linalg.solve(np.einsum("nir,nia->nar", slope, nodal), miss[..., None])[..., 0]
                r = np.clip(r, -1, 2)
            outside = np.maximum(0, np.max(np.stack([-r[:, 0], -r[:, 1], r[:, 0] + r[:, 1] - 1], 1), axis=1))
            value, _ = quadratic(*r.T)
            linear = np.stack([1 - r[:, 0] - r[:, 1], r[:, 0], r[:, 1]], 1)
            here = np.stack([np.sum(value * w[mesh.elements[element]], axis=1),
                             np.sum(value * w[mesh.elements[element] + self.nodes], axis=1),
                             np.sum(linear * w[mesh.elements[element][:, :3] + 2 * self.nodes], axis=1)], 1)
            better = outside < best
            best[better], found[better] = outside[better], here[better]
        if best.max() > 0.05:
            raise ValueError(f"a point lies outside the mesh, by {best.max():.2g} of a triangle")
        return found


def still(x):
    """Returns the velocity of a wall at rest."""
    return np.zeros_like(x)


def turning(omega, centre=(0.0, 0.0)):
    """Returns the velocity of a rigid rotation about a centre."""
    return lambda x: omega * np.stack([centre[1] - x[:, 1], x[:, 0] - centre[0]], 1)
