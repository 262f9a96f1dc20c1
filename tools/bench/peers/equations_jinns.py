"""jinns on Burgers' equation of configs/equations: its own loss, network and SSBroyden, in double precision,
with the network and the points of DeepXDE's example. Appends rows as equations.py does.

    pip install jinns numpy scipy
    python3 tools/bench/peers/equations_jinns.py --out configs/equations/peers.csv [--threads 2]"""
import argparse
import os
import pathlib
import sys
import time

parser = argparse.ArgumentParser()
parser.add_argument("--out", required=True)
parser.add_argument("--threads", type=int, default=2)
parser.add_argument("--seed", type=int, default=1)
parser.add_argument("--adam", type=int, default=5000)
parser.add_argument("--ssbroyden", type=int, default=10000)
given = parser.parse_args()
os.environ["JAX_PLATFORMS"] = "cpu"
os.environ["JAX_ENABLE_X64"] = "1"
os.environ["XLA_FLAGS"] = f"--xla_cpu_multi_thread_eigen={'true' if given.threads > 1 else 'false'}"
os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:given.threads])
folder = pathlib.Path(__file__).resolve().parents[3] / "configs" / "equations"
sys.dont_write_bytecode = True
sys.path.insert(0, str(folder))
import jax
import jax.numpy as jnp
import jinns
import numpy as np
import optax
import reference
from jinns.loss import BurgersEquation, Dirichlet, LossPDENonStatio, LossWeightsPDENonStatio
from jinns.optimizers import scale_by_SSBroyden_family
from jinns.parameters import Params

scene = reference.Scene((folder / "burgers.yaml").read_text())
truth = np.loadtxt(folder / "reference" / "burgers.csv", delimiter=",", comments=["#", "x"])
one, two = jax.random.split(jax.random.PRNGKey(given.seed))
layers = ((jax.nn.tanh,) if i % 2 else (__import__("equinox").nn.Linear, a, b)
          for i, (a, b) in enumerate([(2, 20), (0, 0), (20, 20), (0, 0), (20, 20), (0, 0), (20, 1)]))
u, start = jinns.nn.PINN_MLP.create(key=one, eqx_list=tuple(layers), eq_type="PDENonStatio")
params = Params(nn_params=start, eq_params={"nu": jnp.array(scene.nu)})
data = jinns.data.CubicMeshPDENonStatio(
    key=two, n=2540, nb=80, ni=160, dim=1, min_pts=(-1,), max_pts=(1,), tmin=0., tmax=1.,
    domain_batch_size=None, border_batch_size=None, initial_batch_size=None)
loss = LossPDENonStatio(
    u=u, loss_weights=LossWeightsPDENonStatio(dyn_loss=1, initial_condition=1, boundary_loss=1),
    dynamic_loss=BurgersEquation(Tmax=1), initial_condition_fun=lambda x: -jnp.sin(jnp.pi * x),
    boundary_condition=Dirichlet(), params=params)
data, batch = data.get_batch()


def value(nn):
    return loss.evaluate(Params(nn_params=nn, eq_params=params.eq_params), batch)[0]


places = jnp.asarray(truth[:, 1::-1])  # t, x
clock = {"wall": time.perf_counter(), "cpu": time.process_time()}


@jax.jit
def predict(nn):
    return jax.vmap(lambda at: u(at, Params(nn_params=nn, eq_params=params.eq_params)))(places)[:, 0]


def look(method, nn):
    wall, cpu = time.perf_counter(), time.process_time()
    error = np.linalg.norm(predict(nn) - truth[:, -1]) / np.linalg.norm(truth[:, -1])
    with open(given.out, "a", encoding="ascii") as out:
        out.write(f"burgers,jinns; {method}; double; {given.threads} threads,{wall - clock['wall']:.1f},"
                  f"{cpu - clock['cpu']:.1f},{error:.3e}\n")
    clock["wall"] += time.perf_counter() - wall
    clock["cpu"] += time.process_time() - cpu


def descend(method, optimizer, steps, nn, quasi_newton):
    """Blocks of steps in one compiled loop."""
    state = optimizer.init(nn)
    block = 500

    @jax.jit
    def run(nn, state):
        def step(_, at):
            nn, state = at
            loss, slope = jax.value_and_grad(value)(nn)
            more = {"value": loss, "grad_pt": slope, "value_fn": value, "grad_fn": jax.grad(value)}
            change, state = optimizer.update(slope, state, nn, **(more if quasi_newton else {}))
            return optax.apply_updates(nn, change), state
        return jax.lax.fori_loop(0, block, step, (nn, state))

    for _ in range(steps // block):
        after, state = run(nn, state)
        if not all(bool(jnp.all(jnp.isfinite(leaf))) for leaf in jax.tree.leaves(after)):
            break
        nn = after
        look(method, nn)
    return nn


nn = descend("Adam", optax.adam(1e-3), given.adam, start, False)
descend("SSBroyden", scale_by_SSBroyden_family(), given.ssbroyden, nn, True)
