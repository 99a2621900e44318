"""MuJoCo's inverse dynamics of the model that is written are those of the estimate."""

from pathlib import Path

import numpy as np
import pytest

import rist

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed: its inverse dynamics are not compared")

ROOT = Path(__file__).parents[3]


def test_inverse_dynamics_agree(tmp_path):
    model = rist.Model.read(ROOT / "models/ur5.urdf")
    estimate = rist.identify(model, ROOT / "docs/ur5/log.csv", consistent=True)
    estimate.write_mjcf(tmp_path / "ur5.xml", anyway=True)
    simulator = mujoco.MjModel.from_xml_path(str(tmp_path / "ur5.xml"))
    simulator.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    assert [simulator.joint(i).name for i in range(simulator.njnt)] == model.coordinates
    simulator.dof_damping[:] = 0
    simulator.dof_frictionloss[:] = 0
    q, dq, ddq = np.random.default_rng(1).normal(size=(3, 20, 6))
    values = dict(zip(estimate.names, estimate.values))
    x = np.array([values[name] for name in model.base_parameters.names])
    expected = model.base_regressor(q, dq, ddq) @ x
    data = mujoco.MjData(simulator)
    for k in range(20):
        data.qpos[:], data.qvel[:], data.qacc[:] = q[k], dq[k], ddq[k]
        mujoco.mj_inverse(simulator, data)
        # Sums of a few hundred terms of up to 80 N m.
        np.testing.assert_allclose(data.qfrc_inverse, expected[k], atol=1e-11)
