"""DAQP, PIQP and OSQP on the sets that `peers` hands over, each as its makers would use it.

Standard input: {"repeats", "sets"}; standard output: {"sets": [[[solver, times_us, inputs], ...], ...], "notes"}.

* DAQP: the condensed problem in the inputs alone; its factors are made once, a solve gets new vectors. Three rows as
  ours: cold (a fresh model, an empty active set), closed loop (the active set of the previous start), and again (the
  same start once more, so that its active set is known). The caller adds the time of the vectors.
* PIQP: the sparse problem with its multistage factorisation, and the condensed one with its dense solver.
* OSQP: the sparse problem, set up once, warm, polished.

A time is the one that the solver reports of its solve.
"""

import json
import sys
import time


def setup(of):
    """Matrices of a set: sparse in (u, x), and condensed in u."""
    n = of["horizon"]
    a, b = np.array(of["a"]), np.array(of["b"])
    q, p, r = np.array(of["q"]), np.array(of["p"]), of["r"]
    target = np.array(of["target"])
    # x_k = phi[k] x_0 + gamma[k] u for k = 1..n
    phi, gamma = np.zeros((n, 3, 3)), np.zeros((n, 3, n))
    power, column = np.eye(3), np.zeros((3, n))
    for k in range(n):
        power = a @ power
        column = a @ column
        column[:, k] = b
        phi[k], gamma[k] = power, column
    weights = [q] * (n - 1) + [p]
    hessian = r * np.eye(n) + sum(g.T @ w @ g for g, w in zip(gamma, weights))
    by_state = sum(g.T @ w @ f for g, w, f in zip(gamma, weights, phi))
    constant = -sum(g.T @ w @ target for g, w in zip(gamma, weights))
    rows, limits, of_start = [], [], []
    for row in of["rows"]:
        g = np.array(row["gradient"])
        for k in range(row["from"], row["to"] + 1):
            rows.append(g @ gamma[k - 1])
            of_start.append(g @ phi[k - 1])
            limits.append(row["limit"])
    condensed = {
        "h": hessian, "f_x": by_state, "f_0": constant,
        "a": np.array(rows).reshape(len(rows), n), "limit": np.array(limits),
        "a_x": np.array(of_start).reshape(len(rows), 3),
        "end": gamma[n - 1], "end_x": phi[n - 1],
    }
    # Variables u_0, x_1, u_1, x_2, ...: the order in which a multistage factorisation is banded.
    size, at = 4 * n, lambda k: 4 * (k - 1) + 1
    cost, gradient = np.zeros((size, size)), np.zeros(size)
    dynamics, bounds, limits = np.zeros((3 * n, size)), [], []
    for k in range(1, n + 1):
        cost[4 * (k - 1), 4 * (k - 1)] = r
        cost[at(k):at(k) + 3, at(k):at(k) + 3] = weights[k - 1]
        gradient[at(k):at(k) + 3] = -weights[k - 1] @ target
        lines = slice(3 * (k - 1), 3 * k)
        dynamics[lines, 4 * (k - 1)] = -b
        dynamics[lines, at(k):at(k) + 3] = np.eye(3)
        if k > 1:
            dynamics[lines, at(k - 1):at(k - 1) + 3] = -a
    for row in of["rows"]:
        for k in range(row["from"], row["to"] + 1):
            line = np.zeros(size)
            line[at(k):at(k) + 3] = row["gradient"]
            bounds.append(line)
            limits.append(row["limit"])
    if of["ends_at_zero"]:
        end = np.zeros((3, size))
        end[:, -3:] = np.eye(3)
        dynamics = np.vstack([dynamics, end])
    lower, upper = np.full(size, -np.inf), np.full(size, np.inf)
    lower[::4], upper[::4] = of["bounds"]
    sparse = {
        "p": sp.csc_matrix(cost), "c": gradient, "a": sp.csc_matrix(dynamics),
        "g": sp.csc_matrix(np.array(bounds).reshape(len(bounds), size)), "h": np.array(limits),
        "lower": lower, "upper": upper, "a_0": a, "rows": 3 * n, "size": size,
    }
    return condensed, sparse


def right_side(sparse, x0):
    b = np.zeros(sparse["a"].shape[0])
    b[:3] = sparse["a_0"] @ x0
    return b


