"""Train a policy with PPO on CPU, and keep what the firmware needs of it.

    pip install 'crazychoir-fw[train]'
    python examples/learning/train.py hover            # some minutes on two cores
    python examples/learning/train.py figure8

Writes out/learning/NAME/: policy.npz for `crazychoir app from-policy`, policy.zip (Stable-Baselines3) with
normalization.npz, curve.csv and curve.png.
"""

import argparse
import csv
import time
from pathlib import Path

import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecNormalize

from crazychoir_fw.learning import Hover, Track
from crazychoir_fw.learning.policy import read_policy
from crazychoir_fw.learning.sb3 import Sb3Flights

# real Crazyflies differ; the same block stands in examples/learning/*_campaign.yaml
VARY = {
    "defaults.mass": {"normal": {"mean": 0.029, "std": 0.0006}, "low": 0.027, "high": 0.031},
    "defaults.battery": {"uniform": [0.6, 1.0]},
    "defaults.vehicle.rotors.thrust_scale": {"normal": {"mean": 0.97, "std": 0.03}, "low": 0.88, "high": 1.06},
    "defaults.vehicle.trim.torque[0]": {"uniform": [-2.0e-4, 2.0e-4]},
    "defaults.vehicle.trim.torque[1]": {"uniform": [-2.0e-4, 2.0e-4]},
}

TASKS = {
    "hover": (Hover(vary=VARY, variants=64), 3_000_000),
    "figure8": (Track(vary=VARY, variants=64), 6_000_000),
}


class Curve(BaseCallback):
    """Keeps a row per rollout: steps, CPU seconds, mean return and length of episodes."""

    def __init__(self) -> None:
        super().__init__()
        self.rows: list[tuple[int, float, float, float]] = []

    def _on_step(self) -> bool:
        return True

    def _on_rollout_end(self) -> None:
        ended = list(self.model.ep_info_buffer)
        if ended:
            returns, lengths = (float(np.mean([one[key] for one in ended])) for key in ("r", "l"))
            self.rows.append((self.num_timesteps, time.process_time(), returns, lengths))
            if len(self.rows) % 20 == 0:
                steps, seconds = self.rows[-1][:2]
                print(
                    f"{steps:9d} steps, {seconds:5.0f} s of CPU: return {returns:6.2f}, length {lengths:5.0f}",
                    flush=True,
                )


def main() -> None:
    """Train a policy."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name", choices=TASKS)
    parser.add_argument("--steps", type=int)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path("out/learning"))
    options = parser.parse_args()

    task, steps = TASKS[options.name]
    folder = options.out / options.name
    folder.mkdir(parents=True, exist_ok=True)
    torch.set_num_threads(options.threads)
    env = VecNormalize(Sb3Flights(task, 256, threads=options.threads), gamma=0.99)
    env.seed(options.seed)
    model = PPO(
        "MlpPolicy",
        env,
        learning_rate=lambda left: 1e-4 + 4e-4 * left,
        n_steps=64,
        batch_size=2048,
        n_epochs=5,
        gamma=0.99,
        gae_lambda=0.95,
        ent_coef=0.0,
        policy_kwargs={"net_arch": {"pi": [64, 64], "vf": [64, 64]}, "log_std_init": -1.0},
        seed=options.seed,
        device="cpu",
    )
    curve = Curve()
    model.learn(options.steps or steps, callback=curve)
    model.save(folder / "policy.zip")
    np.savez(folder / "normalization.npz", mean=env.obs_rms.mean, var=env.obs_rms.var)
    read_policy(folder / "policy.zip", task, folder / "normalization.npz").save(folder / "policy.npz")
    write_curve(folder, curve.rows, options.name)
    print(f"{folder}: trained in {time.process_time():.0f} s of CPU")


def write_curve(folder: Path, rows: list[tuple[int, float, float, float]], name: str) -> None:
    """Write the learning curve as numbers and as a picture."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    with (folder / "curve.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["steps", "cpu_seconds", "return", "length"])
        writer.writerows(rows)
    steps, seconds, returns, _ = np.array(rows).T
    figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
    axes.plot(steps / 1e6, returns, color="tab:blue")
    axes.set(xlabel="million steps of the policy", ylabel="return of an episode", title=name)
    axes.grid(alpha=0.3)
    beside = axes.secondary_xaxis("top", functions=(lambda x: x * seconds[-1] / (steps[-1] / 1e6),) * 2)
    beside.set_xlabel("seconds of CPU")
    beside.set_xlim(0, seconds[-1])
    figure.savefig(folder / "curve.png", dpi=130)


if __name__ == "__main__":
    main()
