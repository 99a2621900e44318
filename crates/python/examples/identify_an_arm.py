# %% [markdown]
# # From a description and a log to validated parameters
#
# Each cell can be run by itself in an editor that knows `# %%`, or the whole file by Python. The log is simulated here.

# %%
import pathlib

import numpy as np

import rist

ROOT = pathlib.Path(__file__).resolve().parents[3]
model = rist.Model.read(ROOT / "models/ur5.urdf")
model

# %% [markdown]
# A motion in which every joint moves at its own frequencies, and the torques that it takes: dynamics, friction, noise.


# %%
def measured(seed):
    random = np.random.default_rng(seed)
    t = np.arange(0.0, 15.0, 0.005)
    w = 2 * np.pi * random.uniform(0.1, 0.7, (3, 6))
    a, angle = random.uniform(0.2, 0.6, (3, 6)), w * t[:, None, None] + random.uniform(0, 6, (3, 6))
    q, dq, ddq = (np.sum(x, axis=1) for x in (a * np.sin(angle), a * w * np.cos(angle), -a * w**2 * np.sin(angle)))
    tau = model.torque(q, dq, ddq) + 2.0 * dq + 1.5 * np.sign(dq) + 0.05 * random.normal(size=q.shape)
    return {"t": t, "q": q, "dq": dq, "tau": tau}


log, other = measured(1), measured(2)

# %% [markdown]
# Does the log belong to the description?

# %%
rist.doctor(model, log)

# %%
estimate = rist.identify(model, log, friction="viscous,coulomb", validate=[other])
estimate

# %% [markdown]
# How well does it predict what it was not made from?

# %%
validation, verdict = rist.validate(model, estimate, other)
validation

# %%
series = estimate.predict(other)
worst = np.nanmax(np.abs(series["predicted"] - series["measured"]), axis=0)
dict(zip(model.coordinates, worst.round(2)))