def measure(of, repeats, solve):
    """Goes over all starts `repeats` times, so that a solver's warm start is that of the closed loop."""
    runs, inputs = [[] for _ in of["starts"]], []
    for _ in range(repeats):
        inputs = []
        for x0, times in zip(of["starts"], runs):
            seconds, u = solve(np.array(x0))
            times.append(seconds)
            inputs.append([] if u is None else [float(value) for value in u])
    return [1e6 * sorted(times)[len(times) // 2] for times in runs], inputs


def daqp_condensed(of, condensed, start):
    import daqp

    n, (low, high) = of["horizon"], of["bounds"]
    rows, end = condensed["a"], condensed["end"] if of["ends_at_zero"] else np.zeros((0, n))
    matrix = np.ascontiguousarray(np.vstack([rows, end]))
    sense = np.array([0] * (n + len(rows)) + [5] * len(end), dtype=np.intc)
    models = [daqp.Model()]

    def vectors(x0):
        f = condensed["f_x"] @ x0 + condensed["f_0"]
        ends = -condensed["end_x"] @ x0 if len(end) else np.zeros(0)
        upper = np.concatenate([np.full(n, high), condensed["limit"] - condensed["a_x"] @ x0, ends])
        lower = np.concatenate([np.full(n, low), np.full(len(rows), -1e30), ends])
        return f, upper, lower

    def set_up(x0):
        models[0] = daqp.Model()
        models[0].setup(condensed["h"], *vectors(x0)[:1], matrix, *vectors(x0)[1:], sense.copy())

    set_up(np.array(of["starts"][0]))

    def solve(x0):
        if start == "cold":
            set_up(x0)
        f, upper, lower = vectors(x0)
        for _ in range(2 if start == "again" else 1):
            models[0].update(f=f, bupper=upper, blower=lower)
            u, _, flag, info = models[0].solve()
        return info["solve_time"], u if flag > 0 else None

    return solve


def piqp_sparse(of, _, sparse):
    import piqp

    solver = piqp.SparseSolver()
    solver.settings.compute_timings = True
    solver.settings.kkt_solver = piqp.KKTSolver.sparse_multistage
    solver.settings.eps_abs = solver.settings.eps_rel = 1e-9
    none = np.full(len(sparse["h"]), -np.inf)
    args = dict(A=sparse["a"], G=sparse["g"], h_l=none, h_u=sparse["h"]) if len(none) else dict(A=sparse["a"])
    first = right_side(sparse, np.array(of["starts"][0]))
    solver.setup(sparse["p"], sparse["c"], b=first, x_l=sparse["lower"], x_u=sparse["upper"], **args)

    def solve(x0):
        solver.update(b=right_side(sparse, x0))
        status = solver.solve()
        u = solver.result.x[::4] if status == piqp.PIQP_SOLVED else None
        return solver.result.info.solve_time, u

    return solve


def piqp_dense(of, condensed, _):
    import piqp

    n, (low, high) = of["horizon"], of["bounds"]
    solver = piqp.DenseSolver()
    solver.settings.compute_timings = True
    solver.settings.eps_abs = solver.settings.eps_rel = 1e-9

    def vectors(x0):
        given = dict(c=condensed["f_x"] @ x0 + condensed["f_0"])
        if len(condensed["limit"]):
            given["h_u"] = condensed["limit"] - condensed["a_x"] @ x0
        if of["ends_at_zero"]:
            given["b"] = -condensed["end_x"] @ x0
        return given

    fixed = dict(x_l=np.full(n, low), x_u=np.full(n, high))
    if len(condensed["limit"]):
        fixed.update(G=condensed["a"], h_l=np.full(len(condensed["limit"]), -np.inf))
    if of["ends_at_zero"]:
        fixed["A"] = condensed["end"]
    solver.setup(condensed["h"], **vectors(np.array(of["starts"][0])), **fixed)

    def solve(x0):
        solver.update(**vectors(x0))
        status = solver.solve()
        return solver.result.info.solve_time, solver.result.x.copy() if status == piqp.PIQP_SOLVED else None

    return solve


def osqp_sparse(of, _, sparse):
    import osqp

    rows = [sparse["a"], sp.identity(sparse["size"], format="csc")] + ([sparse["g"]] if len(sparse["h"]) else [])
    matrix = sp.vstack(rows, format="csc")

    def vectors(x0):
        b, none = right_side(sparse, x0), np.full(len(sparse["h"]), -np.inf)
        lower = np.concatenate([b, sparse["lower"], none])
        return lower, np.concatenate([b, sparse["upper"], sparse["h"]])

    lower, upper = vectors(np.array(of["starts"][0]))
    solver = osqp.OSQP()
    solver.setup(sp.triu(sparse["p"], format="csc"), sparse["c"], matrix, lower, upper, verbose=False,
                 eps_abs=1e-7, eps_rel=1e-7, max_iter=100_000, polishing=True, polish_refine_iter=10)

    def solve(x0):
        lower, upper = vectors(x0)
        solver.update(l=lower, u=upper)
        result = solver.solve(raise_error=False)
        info = result.info
        seconds = info.solve_time + getattr(info, "polish_time", 0.0)
        return seconds, result.x[::4] if info.status == "solved" else None

    return solve


SOLVERS = [
    ("DAQP, cold", "daqp", lambda of, condensed, _: daqp_condensed(of, condensed, "cold")),
    ("DAQP, closed loop", "daqp", lambda of, condensed, _: daqp_condensed(of, condensed, "closed loop")),
    ("DAQP, again", "daqp", lambda of, condensed, _: daqp_condensed(of, condensed, "again")),
    ("PIQP, sparse multistage", "piqp", piqp_sparse),
    ("PIQP, dense condensed", "piqp", piqp_dense),
    ("OSQP, sparse, polished", "osqp", osqp_sparse),
]


def main():
    asked = json.load(sys.stdin)
    notes, sets = [], [[] for _ in asked["sets"]]
    for name, package, make in SOLVERS:
        try:
            version = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            notes.append(f"{name} is not compared: no package {package}")
            continue
        begin = time.monotonic()
        for of, answers in zip(asked["sets"], sets):
            matrices = setup(of)
            times, inputs = measure(of, asked["repeats"], make(of, *matrices))
            answers.append([name, times, inputs])
        notes.append(f"{name}: {package} {version}, {time.monotonic() - begin:.0f} s in all")
    json.dump({"sets": sets, "notes": notes}, sys.stdout)


if __name__ == "__main__":
    try:
        import importlib.metadata
        import numpy as np
        import scipy.sparse as sp
    except ImportError as error:
        sys.exit(f"{error}: pip install numpy scipy daqp piqp osqp")
    main()
