"""The stiffness factor and 200 right-hand sides, here, by CHOLMOD and by MKL PARDISO, one after the other on the same matrix.

    apt-get install gcc libsuitesparse-dev libopenblas0-pthread; pip install numpy scipy pypardiso
    python benches/solvers.py
"""
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
import pypardiso
import scipy.io
import scipy.sparse

ROUNDS = 5

with tempfile.TemporaryDirectory() as folder:
    path = Path(folder) / "stiffness.mtx"
    command = ["cargo", "bench", "--bench", "reshape", "--", "matrix", str(path)]
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    ours = [float(word) for word in printed.split()[-2:]]
    matrix = scipy.io.mmread(path).tocsr()
    program = Path(folder) / "cholmod"
    source = Path(__file__).with_name("cholmod.c")
    subprocess.run(["gcc", "-O2", source, "-o", program, "-lcholmod"], check=True)
    printed = subprocess.run([program, path], check=True, capture_output=True, text=True).stdout
    cholmod = [float(word) for word in printed.split()]

upper = scipy.sparse.triu(matrix, format="csr")
sides = np.asfortranarray(np.random.default_rng(1).normal(size=(matrix.shape[0], 200)))
factoring, solving = [], []
for _ in range(ROUNDS):
    # 2: real, symmetric, positive definite.
    solver = pypardiso.PyPardisoSolver(mtype=2)
    solver.set_phase(11)
    solver._call_pardiso(upper, sides)
    for phase, seconds in ((22, factoring), (33, solving)):
        solver.set_phase(phase)
        start = time.perf_counter()
        solution = solver._call_pardiso(upper, sides)
        seconds.append(time.perf_counter() - start)
    solver.free_memory(everything=True)
residual = np.abs(matrix @ solution - sides).max()
print(f"{matrix.shape[0]} rows, {upper.nnz} entries; seconds for the factor and for 200 right-hand sides, fastest of {ROUNDS}")
print(f"here         {ours[0]:.3f}  {ours[1]:.3f}  sum {sum(ours):.3f}")
print(f"CHOLMOD      {cholmod[0]:.3f}  {cholmod[1]:.3f}  sum {sum(cholmod):.3f}")
print(f"MKL PARDISO  {min(factoring):.3f}  {min(solving):.3f}  sum {min(factoring) + min(solving):.3f}  (residual {residual:.1e})")
